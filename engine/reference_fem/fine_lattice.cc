#include "engine/reference_fem/fine_lattice.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>

#include "engine/base/error.h"
#include "engine/contact/surface_kernel.h"
#include "engine/energy/mixed_dilatation.h"
#include "engine/energy/strain_energy.h"
#include "engine/mesh/curved_surface.h"
#include "engine/mesh/thickness.h"
#include "engine/organ/organ_cuts.h"
#include "engine/tissue/stiffness_regions.h"
#include "engine/tissue/support.h"

namespace hpdm {
namespace {

// Gaps get front functions up to this many cells wider than an organ's own lattice would give them.
constexpr double kNotchCells = 3;
constexpr double kFinestResolved = 1.25;  // kernel radius in mean cells (kResolvedCells, organ.cc)

Lattice CubicCells(const OrganOptions& organ, const SurfaceMesh& rest, int cells) {
  const Vector3d tight = BoundingLatticeBox(rest.vertices, organ.X_WO.linear(), 0).lengths;
  const double side = tight.maxCoeff() / cells;
  // The margin keeps vertices off the box's faces, where rounding would decide.
  const OrientedBox box = BoundingLatticeBox(rest.vertices, organ.X_WO.linear(), 0.05 * side);
  LatticeOptions options;
  for (int d = 0; d < 3; ++d) {
    options.cells[d] = std::max(1, static_cast<int>(std::lround(box.lengths[d] / side)));
  }
  return {box, options};
}

Vector3d CellSize(const Lattice& lattice) {
  Vector3d size;
  for (int d = 0; d < 3; ++d) {
    size[d] = lattice.box().lengths[d] / lattice.basis().axis(d).cells();
  }
  return size;
}

}  // namespace

FineLattice::FineLattice(const OrganOptions& organ, const SurfaceMesh& rest, int cells)
    : organ_(organ),
      rest_(rest),
      bounds_(AxisAlignedBounds(rest.vertices)),
      topology_(rest.vertices.rows(), rest.triangles),
      lattice_(CubicCells(organ, rest, cells)) {
  VertexNormals(rest_.vertices, rest_.triangles, &normals_);
  FitNormals(rest_, SurfaceTopology(rest_.vertices.rows(), rest_.triangles),
             &normals_);  // as an organ's
  organ_.model = OrganModelType::kHpdm;
  organ_.lattice = LatticeOptions();
  organ_.energy = EnergyOptions();
  const TensorBasis& basis = lattice_.basis();
  std::vector<std::string> warnings;  // those of notches that stay as they are
  const CutSurfaces cuts = CutsOf(organ_, rest_, bounds_, lattice_.box(),
                                  kNotchCells * CellSize(lattice_).mean(), &warnings);
  const auto [sampled, stiffness] = SampleStiffness(
      rest, lattice_.box(), {basis.axis(0).cells(), basis.axis(1).cells(), basis.axis(2).cells()},
      organ_, cuts);
  const Quadrature elastic{sampled.points, sampled.weights.cwiseProduct(stiffness)};
  if (!sampled.pieces.empty()) {
    lattice_.SplitByTissue(std::make_shared<const TissuePieces>(sampled.pieces));
  }
  lattice_.DropControlPointsWithoutTissue({sampled.points, sampled.weights});
  if (cuts != nullptr && lattice_.pieces() != nullptr) lattice_.AddFrontFunctions();
  thickness_ = LocalThickness(rest_, normals_, 3 * kFinestResolved * CellSize(lattice_).mean());
  AddElasticity(sampled, elastic);
  AddSupports(elastic);
  Factorise();
}

std::vector<FineLattice::Cell> FineLattice::FindCells(const TissueQuadrature& sampled) const {
  std::vector<Cell> cells;
  const auto count = static_cast<Eigen::Index>(sampled.cells.size());
  for (Eigen::Index begin = 0, end = 0; begin < count; begin = end) {
    const int number = sampled.cells[static_cast<std::size_t>(begin)];
    Cell& cell = cells.emplace_back(Cell{begin, begin, {}});
    for (; end < count && sampled.cells[static_cast<std::size_t>(end)] == number; ++end) {
      lattice_.ForEachFunction(sampled.points.row(end).transpose(), [&cell](int column, double) {
        const auto place = std::lower_bound(cell.columns.begin(), cell.columns.end(), column);
        if (place == cell.columns.end() || *place != column) cell.columns.insert(place, column);
      });
    }
    cell.end = end;
  }
  return cells;
}

void FineLattice::FindNeighbours(const std::vector<Cell>& cells) {
  std::vector<std::vector<int>> around(static_cast<std::size_t>(lattice_.size()));
  for (const Cell& cell : cells) {
    for (const int a : cell.columns) {
      std::vector<int>& of_a = around[static_cast<std::size_t>(a)];
      of_a.insert(of_a.end(), cell.columns.begin(), cell.columns.end());
    }
  }
  first_ = {0};
  for (std::vector<int>& of_a : around) {
    std::sort(of_a.begin(), of_a.end());
    of_a.erase(std::unique(of_a.begin(), of_a.end()), of_a.end());
    neighbours_.insert(neighbours_.end(), of_a.begin(), of_a.end());
    first_.push_back(neighbours_.size());
    of_a = {};
  }
}

std::size_t FineLattice::Neighbour(int a, int b) const {
  const auto at = neighbours_.begin();
  const auto begin = at + static_cast<std::ptrdiff_t>(first_[static_cast<std::size_t>(a)]);
  const auto end = at + static_cast<std::ptrdiff_t>(first_[static_cast<std::size_t>(a) + 1]);
  return static_cast<std::size_t>(std::lower_bound(begin, end, b) - at);
}

void FineLattice::AddElasticity(const TissueQuadrature& sampled, const Quadrature& elastic) {
  const std::vector<Cell> cells = FindCells(sampled);
  FindNeighbours(cells);
  std::vector<double> blocks(neighbours_.size() * 9, 0);
  const LameParameters lame = ToLame(organ_.material);
  const DilatationShare share = ShareLambda(lame, Dilatation::kProjected);
  for (const Cell& cell : cells) AddCell(elastic, cell, lame.mu, share.pointwise, &blocks);
  blocks_.assign(blocks.begin(), blocks.end());
  if (share.projected == 0) return;
  const std::array<WeightMatrix, 3> gradients = lattice_.GradientWeights(elastic.points);
  dilatations_.push_back(
      Project(elastic, {gradients[0], gradients[1], gradients[2]}, share.projected));
}

// Adds the blocks of strain_energy.h between the functions of one cell.
void FineLattice::AddCell(const Quadrature& elastic, const Cell& cell, double mu, double lambda,
                          std::vector<double>* blocks) const {
  const std::vector<int>& columns = cell.columns;
  const auto functions = static_cast<Eigen::Index>(columns.size());
  const Eigen::Index points = cell.end - cell.begin;
  std::array<Eigen::MatrixXd, 3> gradients;  // points x functions
  for (Eigen::MatrixXd& each : gradients) each.setZero(points, functions);
  for (Eigen::Index q = 0; q < points; ++q) {
    lattice_.ForEachGradient(
        elastic.points.row(cell.begin + q).transpose(), [&](int column, const Vector3d& gradient) {
          const auto place = std::lower_bound(columns.begin(), columns.end(), column);
          for (int d = 0; d < 3; ++d) gradients[d](q, place - columns.begin()) = gradient[d];
        });
  }
  std::array<std::array<Eigen::MatrixXd, 3>, 3> G;  // int d_i phi_a d_j phi_b dV
  for (int i = 0; i < 3; ++i) {
    const Eigen::MatrixXd weighted =
        elastic.weights.segment(cell.begin, points).asDiagonal() * gradients[i];
    for (int j = 0; j < 3; ++j) G[i][j].noalias() = weighted.transpose() * gradients[j];
  }
  for (Eigen::Index a = 0; a < functions; ++a) {
    for (Eigen::Index b = 0; b < functions; ++b) {
      const std::size_t neighbour =
          Neighbour(columns[static_cast<std::size_t>(a)], columns[static_cast<std::size_t>(b)]);
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(&(*blocks)[9 * neighbour]);
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) block(i, j) += mu * G[j][i](a, b) + lambda * G[i][j](a, b);
      }
      block.diagonal().array() += mu * (G[0][0](a, b) + G[1][1](a, b) + G[2][2](a, b));
    }
  }
}

