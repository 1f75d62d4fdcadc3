#include "engine/organ/placement_system.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/error.h"
#include "engine/energy/compressed_quadrature.h"
#include "engine/energy/mixed_dilatation.h"
#include "engine/tissue/support.h"

namespace hpdm {
namespace {

// Raises the stiffness, so that functions which others span keep a pivot: up to 1e5 times this, since
// such a function may have a small share in what it is spanned by.
constexpr double kRaised = 1e-10;
constexpr double kSpanned = 1e-2;  // pivot over stiffness of a function that the others span
constexpr double kLeastShareOfTissue = 0.02;  // share of a function that is tissue
constexpr double kHeld = 0.01;  // value of a function in a fixed support from which it is left out
constexpr int kGradientSteps = 4;  // of the error's estimate
// Points of a finest cell keep the moments of this degree.
constexpr int kPlacementMoments = 1;

WeightMatrix AtLoad(const Lattice& lattice, const PlacementLoad& load) {
  return lattice.Weights(load.points, load.points - lattice.inset() * load.normals);
}

// Returns the rows of 3 x cases per function as n x 3 cases: column 3 c + i.
Eigen::MatrixXd ByFunction(const Eigen::MatrixXd& U) {
  Eigen::MatrixXd sorted(U.rows() / 3, 3 * U.cols());
  for (Eigen::Index c = 0; c < U.cols(); ++c) {
    for (Eigen::Index a = 0; a < sorted.rows(); ++a) {
      for (int i = 0; i < 3; ++i) sorted(a, 3 * c + i) = U(3 * a + i, c);
    }
  }
  return sorted;
}

}  // namespace

PlacementSystem::PlacementSystem(const Lattice& coarse, const OrganOptions& organ,
                                 const Quadrature& tissue, const std::vector<Quadrature>& regions,
                                 const std::vector<PlacementCase>& cases)
    : coarse_(coarse), organ_(organ), regions_(regions), cases_(cases) {
  for (int level = 1; level <= organ.lattice.adaptive.levels; ++level) {
    levels_.push_back({Level(level), {}, {}, {}, {}, {}, {}});
  }
  points_ = CompressedQuadrature(levels_.back().lattice, nullptr, tissue, kPlacementMoments);
  for (PlacementLevel& level : levels_) Prepare(&level);
}

Lattice PlacementSystem::Level(int level) const {
  LatticeOptions options = organ_.lattice;
  for (int d = 0; d < 3; ++d) {
    options.cells[d] = coarse_.basis().axis(d).cells() << level;
  }
  Lattice lattice(coarse_.box(), options);
  // Gaps that the coarse functions do not see are not split either: copies at the voxels' own scale
  // come apart where the tissue does not. Local functions join what is joined a cell beside them; here
  // that would tie the sides of a slit near its end.
  if (coarse_.split()) lattice.SplitByTissue(coarse_.pieces());
  return lattice;
}

void PlacementSystem::Prepare(PlacementLevel* level) {
  Lattice& lattice = level->lattice;
  const Eigen::VectorXd volumes = lattice.Weights(points_.points).transpose() * points_.weights;
  double cell = lattice.box().lengths.prod();  // the integral of a whole function
  for (int d = 0; d < 3; ++d) cell /= lattice.basis().axis(d).cells();
  std::vector<bool> drop(static_cast<std::size_t>(lattice.size()));
  for (int a = 0; a < lattice.size(); ++a) drop[a] = !(volumes[a] >= kLeastShareOfTissue * cell);
  for (std::size_t s = 0; s < regions_.size(); ++s) {
    if (organ_.supports[s].stiffness) continue;
    for (Eigen::Index q = 0; q < regions_[s].weights.size(); ++q) {
      lattice.ForEachFunction(Vector3d(regions_[s].points.row(q)), [&](int b, double value) {
        if (value > kHeld) drop[static_cast<std::size_t>(b)] = true;
      });
    }
  }
  lattice.DropControlPoints(drop);
  const auto count = static_cast<std::size_t>(lattice.size());
  level->used.assign(count, false);
  level->refused.assign(count, false);
  level->gradients = lattice.GradientWeights(points_.points);
  for (const Quadrature& region : regions_) {
    level->held.push_back(lattice.Weights(region.points));
  }
  for (const PlacementCase& together : cases_) {
    std::vector<WeightMatrix>& loaded = level->loaded.emplace_back();
    for (const PlacementLoad& load : together) loaded.push_back(AtLoad(lattice, load));
  }
  level->own = OwnStiffness(*level);
}

std::vector<Matrix3d> PlacementSystem::OwnStiffness(const PlacementLevel& level) const {
  const LameParameters lame = ToLame(organ_.material);
  const double pointwise = ShareLambda(lame, Dilatation::kProjected).pointwise;
  std::vector<Matrix3d> own(level.used.size(), Matrix3d::Zero());
  for (Eigen::Index q = 0; q < points_.weights.size(); ++q) {
    WeightMatrix::InnerIterator y(level.gradients[1], q), z(level.gradients[2], q);
    for (WeightMatrix::InnerIterator x(level.gradients[0], q); x; ++x, ++y, ++z) {
      const Vector3d g(x.value(), y.value(), z.value());
      own[static_cast<std::size_t>(x.col())] +=
          points_.weights[q] * (lame.mu * g.squaredNorm() * Matrix3d::Identity() +
                                (lame.mu + pointwise) * g * g.transpose());
    }
  }
  for (std::size_t s = 0; s < regions_.size(); ++s) {
    const double spring = Spring(s, level.lattice);
    for (Eigen::Index q = 0; q < regions_[s].weights.size(); ++q) {
      for (WeightMatrix::InnerIterator it(level.held[s], q); it; ++it) {
        own[static_cast<std::size_t>(it.col())].diagonal().array() +=
            spring * regions_[s].weights[q] * it.value() * it.value();
      }
    }
  }
  return own;
}

double PlacementSystem::Spring(std::size_t support, const Lattice& lattice) const {
  const std::optional<double>& stiffness = organ_.supports[support].stiffness;
  return stiffness ? *stiffness : FixedSupport(lattice, organ_.material.young);
}

// Returns the coarse lattice with the functions in use.
Lattice PlacementSystem::Assemble() const {
  std::size_t levels = 0;  // up to the last one in use
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    const std::vector<bool>& used = levels_[level].used;
    if (std::find(used.begin(), used.end(), true) != used.end()) levels = level + 1;
  }
  Lattice lattice = coarse_;
  for (std::size_t level = 0; level < levels; ++level) {
    Lattice finer = levels_[level].lattice;
    std::vector<bool> drop = levels_[level].used;
    drop.flip();
    finer.DropControlPoints(drop);
    lattice.AddLevel(std::move(finer));
  }
  return lattice;
}

