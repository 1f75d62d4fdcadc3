#include "engine/energy/finite_strain_energy.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <utility>

#include "engine/energy/hyperelastic.h"
#include "engine/energy/mixed_dilatation.h"

namespace hpdm {
namespace {

std::vector<int> ColumnsAt(const WeightMatrix& weights, Eigen::Index row) {
  std::vector<int> columns;
  if (weights.cols() == 0) return columns;
  for (WeightMatrix::InnerIterator it(weights, row); it; ++it) columns.push_back(it.index());
  return columns;
}

// Appends the row `row` of each matrix to the lane of the last block, whose entries begin at
// `first`.
template <std::size_t n>
void FillLane(const std::array<const WeightMatrix*, n>& rows, Eigen::Index row, int lane,
              std::size_t first, std::vector<Lanes>* lanes) {
  for (std::size_t d = 0; d < n; ++d) {
    if (rows[d]->cols() == 0) continue;
    std::size_t at = first + d;
    for (WeightMatrix::InnerIterator it(*rows[d], row); it; ++it, at += n) {
      (*lanes)[at][lane] = it.value();
    }
  }
}

Matrix3d MatrixAtLane(const Lanes* F, int lane) {
  Matrix3d at;
  for (int k = 0; k < 9; ++k) at.data()[k] = F[k][lane];
  return at;
}

Lanes OneInEachLane() { return {1, 1, 1, 1, 1, 1, 1, 1}; }

void AddScaled(double factor, const Lanes& x, Lanes* sum) {
  for (int l = 0; l < kLanes; ++l) (*sum)[l] += factor * x[l];
}

}  // namespace

FiniteStrainEnergy::FiniteStrainEnergy(const Lattice& lattice, const Quadrature& tissue,
                                       MaterialLaw law, const LameParameters& lame,
                                       Dilatation dilatation, const ScalarStiffness& supports,
                                       const Lattice* finer)
    : kernels_(&StrainKernelsFor(WidestVectors())) {
  auto body = std::make_shared<Body>();
  const DilatationShare share = ShareLambda(lame, dilatation);
  body->n = lattice.size();
  body->law = {law, lame.mu, share.pointwise};
  body->lambda = share.projected;
  body->supports = supports;
  body->support_stiffness = FullStiffness::Zero(3 * body->n, 3 * body->n);
  AddAlongEachAxis(supports, &body->support_stiffness);
  const Eigen::Index count = tissue.weights.size();
  WeightMatrix moments(count, 0);
  if (body->lambda > 0) {
    const CoarserSplines splines(lattice, tissue);
    moments = splines.weighted_values();
    body->inverse_mass = Eigen::MatrixXd::Identity(moments.cols(), moments.cols());
    splines.factor().triangularView<Eigen::Lower>().solveInPlace(body->inverse_mass);
    body->inverse_mass = (body->inverse_mass.transpose() * body->inverse_mass).eval();
  }
  const std::array<WeightMatrix, 3> gradients = lattice.GradientWeights(tissue.points);
  std::array<WeightMatrix, 3> finer_gradients;
  if (finer != nullptr) finer_gradients = finer->GradientWeights(tissue.points);
  // Points come cell by cell, so points with the same functions follow each other.
  for (Eigen::Index begin = 0, end = 0; begin < count; begin = end) {
    const auto functions = [&](Eigen::Index q) {
      return std::array{ColumnsAt(gradients[0], q), ColumnsAt(finer_gradients[0], q),
                        ColumnsAt(moments, q)};
    };
    const auto at_begin = functions(begin);
    while (end < count && functions(end) == at_begin) ++end;
    AddCell(gradients, finer_gradients, moments, tissue.weights, begin, end, body.get());
  }
  body->mean_gradients = Points::Zero(body->n, 3);
  body->own_stiffness.resize(finer != nullptr ? static_cast<std::size_t>(finer->size()) : 0);
  for (const Cell& cell : body->cells) AddMeans(cell, body.get());
  body->mean_gradients /= tissue.weights.sum();
  for (double& stiffness : body->own_stiffness) stiffness *= (4 * lame.mu + lame.lambda) / 3;
  body_ = body;
  if (finer != nullptr) {
    for (const Cell& cell : body->cells) {
      const std::size_t functions = cell.functions.size();
      refined_.push_back(
          {0, std::vector<int>(functions), std::vector<int>(functions),
           std::vector<Lanes>(3 * static_cast<std::size_t>(cell.blocks) * functions)});
    }
  }
  const std::size_t blocks = body->weights.size();
  F_.resize(9 * blocks);
  slope_ = F_;
  theta_.resize(blocks);
  lattice_F_ = lattice_slope_ = F_;
  lattice_theta_ = theta_;
  pressure_.setZero(moments.cols());
  moment_ = own_moment_ = own_pressure_ = pressure_;
  std::size_t most = 0, functions_most = 0;
  for (const Cell& cell : body->cells) {
    most = std::max(most, static_cast<std::size_t>(cell.blocks));
    functions_most = std::max(functions_most, cell.columns.size() + cell.functions.size());
  }
  stress_.resize(9 * most);
  pressures_.resize(most);
  own_pressures_.resize(most);
  local_.resize(3 * functions_most);
}

void FiniteStrainEnergy::AddCell(const std::array<WeightMatrix, 3>& gradients,
                                 const std::array<WeightMatrix, 3>& finer_gradients,
                                 const WeightMatrix& moments, const Eigen::VectorXd& weights,
                                 Eigen::Index begin, Eigen::Index end, Body* body) {
  Cell cell;
  cell.columns = ColumnsAt(gradients[0], begin);
  cell.functions = ColumnsAt(finer_gradients[0], begin);
  cell.coarser = ColumnsAt(moments, begin);
  cell.first = static_cast<int>(body->weights.size());
  cell.blocks = static_cast<int>((end - begin + kLanes - 1) / kLanes);
  cell.gradients = body->gradients.size();
  cell.finer_gradients = body->finer_gradients.size();
  cell.moments = body->moments.size();
  const auto blocks = static_cast<std::size_t>(cell.blocks);
  body->weights.resize(body->weights.size() + blocks);
  body->gradients.resize(cell.gradients + 3 * blocks * cell.columns.size());
  body->finer_gradients.resize(cell.finer_gradients + 3 * blocks * cell.functions.size());
  body->moments.resize(cell.moments + blocks * cell.coarser.size());
  for (Eigen::Index q = begin; q < end; ++q) {
    const auto block = static_cast<std::size_t>((q - begin) / kLanes);
    const int lane = static_cast<int>((q - begin) % kLanes);
    body->weights[static_cast<std::size_t>(cell.first) + block][lane] = weights[q];
    FillLane<3>({&gradients[0], &gradients[1], &gradients[2]}, q, lane,
                cell.gradients + 3 * block * cell.columns.size(), &body->gradients);
    FillLane<3>({&finer_gradients[0], &finer_gradients[1], &finer_gradients[2]}, q, lane,
                cell.finer_gradients + 3 * block * cell.functions.size(), &body->finer_gradients);
    FillLane<1>({&moments}, q, lane, cell.moments + block * cell.coarser.size(), &body->moments);
  }
  body->cells.push_back(std::move(cell));
}

// Adds a cell's part of int grad phi_a dV and of int |grad psi|^2 dV.
void FiniteStrainEnergy::AddMeans(const Cell& cell, Body* body) {
  for (int block = 0; block < cell.blocks; ++block) {
    const auto place = static_cast<std::size_t>(block);
    const Lanes& weights = body->weights[static_cast<std::size_t>(cell.first) + place];
    for (int l = 0; l < kLanes; ++l) {
      for (std::size_t a = 0; a < cell.columns.size(); ++a) {
        const Lanes* const g =
            body->gradients.data() + cell.gradients + 3 * (place * cell.columns.size() + a);
        for (int d = 0; d < 3; ++d) {
          body->mean_gradients(cell.columns[a], d) += weights[l] * g[d][l];
        }
      }
      for (std::size_t f = 0; f < cell.functions.size(); ++f) {
        const Lanes* const g = body->finer_gradients.data() + cell.finer_gradients +
                               3 * (place * cell.functions.size() + f);
        for (int d = 0; d < 3; ++d) {
          body->own_stiffness[static_cast<std::size_t>(cell.functions[f])] +=
              weights[l] * g[d][l] * g[d][l];
        }
      }
    }
  }
}

Matrix3d FiniteStrainEnergy::MeanRotation(const Points& U) {
  const Matrix3d F = Matrix3d::Identity() + U.topRows(body_->n).transpose() * body_->mean_gradients;
  const Eigen::JacobiSVD<Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d left = svd.matrixU();
  if ((left * svd.matrixV().transpose()).determinant() < 0) left.col(2) *= -1;
  return left * svd.matrixV().transpose();
}

void FiniteStrainEnergy::SetActiveFunctions(const ActiveRefinement& active) {
  fading_.resize(static_cast<std::size_t>(active.slots()));
  for (int slot = 0; slot < active.slots(); ++slot) {
    const int function = active.Function(slot);
    // An empty slot moves nothing and gets a stiffness, so that the Hessian is regular.
    fading_[static_cast<std::size_t>(slot)] =
        function < 0 ? body_->law.mu
                     : (1 / active.Weight(slot) - 1) *
                           body_->own_stiffness[static_cast<std::size_t>(function)];
  }
  for (std::size_t c = 0; c < refined_.size(); ++c) {
    const Cell& cell = body_->cells[c];
    Refined& refined = refined_[c];
    refined.count = 0;
    for (std::size_t f = 0; f < cell.functions.size(); ++f) {
      const int slot = active.Slot(cell.functions[f]);
      if (slot < 0) continue;
      refined.places[static_cast<std::size_t>(refined.count)] = static_cast<int>(f);
      refined.slots[static_cast<std::size_t>(refined.count++)] = slot;
    }
    Lanes* to = refined.gradients.data();
    for (int block = 0; block < cell.blocks && refined.count > 0; ++block) {
      const Lanes* const all = body_->finer_gradients.data() + cell.finer_gradients +
                               3 * static_cast<std::size_t>(block) * cell.functions.size();
      for (int k = 0; k < refined.count; ++k) {
        to = std::copy_n(all + 3 * refined.places[static_cast<std::size_t>(k)], 3, to);
      }
    }
  }
}

// Computes F, theta and d theta/dF at all points.
void FiniteStrainEnergy::Deform(const Points& U) {
  for (std::size_t c = 0; c < body_->cells.size(); ++c) {
    const Cell& cell = body_->cells[c];
    const auto first = static_cast<std::size_t>(cell.first);
    const int columns = static_cast<int>(cell.columns.size());
    for (int a = 0; a < columns; ++a) {
      for (int d = 0; d < 3; ++d) local_[3 * a + d] = U(cell.columns[a], d);
    }
    const bool refined = IsRefined(c);
    Lanes* F = F_.data() + 9 * first;
    const auto deform = [&](Lanes* to) {
      std::fill_n(to, 9 * cell.blocks, Lanes{});
      for (int block = 0; block < cell.blocks; ++block) {
        for (int d = 0; d < 3; ++d) to[9 * block + 4 * d] = OneInEachLane();
      }
      kernels_->add_gradients(body_->gradients.data() + cell.gradients, cell.blocks, columns,
                              local_.data(), to);
    };
    if (refined) {
      Lanes* const alone = lattice_F_.data() + 9 * first;
      deform(alone);
      kernels_->dilate(body_->law, alone, cell.blocks, lattice_theta_.data() + first,
                       lattice_slope_.data() + 9 * first);
      std::copy_n(alone, 9 * cell.blocks, F);
      const Refined& finer = refined_[c];
      for (int s = 0; s < finer.count; ++s) {
        for (int d = 0; d < 3; ++d) local_[3 * s + d] = U(body_->n + finer.slots[s], d);
      }
      kernels_->add_gradients(finer.gradients.data(), cell.blocks, finer.count, local_.data(), F);
    } else {
      deform(F);
    }
    kernels_->dilate(body_->law, F, cell.blocks, theta_.data() + first, slope_.data() + 9 * first);
  }
}

// Computes the pressures of the projected dilatations.
void FiniteStrainEnergy::Project() {
  moment_.setZero();
  own_moment_.setZero();
  if (body_->lambda == 0) return;
  for (std::size_t c = 0; c < body_->cells.size(); ++c) {
    const Cell& cell = body_->cells[c];
    const bool refined = IsRefined(c);
    const std::size_t count = cell.coarser.size();
    for (std::size_t b = 0; b < count; ++b) {
      Lanes sum = {}, own = {};
      for (int block = 0; block < cell.blocks; ++block) {
        const Lanes& moment =
            body_->moments[cell.moments + static_cast<std::size_t>(block) * count + b];
        const auto at = static_cast<std::size_t>(cell.first + block);
        for (int l = 0; l < kLanes; ++l) sum[l] += theta_[at][l] * moment[l];
        if (!refined) continue;
        for (int l = 0; l < kLanes; ++l) {
          own[l] += (theta_[at][l] - lattice_theta_[at][l]) * moment[l];
        }
      }
      moment_[cell.coarser[b]] += SumOfLanes(sum);
      if (refined) own_moment_[cell.coarser[b]] += SumOfLanes(own);
    }
  }
  pressure_.noalias() = body_->lambda * (body_->inverse_mass * moment_);
  own_pressure_.noalias() = body_->lambda * (body_->inverse_mass * own_moment_);
}

// Computes the pressures of a cell's points times their weights: the factor of d theta/dF of all
// functions and, in a refined cell, of the lattice alone.
void FiniteStrainEnergy::FillPressures(std::size_t c) {
  const Cell& cell = body_->cells[c];
  const auto first = static_cast<std::size_t>(cell.first);
  const bool refined = IsRefined(c);
  Lanes* const pressure = pressures_.data();
  Lanes* const own = own_pressures_.data();
  const std::size_t count = cell.coarser.size();
  for (int block = 0; block < cell.blocks; ++block) {
    pressure[block] = own[block] = Lanes{};
    const Lanes* const moments =
        body_->moments.data() + cell.moments + static_cast<std::size_t>(block) * count;
    for (std::size_t b = 0; b < count; ++b) {
      AddScaled(pressure_[cell.coarser[b]], moments[b], pressure + block);
    }
    if (!refined) continue;
    for (std::size_t b = 0; b < count; ++b) {
      AddScaled(own_pressure_[cell.coarser[b]], moments[b], own + block);
    }
    const std::size_t at = first + static_cast<std::size_t>(block);
    for (int l = 0; l < kLanes; ++l) {
      own[block][l] -=
          body_->weights[at][l] * body_->lambda * (theta_[at][l] - lattice_theta_[at][l]);
      pressure[block][l] -= own[block][l];
    }
  }
}

// Adds a cell's forces and returns its energy without the projected part.
double FiniteStrainEnergy::AddStress(std::size_t c, Points* gradient) {
  const Cell& cell = body_->cells[c];
  const auto first = static_cast<std::size_t>(cell.first);
  const bool refined = IsRefined(c);
  FillPressures(c);
  double energy = kernels_->stress(body_->law, F_.data() + 9 * first, body_->weights.data() + first,
                                   pressures_.data(), theta_.data() + first,
                                   slope_.data() + 9 * first, cell.blocks, stress_.data());
  if (refined) {
    Lanes own = {};
    for (std::size_t at = first; at < first + static_cast<std::size_t>(cell.blocks); ++at) {
      for (int l = 0; l < kLanes; ++l) {
        const double theta = theta_[at][l] - lattice_theta_[at][l];
        own[l] += body_->weights[at][l] * theta * theta;
      }
    }
    energy += body_->lambda / 2 * SumOfLanes(own);
  }
  if (gradient == nullptr) return energy;
  if (refined) {
    const Refined& finer = refined_[c];
    std::fill_n(local_.begin(), 3 * finer.count, 0);
    kernels_->add_forces(finer.gradients.data(), cell.blocks, finer.count, stress_.data(),
                         local_.data());
    for (int s = 0; s < finer.count; ++s) {
      for (int d = 0; d < 3; ++d) (*gradient)(body_->n + finer.slots[s], d) += local_[3 * s + d];
    }
    const Lanes* const slope = lattice_slope_.data() + 9 * first;
    for (int block = 0; block < cell.blocks; ++block) {
      for (int k = 9 * block; k < 9 * (block + 1); ++k) {
        for (int l = 0; l < kLanes; ++l) stress_[k][l] += own_pressures_[block][l] * slope[k][l];
      }
    }
  }
  std::fill_n(local_.begin(), 3 * cell.columns.size(), 0);
  kernels_->add_forces(body_->gradients.data() + cell.gradients, cell.blocks,
                       static_cast<int>(cell.columns.size()), stress_.data(), local_.data());
  for (std::size_t a = 0; a < cell.columns.size(); ++a) {
    for (int d = 0; d < 3; ++d) (*gradient)(cell.columns[a], d) += local_[3 * a + d];
  }
  return energy;
}

double FiniteStrainEnergy::Gradient(const Points& U, Points* gradient) {
  Deform(U);
  Project();
  const auto lattice = U.topRows(body_->n);
  double energy = (moment_.dot(pressure_) - own_moment_.dot(own_pressure_)) / 2;
  if (gradient != nullptr) {
    gradient->setZero(U.rows(), 3);
    gradient->topRows(body_->n).noalias() = body_->supports * lattice;
    energy += lattice.cwiseProduct(gradient->topRows(body_->n)).sum() / 2;
  } else {
    energy += lattice.cwiseProduct(body_->supports * lattice).sum() / 2;
  }
  for (std::size_t c = 0; c < body_->cells.size(); ++c) energy += AddStress(c, gradient);
  for (std::size_t s = 0; s < fading_.size(); ++s) {
    const auto row = static_cast<Eigen::Index>(s) + body_->n;
    energy += fading_[s] / 2 * U.row(row).squaredNorm();
    if (gradient != nullptr) gradient->row(row) += fading_[s] * U.row(row);
  }
  return energy;
}

double FiniteStrainEnergy::Energy(const Points& U) { return Gradient(U, nullptr); }

double FiniteStrainEnergy::CollapsedShare(const Points& U) {
  Deform(U);
  const HyperelasticLaw law(body_->law.law, {body_->law.mu, body_->law.lambda});
  double collapsed = 0, all = 0;
  for (std::size_t block = 0; block < body_->weights.size(); ++block) {
    for (int l = 0; l < kLanes; ++l) {
      const double weight = body_->weights[block][l];
      all += weight;
      if (weight > 0 && law.Collapsed(MatrixAtLane(F_.data() + 9 * block, l))) collapsed += weight;
    }
  }
  return collapsed / all;
}

void FiniteStrainEnergy::Hessian(const Points& U, bool semi_definite, FullStiffness* K) {
  Deform(U);
  Project();
  const Eigen::Index lattice = 3 * body_->n;
  K->setZero(3 * U.rows(), 3 * U.rows());
  K->topLeftCorner(lattice, lattice) = body_->support_stiffness;
  for (std::size_t s = 0; s < fading_.size(); ++s) {
    K->diagonal().segment<3>(lattice + 3 * static_cast<Eigen::Index>(s)).array() += fading_[s];
  }
  if (body_->lambda > 0) AddDilatationStiffness(K);
  for (std::size_t c = 0; c < body_->cells.size(); ++c) AddTangent(c, semi_definite, K);
  K->triangularView<Eigen::StrictlyUpper>() = K->transpose();
}

// The functions of a cell: those of the lattice, then the local ones in use.
struct FiniteStrainEnergy::CellFunctions {
  std::vector<int> rows;         // of U
  std::vector<Lanes> gradients;  // blocks x functions x 3
  std::vector<Lanes> slopes;     // blocks x functions x 3: d theta / dU
  std::vector<Lanes> own;        // the same of theta_V
};

FiniteStrainEnergy::CellFunctions FiniteStrainEnergy::FunctionsOf(std::size_t c) const {
  const Cell& cell = body_->cells[c];
  const bool refined = IsRefined(c);
  CellFunctions functions;
  functions.rows = cell.columns;
  if (refined) {
    for (int k = 0; k < refined_[c].count; ++k) {
      functions.rows.push_back(body_->n + refined_[c].slots[static_cast<std::size_t>(k)]);
    }
  }
  const std::size_t finer = functions.rows.size() - cell.columns.size();
  for (std::size_t block = 0; block < static_cast<std::size_t>(cell.blocks); ++block) {
    const auto append = [&](const std::vector<Lanes>& from, std::size_t first, std::size_t count) {
      const auto begin = from.begin() + static_cast<std::ptrdiff_t>(first + 3 * block * count);
      functions.gradients.insert(functions.gradients.end(), begin,
                                 begin + static_cast<std::ptrdiff_t>(3 * count));
    };
    append(body_->gradients, cell.gradients, cell.columns.size());
    if (finer > 0) append(refined_[c].gradients, 0, finer);
  }
  functions.slopes.resize(functions.gradients.size());
  functions.own.resize(functions.gradients.size());
  const std::size_t count = functions.rows.size();
  for (std::size_t f = 0; f < functions.gradients.size() / 3; ++f) {
    const std::size_t at = static_cast<std::size_t>(cell.first) + f / count;
    const bool of_lattice = f % count < cell.columns.size();
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        const Lanes& g = functions.gradients[3 * f + j];
        for (int l = 0; l < kLanes; ++l) {
          functions.slopes[3 * f + i][l] += slope_[9 * at + 3 * j + i][l] * g[l];
          if (!refined || !of_lattice) continue;
          functions.own[3 * f + i][l] -= lattice_slope_[9 * at + 3 * j + i][l] * g[l];
        }
      }
      for (int l = 0; l < kLanes && refined; ++l) {
        functions.own[3 * f + i][l] += functions.slopes[3 * f + i][l];
      }
    }
  }
  return functions;
}