FineLattice::Projection FineLattice::Project(const Quadrature& tissue,
                                             const std::vector<WeightMatrix>& fields,
                                             double stiffness) const {
  Lattice coarser = LowerDegree(lattice_);
  coarser.DropControlPointsWithoutTissue(tissue);
  const WeightMatrix values = coarser.Weights(tissue.points);
  const WeightMatrix weighted = tissue.weights.asDiagonal() * values;
  Eigen::SparseMatrix<double> inner = WeightMatrix(values.transpose() * weighted);
  for (Eigen::Index b = 0; b < inner.rows(); ++b) inner.coeffRef(b, b) *= 1 + 1e-8;
  Projection projection;
  projection.stiffness = stiffness;
  projection.inner = std::make_unique<Eigen::SimplicialLLT<Eigen::SparseMatrix<double>>>(inner);
  projection.sums = weighted.transpose() * Eigen::VectorXd::Ones(tissue.weights.size());
  const auto axes = static_cast<int>(fields.size());
  std::vector<Eigen::Triplet<double>> moments;
  for (int d = 0; d < axes; ++d) {
    const WeightMatrix of_axis = weighted.transpose() * fields[static_cast<std::size_t>(d)];
    for (Eigen::Index b = 0; b < of_axis.rows(); ++b) {
      for (WeightMatrix::InnerIterator it(of_axis, b); it; ++it) {
        moments.emplace_back(static_cast<int>(b), axes * static_cast<int>(it.index()) + d,
                             it.value());
      }
    }
  }
  projection.moments.resize(inner.rows(), axes * lattice_.size());
  projection.moments.setFromTriplets(moments.begin(), moments.end());
  return projection;
}