// Removes the functions in use that the others nearly span. True if there were any.
bool PlacementSystem::RefuseSpanned(const Lattice& lattice, const FullStiffness& K,
                                    const Eigen::MatrixXd& L) {
  bool any = false;
  int a = lattice.levels().empty() ? lattice.size() : lattice.FirstColumn(0);
  for (PlacementLevel& level : levels_) {
    for (std::size_t b = 0; b < level.used.size(); ++b) {
      if (!level.used[b]) continue;
      double least = 1;
      for (int d = 0; d < 3; ++d) {
        const Eigen::Index i = 3 * a + d;
        least = std::min(least, L(i, i) * L(i, i) / K(i, i));
      }
      ++a;
      if (least >= kSpanned) continue;
      level.used[b] = false;
      level.refused[b] = any = true;
    }
  }
  return any;
}

PlacementSolution PlacementSystem::Solve() {
  PlacementSolution solution{Assemble(), {}, {}, cases_, {}, {}};
  FullStiffness K = Stiffness(solution.lattice);
  Eigen::LLT<Eigen::MatrixXd> llt(K);
  if (llt.info() == Eigen::Success && RefuseSpanned(solution.lattice, K, llt.matrixL())) {
    solution.lattice = Assemble();
    K = Stiffness(solution.lattice);
    llt.compute(K);
  }
  if (llt.info() != Eigen::Success) {
    throw InputError("organ \"" + organ_.name +
                     "\": adaptive functions cannot be placed, because its stiffness is not "
                     "positive definite; add an [[organ.support]] or give adaptive_functions = 0");
  }
  solution.U.resize(K.rows(), static_cast<Eigen::Index>(cases_.size()));
  solution.energies.resize(solution.U.cols());
  for (Eigen::Index c = 0; c < solution.U.cols(); ++c) SolveCase(llt, c, &solution);
  MeasureStress(&solution);
  return solution;
}