// Adds below the diagonal the second derivatives at a cell's points.
void FiniteStrainEnergy::AddTangent(std::size_t c, bool semi_definite, FullStiffness* K) {
  const Cell& cell = body_->cells[c];
  const bool refined = IsRefined(c);
  const auto first = static_cast<std::size_t>(cell.first);
  const CellFunctions functions = FunctionsOf(c);
  const std::size_t count = functions.rows.size(), blocks = static_cast<std::size_t>(cell.blocks);
  const HyperelasticLaw law(body_->law.law, {body_->law.mu, body_->law.lambda});
  FillPressures(c);
  std::vector<Lanes> tangents(81 * blocks), alone(refined ? 81 * blocks : 0), product(27 * blocks);
  for (std::size_t block = 0; block < blocks; ++block) {
    for (int l = 0; l < kLanes; ++l) {
      const double weight = body_->weights[first + block][l];
      if (!(weight > 0)) continue;
      const Matrix3d F = MatrixAtLane(F_.data() + 9 * (first + block), l);
      Matrix9d A = weight * law.Tangent(F);
      law.AddDilatationHessian(F, pressures_[block][l], &A);
      if (semi_definite) A = ProjectedToSemiDefinite(A);
      for (int k = 0; k < 81; ++k) tangents[81 * block + k][l] = A.data()[k];
      if (!refined || semi_definite) continue;
      A.setZero();
      law.AddDilatationHessian(MatrixAtLane(lattice_F_.data() + 9 * (first + block), l),
                               own_pressures_[block][l], &A);
      for (int k = 0; k < 81; ++k) alone[81 * block + k][l] = A.data()[k];
    }
  }
  std::vector<double> stiffness(9 * count);
  const auto add = [&](const std::vector<Lanes>& A, std::size_t a, int last) {
    std::fill(product.begin(), product.end(), Lanes{});
    for (std::size_t block = 0; block < blocks; ++block) {
      const Lanes* const g = functions.gradients.data() + 3 * (block * count + a);
      for (int k = 0; k < 27; ++k) {  // 9 l + 3 i + k
        for (int j = 0; j < 3; ++j) {
          const int row = 3 * j + k / 3 % 3, column = 3 * (k / 9) + k % 3;
          const Lanes& entry = A[81 * block + static_cast<std::size_t>(row + 9 * column)];
          for (int l = 0; l < kLanes; ++l) product[27 * block + k][l] += g[j][l] * entry[l];
        }
      }
    }
    kernels_->add_tangents(functions.gradients.data(), product.data(), cell.blocks,
                           static_cast<int>(count), last, stiffness.data());
  };
  for (std::size_t a = 0; a < count; ++a) {
    std::fill(stiffness.begin(), stiffness.end(), 0);
    add(tangents, a, static_cast<int>(a));
    if (refined && a < cell.columns.size()) add(alone, a, static_cast<int>(a));
    for (std::size_t b = 0; b <= a; ++b) {
      for (int k = 0; refined && k < 9; ++k) {
        for (std::size_t block = 0; block < blocks; ++block) {
          const Lanes& p = functions.own[3 * (block * count + a) + k / 3];
          const Lanes& q = functions.own[3 * (block * count + b) + k % 3];
          for (int l = 0; l < kLanes; ++l) {
            stiffness[9 * b + k] += body_->lambda * body_->weights[first + block][l] * p[l] * q[l];
          }
        }
      }
      for (int k = 0; k < 9; ++k) {
        const int p = 3 * functions.rows[a] + k / 3, q = 3 * functions.rows[b] + k % 3;
        if (a == b && p < q) continue;
        (*K)(std::max(p, q), std::min(p, q)) += stiffness[9 * b + k];
      }
    }
  }
}