void FineLattice::AddSupports(const Quadrature& elastic) {
  springs_ = WeightMatrix(lattice_.size(), lattice_.size());
  const auto add = [this](const Quadrature& region, double stiffness) {
    const WeightMatrix weights = lattice_.Weights(region.points);
    springs_ +=
        WeightMatrix(stiffness * weights.transpose() * region.weights.asDiagonal() * weights);
  };
  if (organ_.supports.empty()) add(elastic, WeakSupport(lattice_, organ_.material.young));
  for (const SupportOptions& support : organ_.supports) {
    Quadrature region = SampleSupport(rest_, support, bounds_, ControlPointSpacing(lattice_));
    if (region.weights.size() == 0) {
      throw InputError("organ \"" + organ_.name +
                       "\": a support holds no tissue; move or enlarge its region");
    }
    if (support.stiffness) {
      add(region, *support.stiffness);
      continue;
    }
    region.weights = ElasticWeights(organ_, bounds_, region.points, region.weights);
    held_.push_back(Project(region, {lattice_.Weights(region.points)},
                            FixedSupport(lattice_, organ_.material.young)));
  }
}

FineLattice::Patch FineLattice::PatchOf(const LoadOptions& load) const {
  if (load.pressure) {
    throw InputError("organ \"" + organ_.name +
                     "\": a fine lattice cannot solve a pressure; give a force or a displacement");
  }
  const SurfacePoint at = NearestSurfacePoint(rest_, load.p_centre_W);
  double thickness = 0;
  for (int k = 0; k < 3; ++k) {
    thickness += at.barycentric[k] * thickness_[rest_.triangles(at.triangle, k)];
  }
  MaterialOptions material = organ_.material;
  material.young = YoungAt(organ_, bounds_, at.Position(rest_.vertices, rest_.triangles));
  const double resolved = std::max(load.radius, thickness / 3);
  Patch patch{Eigen::VectorXd::Zero(lattice_.size()),
              {material, InterpolatedNormal(rest_.vertices, rest_.triangles, topology_, at),
               load.radius, resolved}};
  for (const SurfaceSample& sample : SurfaceKernel(rest_, load.p_centre_W, resolved)) {
    const Vector3d p = AtSample(sample, rest_.triangles, rest_.vertices);
    const Vector3d below = lattice_.inset() * AtSample(sample, rest_.triangles, normals_);
    lattice_.ForEachFunction(lattice_.SiteOf(p, p - below), [&](int column, double value) {
      patch.weights[column] += sample.weight * value;
    });
  }
  return patch;
}

std::vector<Points> FineLattice::Displacements(
    const std::vector<std::vector<LoadOptions>>& cases) const {
  std::vector<Answer> answers;
  for (const std::vector<LoadOptions>& loads : cases) answers.push_back(Ask(loads));
  // Solve all cases' fields in groups of as many columns as one pass over the stiffness takes.
  std::vector<Eigen::VectorXd*> asked;
  for (Answer& answer : answers) {
    for (Eigen::VectorXd& field : answer.fields) asked.push_back(&field);
  }
  for (std::size_t begin = 0; begin < asked.size(); begin += kTogether) {
    const std::size_t count = std::min<std::size_t>(kTogether, asked.size() - begin);
    Columns columns = Columns::Zero(3 * lattice_.size(), kTogether);
    for (std::size_t c = 0; c < count; ++c) {
      columns.col(static_cast<Eigen::Index>(c)) = *asked[begin + c];
    }
    columns = Solve(columns);
    for (std::size_t c = 0; c < count; ++c) {
      *asked[begin + c] = columns.col(static_cast<Eigen::Index>(c));
    }
  }
  std::vector<Points> displacements;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    displacements.push_back(Compose(cases[i], &answers[i]));
  }
  return displacements;
}

