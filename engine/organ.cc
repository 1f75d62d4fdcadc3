#include "engine/organ.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/error.h"
#include "engine/contact/surface_kernel.h"
#include "engine/energy/finite_metric_energy.h"
#include "engine/energy/finite_strain_energy.h"
#include "engine/mesh/files/mesh_import.h"
#include "engine/mesh/mesh_facts.h"
#include "engine/mesh/mesh_subdivision.h"
#include "engine/mesh/thickness.h"
#include "engine/tissue/stiffness_regions.h"

namespace hpdm {
namespace {

// Smallest kernel radius, in mean edges of the finest cells, that their functions resolve to a few
// per cent at any place among the cells.
constexpr double kResolvedCells = 1.25;

// m. An organ beyond these sizes is most likely given in another unit.
constexpr double kMaxOrganSize = 10;
constexpr double kMinOrganSize = 1e-3;

// Returns the cells in which the tissue is sampled: the finest functions' cells. A Bernstein
// lattice is one cell: there it is the number of control intervals, at least 4.
std::array<int, 3> SamplingCells(const OrganOptions& options) {
  const LatticeOptions& lattice = options.lattice;
  if (lattice.basis == BasisType::kBSpline) {
    const int finer = LocalFunctionsOf(options) > 0 ? lattice.local.refinement : 1;
    return {finer * lattice.cells[0], finer * lattice.cells[1], finer * lattice.cells[2]};
  }
  return {std::max(lattice.degree[0], 4), std::max(lattice.degree[1], 4),
          std::max(lattice.degree[2], 4)};
}

void CheckLocalFunctions(const OrganOptions& options) {
  if (LocalFunctionsOf(options) == 0) return;
  if (TakesLocalFunctions(options) && FineCells(options) <= kMaxFineCells) return;
  throw InputError("organ \"" + options.name +
                   "\": local functions need a B-spline lattice, energy strain, solver Cholesky "
                   "and at most a million finer cells; change that or give 0");
}

// A model that needs more is refused before anything is reserved. Otherwise a machine without
// that much memory would kill this program, or others, without a message.
constexpr double kMaxAssemblyBytes = 4e9;
constexpr double kMaxMatrixBytes = 1e9;  // 6,400 unknowns, whose factors take minutes

[[noreturn]] void RefuseAsTooLarge(const OrganOptions& options, const char* what, double bytes,
                                   double most) {
  char text[200];
  std::snprintf(text, sizeof text,
                "its lattice needs %.1f GB for %s, beyond the %.0f GB allowed; give fewer cells or "
                "a lower degree",
                bytes / 1e9, what, most / 1e9);
  throw InputError("organ \"" + options.name + "\": " + text);
}

// Checks the memory for the index and the value of each function at each of `points`.
void CheckAssembly(const OrganOptions& options, const Lattice& lattice, double points) {
  double functions = 1;  // at a point
  for (const int degree : options.lattice.degree) functions *= degree + 1;
  const double bytes = 12 * points * std::min<double>(functions, lattice.size());
  if (bytes > kMaxAssemblyBytes) {
    RefuseAsTooLarge(options, "its functions at the tissue's samples", bytes, kMaxAssemblyBytes);
  }
}

// Checks the memory for the stiffness matrix, its factor and its inverse.
void CheckMatrices(const OrganOptions& options, double control_points) {
  const double unknowns = (options.energy.type == EnergyType::kStrain ? 3.0 : 1.0) * control_points;
  const double bytes = 24 * unknowns * unknowns;
  if (bytes > kMaxMatrixBytes) {
    RefuseAsTooLarge(options, "its stiffness and the factors", bytes, kMaxMatrixBytes);
  }
}

// Returns a lower bound on the control points with tissue: half the cells that the tissue's volume
// would fill.
double LeastControlPoints(const Lattice& lattice, const SurfaceMesh& rest,
                          const std::array<int, 3>& cells) {
  const double share =
      std::abs(EnclosedVolume(rest.vertices, rest.triangles)) / lattice.box().lengths.prod();
  return 0.5 * std::min(share, 1.0) * cells[0] * cells[1] * cells[2];
}

}  // namespace

OrganModel::OrganModel(const OrganOptions& options, SurfaceMesh rest)
    : options_(options),
      rest_(std::move(rest)),
      bounds_(AxisAlignedBounds(rest_.vertices)),
      topology_(rest_.vertices.rows(), rest_.triangles) {
  VertexNormals(rest_.vertices, rest_.triangles, &rest_normals_);
  if (options.model == OrganModelType::kHpdm) {
    BuildLatticeModel();
  } else if (rigid()) {
    BuildRigidModel();
  } else {
    BuildSurfaceModel();
  }
  relocation_.emplace(rest_.vertices, weights_);
  const double across = (bounds_.max - bounds_.min).maxCoeff();
  if (across > kMaxOrganSize || across < kMinOrganSize) {
    char size[32];
    std::snprintf(size, sizeof size, "%.3g m", across);
    warnings_.push_back("organ \"" + options.name + "\": " + size +
                        " across; check organ.unit, which may be \"mm\"");
  }
  if (options.supports.empty() && !rigid()) {
    warnings_.push_back(
        "organ \"" + options.name +
        "\": no [[organ.support]]: a weak spring holds all of it at its rest place");
  }
}

void OrganModel::BuildLatticeModel() {
  CheckLocalFunctions(options_);
  lattice_.emplace(
      BoundingLatticeBox(rest_.vertices, options_.X_WO.linear(), options_.lattice.margin),
      options_.lattice);
  const std::array<int, 3> cells = SamplingCells(options_);
  if (options_.lattice.basis == BasisType::kBSpline) {
    CheckMatrices(options_, LeastControlPoints(*lattice_, rest_, options_.lattice.cells));
  }
  const auto [sampled, stiffness] = SampleStiffness(rest_, lattice_->box(), cells, options_);
  tissue_volume_ = sampled.Volume();
  centre_of_volume_W_ = CentreOfVolume(sampled);
  const Quadrature tissue{sampled.points, sampled.weights};
  const bool over_box =
      options_.energy.type == EnergyType::kMetric && options_.energy.domain == EnergyDomain::kBox;
  // Over the box, three points per cell and axis (BuildEnergy).
  CheckAssembly(options_, *lattice_,
                over_box ? 27.0 * cells[0] * cells[1] * cells[2]
                         : static_cast<double>(tissue.weights.size()));
  if (!over_box) lattice_->DropControlPointsWithoutTissue(tissue);
  CheckMatrices(options_, lattice_->size());
  weights_ = lattice_->Weights(rest_.vertices);
  resolution_ =
      kResolvedCells *
      lattice_->box().lengths.cwiseQuotient(Vector3d(cells[0], cells[1], cells[2])).mean();
  thickness_ = LocalThickness(rest_, rest_normals_, 3 * resolution_);

  std::vector<Quadrature> held;
  for (const SupportOptions& support : options_.supports) {
    held.push_back(SampleSupport(rest_, support, bounds_, ControlPointSpacing(*lattice_)));
    if (held.back().weights.size() == 0) {
      throw InputError("organ \"" + options_.name + "\": support " + std::to_string(held.size()) +
                       " holds no tissue; move or enlarge its region");
    }
    if (support.stiffness) continue;
    held.back().weights =
        ElasticWeights(options_, bounds_, held.back().points, held.back().weights);
  }
  BuildEnergy({tissue.points, tissue.weights.cwiseProduct(stiffness)}, cells, held);
  inversion_detector_.emplace(*lattice_, refinement_basis_ ? &refinement_basis_->finer() : nullptr,
                              tissue);
}

void OrganModel::BuildSurfaceModel() {
  const Skin skin = MeasureSkin(rest_, options_.name);
  const Eigen::VectorXd ground =
      GroundSprings(rest_, skin, options_.supports, options_.material.young, options_.name);
  tissue_volume_ = EnclosedVolume(rest_.vertices, rest_.triangles);
  centre_of_volume_W_ = EnclosedCentre(rest_.vertices, rest_.triangles);
  weights_ = VertexWeights(rest_.vertices.rows());
  if (options_.model == OrganModelType::kMassSpring) {
    springs_.emplace(rest_, ground,
                     MassSpringOf(options_.material, skin.thickness, options_.time_step),
                     options_.name);
    return;
  }
  HPDM_CHECK(options_.model == OrganModelType::kContinuum);
  continuum_.emplace(rest_, ground,
                     ContinuumOf(options_.material, skin.thickness, options_.time_step),
                     options_.name);
  stiffness_ = continuum_->stiffness();
}

void OrganModel::BuildRigidModel() {
  weights_ = WeightMatrix(rest_.vertices.rows(), 0);
  MeasureSkin(rest_, options_.name);  // refuses a surface that encloses nothing
  if (const MeshFacts facts = ComputeMeshFacts(rest_); !facts.Closed()) {
    throw InputError("organ \"" + options_.name + "\": a rigid organ's mesh must be closed, and " +
                     options_.mesh + " has " + std::to_string(facts.boundary_edges) +
                     " boundary and " + std::to_string(facts.nonmanifold_edges) +
                     " non-manifold edges; repair it");
  }
  tissue_volume_ = EnclosedVolume(rest_.vertices, rest_.triangles);
  centre_of_volume_W_ = EnclosedCentre(rest_.vertices, rest_.triangles);
}

void OrganModel::BuildEnergy(const Quadrature& elastic, const std::array<int, 3>& cells,
                             const std::vector<Quadrature>& held) {
  const EnergyOptions& energy = options_.energy;
  const bool strain = energy.type == EnergyType::kStrain;
  const bool finite = energy.strain != StrainMeasure::kSmall;
  const ScalarStiffness supports = SupportStiffness(
      *lattice_, elastic, options_.supports, held, strain ? options_.material.young : energy.alpha);
  if (!strain) {
    // Three midpoints per cell and axis integrate products of the cubic functions well enough for
    // the lumped weights, whose sum is exact.
    Quadrature domain = elastic;
    if (energy.domain == EnergyDomain::kBox) {
      domain = BoxQuadrature(lattice_->box(), {3 * cells[0], 3 * cells[1], 3 * cells[2]});
      domain.weights = ElasticWeights(options_, bounds_, domain.points, domain.weights);
    }
    if (!finite) {
      stiffness_ =
          ScalarStiffness(MetricStiffness(*lattice_, domain, energy.alpha, energy.beta) + supports);
      return;
    }
    finite_energy_ = std::make_unique<FiniteMetricEnergy>(*lattice_, domain, energy.alpha,
                                                          energy.beta, supports);
    FullStiffness K;
    finite_energy_->Clone()->Hessian(Points::Zero(lattice_->size(), 3), false, &K);
    stiffness_ = std::move(K);
  } else {
    FullStiffness K =
        StrainStiffness(*lattice_, elastic, options_.material, Dilatation::kProjected);
    AddAlongEachAxis(supports, &K);
    if (LocalFunctionsOf(options_) > 0) {
      refinement_basis_.emplace(*lattice_, options_.lattice.local, elastic, options_.material,
                                Dilatation::kProjected, held, K);
      refinement_weights_ = refinement_basis_->finer().Weights(rest_.vertices);
    }
    stiffness_ = std::move(K);
    if (!finite) return;
    Quadrature domain = elastic;
    if (refinement_basis_) {
      // Samples in the lattice's own cells: a quarter of the points, since only the finer splines
      // need all. K changes by 5e-4.
      const auto [sampled, stiffness] =
          SampleStiffness(rest_, lattice_->box(), options_.lattice.cells, options_);
      domain = {sampled.points, sampled.weights.cwiseProduct(stiffness)};
    }
    finite_energy_ = std::make_unique<FiniteStrainEnergy>(
        *lattice_, domain, energy.law, ToLame(options_.material), Dilatation::kProjected, supports);
  }
  if (energy.solver == SolverType::kGaussSeidel) {
    warnings_.push_back("organ \"" + options_.name +
                        "\": finite strain is solved by Newton's method with Cholesky "
                        "factors, not by gauss_seidel");
  }
}

std::unique_ptr<Relaxation> OrganModel::MakeRelaxation(int slots,
                                                       std::function<Nanoseconds()> clock) const {
  if (rigid()) return MakeRigidRelaxation();
  if (continuum_) return std::make_unique<SurfaceContinuum>(*continuum_);
  if (springs_) return std::make_unique<MassSpring>(*springs_);
  if (finite_energy_ != nullptr) {
    return MakeNewtonRelaxation(*finite_energy_,
                                {.max_iterations = options_.energy.newton_iterations,
                                 .budget = options_.energy.newton_budget,
                                 .clock = std::move(clock)},
                                refinement_basis(), slots);
  }
  if (refinement_basis_) return MakeCholeskyRelaxation(*refinement_basis_, slots);
  return std::visit(
      [this](const auto& K) {
        return options_.energy.solver == SolverType::kCholesky ? MakeCholeskyRelaxation(K)
                                                               : MakeGaussSeidelRelaxation(K);
      },
      stiffness_);
}

int OrganModel::RefinementSlots(int contacts) const {
  return refinement_basis_ ? contacts * LocalFunctionsOf(options_) : 0;
}

void OrganModel::AddToRow(const SurfacePoint& at, double weight, const ActiveRefinement& active,
                          Eigen::Ref<Eigen::RowVectorXd> row) const {
  if (!lattice_) {
    for (int k = 0; k < 3; ++k) {
      row[rest_.triangles(at.triangle, k)] += weight * at.barycentric[k];
    }
    return;
  }
  const Vector3d p_rest_W = at.Position(rest_.vertices, rest_.triangles);
  lattice_->ForEachFunction(p_rest_W,
                            [&](int column, double value) { row[column] += weight * value; });
  if (active.slots() == 0) return;
  refinement_basis_->finer().ForEachFunction(p_rest_W, [&](int function, double value) {
    const int slot = active.Slot(function);
    if (slot >= 0) row[control_points() + slot] += weight * value;
  });
}

void OrganModel::AddLocalDisplacements(const ActiveRefinement& active, const Points& U,
                                       Points* vertices) const {
  for (int slot = 0; slot < active.slots(); ++slot) {
    if (active.Function(slot) < 0) continue;
    const auto displacement = U.row(control_points() + slot);
    for (Eigen::SparseMatrix<double>::InnerIterator it(refinement_weights_, active.Function(slot));
         it; ++it) {
      vertices->row(it.index()) += it.value() * displacement;
    }
  }
}

SparseRow OrganModel::LatticeRow(int vertex) const {
  const int first = weights_.outerIndexPtr()[vertex];
  const auto count = static_cast<std::size_t>(weights_.outerIndexPtr()[vertex + 1] - first);
  return {{weights_.innerIndexPtr() + first, count}, {weights_.valuePtr() + first, count}};
}

IndentationSnapshot AppliedIndentation(const LocalIndentation& indentation,
                                       const Vector3d& p_rest_W, const Vector3d& force_W) {
  return {.p_rest_W = p_rest_W,
          .normal_W = indentation.normal_W(),
          .radius = indentation.radius(),
          .resolved_radius = indentation.resolved_radius(),
          .amplitude_W = indentation.factor_W() * force_W};
}

double OrganModel::ResolvedRadius(const SurfacePoint& at, double radius) const {
  if (!lattice_ || options_.energy.type != EnergyType::kStrain) return radius;
  double thickness = 0;
  for (int k = 0; k < 3; ++k) {
    thickness += at.barycentric[k] * thickness_[rest_.triangles(at.triangle, k)];
  }
  return std::max(radius, thickness / 3);
}

LocalIndentation OrganModel::Indentation(const SurfacePoint& at, double radius) const {
  MaterialOptions material = options_.material;
  material.young = YoungAt(options_, bounds_, at.Position(rest_.vertices, rest_.triangles));
  return {material, InterpolatedNormal(rest_.vertices, rest_.triangles, topology_, at), radius,
          ResolvedRadius(at, radius)};
}

LocalIndentation OrganModel::AddLoadToRow(const Vector3d& p_centre_W, double radius,
                                          const ActiveRefinement& active,
                                          Eigen::Ref<Eigen::RowVectorXd> row) const {
  const LocalIndentation indentation = Indentation(NearestSurfacePoint(rest_, p_centre_W), radius);
  for (const SurfaceSample& sample :
       SurfaceKernel(rest_, p_centre_W, indentation.resolved_radius())) {
    AddToRow({sample.triangle, sample.barycentric}, sample.weight, active, row);
  }
  return indentation;
}

OrganState::OrganState(const OrganModel& model, int tools, std::function<Nanoseconds()> clock)
    : control_displacements(Points::Zero(model.control_points() + model.RefinementSlots(tools), 3)),
      vertices(model.rest().vertices),
      tree(model.rest().vertices, model.rest().triangles),
      contacts(model.control_points(),
               model.refinement_basis() != nullptr ? model.refinement_basis()->size() : 0,
               model.RefinementSlots(tools)),
      neighbourhoods(model.rest().triangles, model.topology()),
      relaxation(model.MakeRelaxation(model.RefinementSlots(tools), std::move(clock))),
      recovery(model.options().material.relaxation_time,
               static_cast<int>(control_displacements.rows())),
      tips(static_cast<int>(control_displacements.rows())) {
  if (relaxation->compliance() == nullptr) return;
  vertex_compliances.reserve(static_cast<std::size_t>(vertices.rows()));
  for (int v = 0; v < vertices.rows(); ++v) {
    vertex_compliances.push_back(relaxation->compliance()->PointCompliance(model.LatticeRow(v)));
  }
}

SurfaceMesh LoadPosedMesh(const OrganOptions& options, std::vector<std::string>* repairs) {
  ImportedMesh imported = ImportMesh(options.mesh, options.unit_m);
  for (const auto& [what, count] : imported.repairs.List()) {
    repairs->push_back(options.mesh + ": repaired: " + what + " (" + std::to_string(count) + ")");
  }
  SurfaceMesh mesh = Subdivided(imported.mesh, options.subdivisions, options.mesh.c_str());
  Points& vertices = mesh.vertices;
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
    vertices.row(v) = options.X_WO * Vector3d(vertices.row(v));
  }
  return mesh;
}

}  // namespace hpdm