// Adds lambda (D^T M^-1 D - D_V^T M^-1 D_V) below the diagonal, with D = int psi d theta / dU dV, D_V
// the same of theta_V, and M the mass matrix of the coarser splines psi.
void FiniteStrainEnergy::AddDilatationStiffness(FullStiffness* K) {
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(body_->inverse_mass.rows(), K->cols()), own = D;
  for (std::size_t c = 0; c < body_->cells.size(); ++c) {
    const Cell& cell = body_->cells[c];
    const CellFunctions functions = FunctionsOf(c);
    const std::size_t count = functions.rows.size();
    for (std::size_t block = 0; block < static_cast<std::size_t>(cell.blocks); ++block) {
      for (std::size_t b = 0; b < cell.coarser.size(); ++b) {
        const Lanes& moment = body_->moments[cell.moments + block * cell.coarser.size() + b];
        for (std::size_t k = 0; k < 3 * count; ++k) {
          const int column = 3 * functions.rows[k / 3] + static_cast<int>(k % 3);
          for (int l = 0; l < kLanes; ++l) {
            D(cell.coarser[b], column) += moment[l] * functions.slopes[3 * block * count + k][l];
            own(cell.coarser[b], column) += moment[l] * functions.own[3 * block * count + k][l];
          }
        }
      }
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> inverse(body_->inverse_mass);
  const Eigen::MatrixXd whole = inverse.matrixU() * D;
  K->selfadjointView<Eigen::Lower>().rankUpdate(whole.transpose(), body_->lambda);
  if (own_moment_.isZero(0) && refined_.empty()) return;
  const Eigen::MatrixXd part = inverse.matrixU() * own;
  K->selfadjointView<Eigen::Lower>().rankUpdate(part.transpose(), -body_->lambda);
}

}  // namespace hpdm