FullStiffness PlacementSystem::Stiffness(const Lattice& lattice) const {
  FullStiffness K = StrainStiffness(lattice, points_, organ_.material, Dilatation::kProjected);
  AddAlongEachAxis(
      SupportStiffness(lattice, points_, organ_.supports, regions_, organ_.material.young), &K);
  // Functions that others span keep a pivot.
  K.diagonal() *= 1 + kRaised;
  return K;
}

// Solves a case and turns its given displacements into forces.
void PlacementSystem::SolveCase(const Eigen::LLT<Eigen::MatrixXd>& llt, Eigen::Index number,
                                PlacementSolution* solution) {
  PlacementCase& together = solution->cases[static_cast<std::size_t>(number)];
  const Lattice& lattice = solution->lattice;
  Points force = Points::Zero(lattice.size(), 3);
  std::vector<Eigen::VectorXd> rows;
  std::vector<PlacementLoad*> moved;
  Eigen::VectorXd demand(0);
  for (PlacementLoad& load : together) {
    const WeightMatrix weights = AtLoad(lattice, load);
    force += weights.transpose() * load.forces;
    if (!load.displacement_W) continue;
    rows.emplace_back(weights.transpose() * load.weights);
    moved.push_back(&load);
    demand.conservativeResize(demand.size() + 3);
    demand.tail<3>() = *load.displacement_W;
  }
  Eigen::VectorXd f = Eigen::Map<Eigen::VectorXd>(force.data(), force.size());
  if (!moved.empty()) {
    Eigen::MatrixXd R = Eigen::MatrixXd::Zero(f.size(), demand.size());
    for (std::size_t m = 0; m < rows.size(); ++m) {
      for (Eigen::Index a = 0; a < rows[m].size(); ++a) {
        for (int d = 0; d < 3; ++d) R(3 * a + d, static_cast<Eigen::Index>(3 * m) + d) = rows[m][a];
      }
    }
    const Eigen::MatrixXd Y = llt.solve(R);
    const Eigen::VectorXd found =
        Eigen::MatrixXd(R.transpose() * Y).ldlt().solve(demand - Y.transpose() * f);
    f += R * found;
    for (std::size_t m = 0; m < moved.size(); ++m) {
      moved[m]->forces =
          moved[m]->weights * found.segment<3>(static_cast<Eigen::Index>(3 * m)).transpose();
    }
  }
  solution->U.col(number) = llt.solve(f);
  solution->energies[number] = f.dot(solution->U.col(number));
}

// Returns w sigma e_j (j = 0..2, each Q x 3 cases) of the field with these gradients (element j:
// d u / d x_j). `projected`: w lambda theta of the projected dilatation, Q x cases, or empty.
std::array<Eigen::MatrixXd, 3> PlacementSystem::Stress(
    const std::array<Eigen::MatrixXd, 3>& gradient, const Eigen::MatrixXd& projected) const {
  const LameParameters lame = ToLame(organ_.material);
  const double pointwise = ShareLambda(lame, Dilatation::kProjected).pointwise;
  std::array<Eigen::MatrixXd, 3> stress = gradient;
  for (Eigen::Index q = 0; q < points_.weights.size(); ++q) {
    const double w = points_.weights[q];
    for (Eigen::Index c = 0; c < gradient[0].cols() / 3; ++c) {
      Matrix3d F;
      for (int j = 0; j < 3; ++j) F.col(j) = gradient[j].block<1, 3>(q, 3 * c).transpose();
      Matrix3d sigma = w * lame.mu * (F + F.transpose());
      sigma.diagonal().array() += w * pointwise * F.trace();
      if (projected.size() > 0) sigma.diagonal().array() += projected(q, c);
      for (int j = 0; j < 3; ++j) stress[j].block<1, 3>(q, 3 * c) = sigma.col(j).transpose();
    }
  }
  return stress;
}