FineLattice::Answer FineLattice::Ask(const std::vector<LoadOptions>& loads) const {
  Answer answer;
  const auto equations = static_cast<Eigen::Index>(3 * loads.size());
  answer.force.setZero(equations);
  answer.moved.setZero(equations);
  const auto load_of = [&](const Eigen::VectorXd& forces) {
    Eigen::VectorXd load = Eigen::VectorXd::Zero(3 * lattice_.size());
    for (std::size_t i = 0; i < loads.size(); ++i) {
      const Vector3d f = forces.segment<3>(static_cast<Eigen::Index>(3 * i));
      if (f.isZero(0)) continue;
      for (Eigen::Index a = 0; a < lattice_.size(); ++a) {
        load.segment<3>(3 * a) += answer.patches[i].weights[a] * f;
      }
    }
    return load;
  };
  for (std::size_t i = 0; i < loads.size(); ++i) {
    answer.patches.push_back(PatchOf(loads[i]));
    const auto at = static_cast<Eigen::Index>(3 * i);
    if (loads[i].force_W) answer.force.segment<3>(at) = *loads[i].force_W;
    if (!loads[i].displacement_W) continue;
    answer.moved.segment<3>(at) = *loads[i].displacement_W;
    for (int d = 0; d < 3; ++d) answer.held.push_back(at + d);
  }
  answer.fields.push_back(load_of(answer.force));
  for (const Eigen::Index equation : answer.held) {
    answer.fields.push_back(load_of(Eigen::VectorXd::Unit(equations, equation)));
  }
  return answer;
}

Points FineLattice::Compose(const std::vector<LoadOptions>& loads, Answer* answer) const {
  const Eigen::Index equations = answer->force.size();
  const auto displacements_of = [&](const Eigen::VectorXd& U, const Eigen::VectorXd& forces) {
    Eigen::VectorXd at_loads(equations);
    const Eigen::Map<const Points> moved_points(U.data(), lattice_.size(), 3);
    for (std::size_t i = 0; i < loads.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(3 * i);
      const Patch& patch = answer->patches[i];
      at_loads.segment<3>(at) = moved_points.transpose() * patch.weights +
                                patch.indentation.Compliance() * forces.segment<3>(at);
    }
    return at_loads;
  };
  Eigen::VectorXd& U = answer->fields.front();
  if (!answer->held.empty()) {
    const auto unknown = static_cast<Eigen::Index>(answer->held.size());
    const Eigen::VectorXd missing =
        (answer->moved - displacements_of(U, answer->force))(answer->held);
    Eigen::MatrixXd compliance(unknown, unknown);
    for (Eigen::Index c = 0; c < unknown; ++c) {
      const auto k = static_cast<std::size_t>(c);
      compliance.col(c) = displacements_of(
          answer->fields[k + 1], Eigen::VectorXd::Unit(equations, answer->held[k]))(answer->held);
    }
    const Eigen::VectorXd found = compliance.fullPivLu().solve(missing);
    for (Eigen::Index c = 0; c < unknown; ++c) {
      U += found[c] * answer->fields[static_cast<std::size_t>(c) + 1];
    }
    answer->force(answer->held) += found;
  }

  Points u = lattice_.Weights(rest_.vertices, rest_.vertices - lattice_.inset() * normals_) *
             Eigen::Map<const Points>(U.data(), lattice_.size(), 3);
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const LocalIndentation& indentation = answer->patches[i].indentation;
    const Vector3d f = answer->force.segment<3>(static_cast<Eigen::Index>(3 * i));
    const double reach = IndentationReach(indentation.radius(), indentation.resolved_radius());
    for (Eigen::Index v = 0; v < u.rows(); ++v) {
      const double d = (rest_.vertices.row(v).transpose() - loads[i].p_centre_W).norm();
      if (d >= reach || normals_.row(v).dot(indentation.normal_W()) <= 0) continue;
      u.row(v) += (indentation.At(d) * f).transpose();
    }
  }
  return u;
}

}  // namespace hpdm