void PlacementSystem::MeasureStress(PlacementSolution* solution) const {
  const std::array<WeightMatrix, 3> gradients = solution->lattice.GradientWeights(points_.points);
  const Eigen::MatrixXd U = ByFunction(solution->U);
  std::array<Eigen::MatrixXd, 3> gradient;
  for (int j = 0; j < 3; ++j) gradient[j] = gradients[j] * U;
  const DilatationShare share = ShareLambda(ToLame(organ_.material), Dilatation::kProjected);
  Eigen::MatrixXd projected;
  if (share.projected > 0) {
    const CoarserSplines splines(solution->lattice, points_);
    Eigen::MatrixXd dilatation(points_.weights.size(), solution->U.cols());
    for (Eigen::Index c = 0; c < dilatation.cols(); ++c) {
      dilatation.col(c) =
          gradient[0].col(3 * c) + gradient[1].col(3 * c + 1) + gradient[2].col(3 * c + 2);
    }
    Eigen::MatrixXd moments = splines.weighted_values().transpose() * dilatation;
    splines.factor().triangularView<Eigen::Lower>().solveInPlace(moments);
    splines.factor().triangularView<Eigen::Lower>().adjoint().solveInPlace(moments);
    projected = share.projected * (splines.weighted_values() * moments);
  }
  solution->stress = Stress(gradient, projected);
  for (std::size_t s = 0; s < regions_.size(); ++s) {
    const Quadrature& region = regions_[s];
    const Eigen::MatrixXd u = solution->lattice.Weights(region.points) * U;
    const double spring = Spring(s, solution->lattice);
    Eigen::MatrixXd force = spring * region.weights.asDiagonal() * u;
    if (!organ_.supports[s].stiffness && region.weights.size() > 0) {
      const CoarserSplines splines(solution->lattice, region);
      Eigen::MatrixXd moments = splines.weighted_values().transpose() * u;
      splines.factor().triangularView<Eigen::Lower>().solveInPlace(moments);
      splines.factor().triangularView<Eigen::Lower>().adjoint().solveInPlace(moments);
      force = spring * (splines.weighted_values() * moments);
    }
    solution->held.push_back(std::move(force));
  }
}

// Returns r of each candidate and case: N x 3 cases.
Eigen::MatrixXd PlacementSystem::Residual(const PlacementLevel& level,
                                          const PlacementSolution& solution) const {
  Eigen::MatrixXd r =
      Eigen::MatrixXd::Zero(level.lattice.size(), 3 * static_cast<Eigen::Index>(cases_.size()));
  for (std::size_t c = 0; c < cases_.size(); ++c) {
    for (std::size_t l = 0; l < cases_[c].size(); ++l) {
      r.middleCols<3>(static_cast<Eigen::Index>(3 * c)) +=
          level.loaded[c][l].transpose() * solution.cases[c][l].forces;
    }
  }
  for (int j = 0; j < 3; ++j) r -= level.gradients[j].transpose() * solution.stress[j];
  for (std::size_t s = 0; s < regions_.size(); ++s) {
    r -= level.held[s].transpose() * solution.held[s];
  }
  return r;
}

std::vector<Eigen::MatrixXd> PlacementSystem::Residuals(const PlacementSolution& solution) const {
  std::vector<Eigen::MatrixXd> residuals;
  for (const PlacementLevel& level : levels_) residuals.push_back(Residual(level, solution));
  return residuals;
}

// Takes steps of conjugate gradients over all candidates that are left out, with u held, and adds
// up the energies that they gain.
double PlacementSystem::Error(const std::vector<Eigen::MatrixXd>& residuals,
                              const PlacementSolution& solution) const {
  const auto cases = static_cast<Eigen::Index>(cases_.size());
  std::vector<Eigen::MatrixXd> r = residuals, p(r.size());
  for (std::size_t l = 0; l < r.size(); ++l) {
    for (std::size_t b = 0; b < levels_[l].used.size(); ++b) {
      if (levels_[l].used[b]) r[l].row(static_cast<Eigen::Index>(b)).setZero();
    }
  }
  Eigen::VectorXd gained = Eigen::VectorXd::Zero(cases), last = gained;
  for (int step = 0; step < kGradientSteps; ++step) {
    Eigen::VectorXd rz = Eigen::VectorXd::Zero(cases), pAp = rz;
    std::vector<Eigen::MatrixXd> z = r;
    for (std::size_t l = 0; l < r.size(); ++l) {
      for (Eigen::Index b = 0; b < r[l].rows(); ++b) {
        const Eigen::LLT<Matrix3d> own(levels_[l].own[static_cast<std::size_t>(b)]);
        for (Eigen::Index c = 0; c < cases; ++c) {
          const Vector3d rb = r[l].block<1, 3>(b, 3 * c);
          const Vector3d zb = own.solve(rb);
          z[l].block<1, 3>(b, 3 * c) = zb.transpose();
          rz[c] += rb.dot(zb);
        }
      }
    }
    std::array<Eigen::MatrixXd, 3> gradient;
    for (int j = 0; j < 3; ++j) {
      gradient[j] = Eigen::MatrixXd::Zero(points_.weights.size(), 3 * cases);
    }
    std::vector<Eigen::MatrixXd> u;
    for (const Quadrature& region : regions_) {
      u.push_back(Eigen::MatrixXd::Zero(region.weights.size(), 3 * cases));
    }
    for (std::size_t l = 0; l < r.size(); ++l) {
      if (step == 0) p[l] = z[l];
      for (Eigen::Index c = 0; step > 0 && c < cases; ++c) {
        p[l].middleCols<3>(3 * c) =
            (z[l].middleCols<3>(3 * c) + rz[c] / last[c] * p[l].middleCols<3>(3 * c)).eval();
      }
      for (int j = 0; j < 3; ++j) gradient[j] += levels_[l].gradients[j] * p[l];
      for (std::size_t s = 0; s < u.size(); ++s) u[s] += levels_[l].held[s] * p[l];
    }
    last = rz;
    const std::array<Eigen::MatrixXd, 3> stress = Stress(gradient, Eigen::MatrixXd());
    for (std::size_t s = 0; s < u.size(); ++s) {
      u[s] = (Spring(s, solution.lattice) * regions_[s].weights).asDiagonal() * u[s];
    }
    std::vector<Eigen::MatrixXd> Ap;
    for (std::size_t l = 0; l < r.size(); ++l) {
      Eigen::MatrixXd& of = Ap.emplace_back(Eigen::MatrixXd::Zero(r[l].rows(), 3 * cases));
      for (int j = 0; j < 3; ++j) of += levels_[l].gradients[j].transpose() * stress[j];
      for (std::size_t s = 0; s < u.size(); ++s) of += levels_[l].held[s].transpose() * u[s];
      for (std::size_t b = 0; b < levels_[l].used.size(); ++b) {
        if (levels_[l].used[b]) of.row(static_cast<Eigen::Index>(b)).setZero();
      }
      for (Eigen::Index c = 0; c < cases; ++c) {
        pAp[c] += p[l].middleCols<3>(3 * c).cwiseProduct(of.middleCols<3>(3 * c)).sum();
      }
    }
    for (Eigen::Index c = 0; c < cases; ++c) {
      if (!(pAp[c] > 0) || !(rz[c] > 0)) continue;
      const double alpha = rz[c] / pAp[c];
      gained[c] += alpha * rz[c];
      for (std::size_t l = 0; l < r.size(); ++l) {
        r[l].middleCols<3>(3 * c) -= alpha * Ap[l].middleCols<3>(3 * c);
      }
    }
  }
  return std::sqrt(gained.cwiseQuotient(solution.energies).mean());
}

}  // namespace hpdm
