#include "engine/organ/lattice_organ.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <numeric>
#include <utility>

#include "engine/base/error.h"
#include "engine/energy/compressed_quadrature.h"
#include "engine/energy/finite_metric_energy.h"
#include "engine/energy/finite_strain_energy.h"
#include "engine/mesh/mesh_facts.h"
#include "engine/mesh/thickness.h"
#include "engine/organ/level_placement.h"
#include "engine/organ/organ_cuts.h"
#include "engine/organ/placement_loads.h"
#include "engine/solver/elastic_relaxation.h"
#include "engine/solver/free_relaxation.h"
#include "engine/tissue/stiffness_regions.h"
#include "engine/tissue/support.h"

namespace hpdm {
namespace {

// Smallest kernel radius, in mean edges of the finest cells, that their functions resolve to a few
// per cent at any place among the cells.
constexpr double kResolvedCells = 1.25;

// The points of finite strain keep the moments of this degree. On a lift of a liver the error is the
// same as with all points, which are three times as many.
constexpr int kFinitePointsDegree = 2;

// Local functions with less tissue, as a share of a whole function's, are left out. They yield so
// easily that a load far beside them moves them, and in finite strain the tissue inverts in them.
constexpr double kLeastTissue = 0.002, kLeastTissueFinite = 0.02;

// Samples of a layer along the control points' spacing.
constexpr double kSamplesOfLayer = 3;

constexpr int kLevelPointsDegree = 3;  // of the moments that points under finer levels keep

// Presses that place the functions of finer levels in a scene without loads.
constexpr int kPresses = 24;

// Share of a level's functions in use at a point from which, and at which, the level resolves a
// kernel there.
constexpr double kResolvesFrom = 0.75, kResolvesAt = 0.95;

bool HasLevels(const OrganOptions& options) { return options.lattice.adaptive.functions > 0; }

std::array<int, 3> Times(int factor, const std::array<int, 3>& cells) {
  return {factor * cells[0], factor * cells[1], factor * cells[2]};
}

// Returns the cells of the finest functions that a contact has everywhere. A Bernstein lattice is
// one cell: there it is the number of control intervals, at least 4.
std::array<int, 3> CellsAtContacts(const OrganOptions& options) {
  const LatticeOptions& lattice = options.lattice;
  if (lattice.basis == BasisType::kBSpline) {
    return Times(LocalFunctionsOf(options) > 0 ? lattice.local.refinement : 1, lattice.cells);
  }
  return {std::max(lattice.degree[0], 4), std::max(lattice.degree[1], 4),
          std::max(lattice.degree[2], 4)};
}

// Returns the cells in which the tissue is sampled: those of the finest functions.
std::array<int, 3> SamplingCells(const OrganOptions& options) {
  if (!HasLevels(options)) return CellsAtContacts(options);
  const int local = LocalFunctionsOf(options) > 0 ? options.lattice.local.refinement : 1;
  return Times(std::lcm(local, 1 << options.lattice.adaptive.levels), options.lattice.cells);
}

// Returns the radius that the functions resolve at each vertex, in units of the one that the
// coarsest level resolves.
Eigen::VectorXd RelativeResolution(const Lattice& lattice, const WeightMatrix& weights) {
  Eigen::VectorXd resolution = Eigen::VectorXd::Ones(weights.rows());
  for (std::size_t level = 0; level < lattice.levels().size(); ++level) {
    const int first = lattice.FirstColumn(level), end = first + lattice.levels()[level].size();
    for (Eigen::Index v = 0; v < weights.rows(); ++v) {
      double share = 0;
      for (WeightMatrix::InnerIterator it(weights, v); it; ++it) {
        if (it.col() >= first && it.col() < end) share += it.value();
      }
      const double resolves = (share - kResolvesFrom) / (kResolvesAt - kResolvesFrom);
      resolution[v] *= 1 - std::clamp(resolves, 0.0, 1.0) / 2;
    }
  }
  return resolution;
}

void RequireAdaptiveFunctions(const OrganOptions& options) {
  if (!HasLevels(options)) return;
  if (!options.cuts.empty() || options.free) {
    throw InputError("organ \"" + options.name +
                     "\": adaptive functions cannot be combined with cuts or [organ.free]; remove "
                     "one of them");
  }
  if (TakesAdaptiveFunctions(options)) return;
  throw InputError("organ \"" + options.name +
                   "\": adaptive functions need a B-spline lattice, energy strain and solver "
                   "Cholesky; change that or give 0");
}

// Checks options that no loader has checked.
void RequireLocalFunctions(const OrganOptions& options) {
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

double MeanCell(const OrientedBox& box, const std::array<int, 3>& cells) {
  return box.lengths.cwiseQuotient(Vector3d(cells[0], cells[1], cells[2])).mean();
}

}  // namespace

LatticeOrgan::LatticeOrgan(const OrganSurface& surface, std::vector<std::string>* warnings)
    : OrganMechanics(surface),
      lattice_(
          BoundingLatticeBox(rest().vertices, options().X_WO.linear(), options().lattice.margin),
          options().lattice) {
  RequireLocalFunctions(options());
  RequireAdaptiveFunctions(options());
  if (options().material.prony.count > 0 && options().energy.solver == SolverType::kGaussSeidel) {
    throw InputError("organ \"" + options().name +
                     "\": Prony terms need the solver Cholesky; change that or give none");
  }
  if (options().free && !TakesFree(options())) {
    throw InputError("organ \"" + options().name + "\": cannot be free; " + kFreeRemedy);
  }
  const std::array<int, 3> cells = SamplingCells(options());
  if (options().lattice.basis == BasisType::kBSpline) {
    CheckMatrices(options(), LeastControlPoints(lattice_, rest(), options().lattice.cells));
  }
  cuts_ = CutsOf(options(), rest(), surface_.bounds, lattice_.box(),
                 MeanCell(lattice_.box(), options().lattice.cells), warnings);
  const auto [sampled, stiffness] =
      SampleStiffness(rest(), lattice_.box(), cells, options(), cuts_);
  tissue_volume_ = sampled.Volume();
  centre_of_volume_W_ = CentreOfVolume(sampled);
  const Quadrature tissue{sampled.points, sampled.weights};
  const bool over_box =
      options().energy.type == EnergyType::kMetric && options().energy.domain == EnergyDomain::kBox;
  // Over the box, three points per cell and axis (BuildMetricEnergy).
  CheckAssembly(options(), lattice_,
                over_box ? 27.0 * cells[0] * cells[1] * cells[2]
                         : static_cast<double>(tissue.weights.size()));
  if (!sampled.pieces.empty()) {
    lattice_.SplitByTissue(std::make_shared<const TissuePieces>(sampled.pieces));
  }
  if (!over_box) lattice_.DropControlPointsWithoutTissue(tissue);
  if (cuts_ != nullptr && lattice_.pieces() == nullptr) {
    if (!options().cuts.empty()) {
      throw InputError(
          "organ \"" + options().name +
          "\": its cuts and gaps leave too many pieces of tissue for one lattice; give "
          "fewer cuts or more cells");
    }
    cuts_ = nullptr;
  }
  if (cuts_ != nullptr) lattice_.AddFrontFunctions();
  CheckMatrices(options(), std::max(lattice_.size(), options().lattice.adaptive.functions));
  const std::vector<Quadrature> held = SampleSupports();
  Quadrature elastic{tissue.points, tissue.weights.cwiseProduct(stiffness)};
  if (HasLevels(options())) PlaceFinerLevels(&elastic, held);
  weights_ = SurfaceWeights(lattice_);
  resolution_ = kResolvedCells * MeanCell(lattice_.box(), CellsAtContacts(options()));
  thickness_ = LocalThickness(rest(), surface_.rest_normals, 3 * resolution_);
  if (HasLevels(options())) {
    const double coarse = kResolvedCells * MeanCell(lattice_.box(), options().lattice.cells);
    thickness_ = thickness_.cwiseMin(3 * coarse * RelativeResolution(lattice_, weights_));
  }
  if (!options().gravity_W.isZero(0)) {
    weight_W_ = options().material.density *
                (lattice_.Weights(tissue.points).transpose() * tissue.weights) *
                options().gravity_W.transpose();
  }
  if (options().free) {
    free_body_.emplace(lattice_, tissue, options().material.density);
    free_flight_.emplace(options().time_step, options().free->drag, options().gravity_W);
  }
  BuildElasticSupports(tissue, held);
  fillings_and_layers_ = FillingsAndLayers(options(), rest(), surface_.rest_normals,
                                           ControlPointSpacing(lattice_) / kSamplesOfLayer);
  switch (options().energy.type) {
    case EnergyType::kMetric:
      BuildMetricEnergy(elastic, cells, held);
      break;
    case EnergyType::kStrain:
      BuildStrainEnergy(elastic, held);
      break;
  }
  inversion_detector_.emplace(
      lattice_, refinement_basis_ ? &refinement_basis_->finer() : nullptr,
      HasLevels(options()) ? CompressedQuadrature(lattice_, nullptr, tissue, kFinitePointsDegree)
                           : tissue);
  if (finite_energy_ != nullptr && options().energy.solver == SolverType::kGaussSeidel) {
    warnings->push_back("organ \"" + options().name +
                        "\": finite strain is solved by Newton's method with Cholesky "
                        "factors, not by gauss_seidel");
  }
}

// Adds the finer levels. The points of `elastic` become those that the levels need.
void LatticeOrgan::PlaceFinerLevels(Quadrature* elastic, const std::vector<Quadrature>& held) {
  std::array<int, 3> finest =
      Times(1 << options().lattice.adaptive.levels, options().lattice.cells);
  LevelPlacement placed =
      PlaceLevels(lattice_, options(), *elastic, held,
                  PlacementCases(options(), rest(), surface_.rest_normals,
                                 kResolvedCells * MeanCell(lattice_.box(), finest), kPresses));
  lattice_ = std::move(placed.lattice);
  error_of_levels_ = placed.error;
  std::optional<Lattice> local;  // its cells
  if (LocalFunctionsOf(options()) > 0) {
    LatticeOptions finer = options().lattice;
    finer.cells = CellsAtContacts(options());
    local.emplace(lattice_.box(), finer);
  }
  *elastic =
      CompressedQuadrature(lattice_, local ? &*local : nullptr, *elastic, kLevelPointsDegree);
}

WeightMatrix LatticeOrgan::SurfaceWeights(const Lattice& lattice) const {
  return lattice.Weights(rest().vertices,
                         rest().vertices - lattice.inset() * surface_.rest_normals);
}

std::vector<Quadrature> LatticeOrgan::SampleSupports() {
  std::vector<Quadrature> held;
  for (const SupportOptions& support : options().supports) {
    held.push_back(SampleSupport(rest(), support, surface_.bounds, ControlPointSpacing(lattice_)));
    if (held.back().weights.size() == 0) {
      const std::string key = "support[" + std::to_string(held.size() - 1) + "]";
      throw InputError("organ \"" + options().name + "\": " + key +
                           " holds no tissue; move or enlarge its region",
                       {"organ", options().name, key});
    }
    support_volumes_.push_back(held.back().weights.sum());
    if (support.stiffness) continue;
    held.back().weights =
        ElasticWeights(options(), surface_.bounds, held.back().points, held.back().weights);
  }
  return held;
}

void LatticeOrgan::BuildElasticSupports(const Quadrature& tissue,
                                        const std::vector<Quadrature>& held) {
  std::vector<SupportOptions> supports;
  std::vector<Quadrature> regions;
  for (std::size_t s = 0; s < held.size(); ++s) {
    const SupportOptions& support = options().supports[s];
    if (!support.stiffness || support.viscoelastic) continue;
    supports.push_back(support);
    regions.push_back(held[s]);
  }
  if (supports.empty() || options().material.prony.count == 0) return;
  elastic_supports_ =
      SupportStiffness(lattice_, tissue, supports, regions, options().material.young);
}

void LatticeOrgan::BuildMetricEnergy(Quadrature tissue, const std::array<int, 3>& cells,
                                     const std::vector<Quadrature>& held) {
  const EnergyOptions& energy = options().energy;
  const ScalarStiffness supports =
      SupportStiffness(lattice_, tissue, options().supports, held, energy.alpha);
  if (energy.domain == EnergyDomain::kBox) {
    // Three midpoints per cell and axis integrate products of the cubic functions well enough for
    // the lumped weights, whose sum is exact.
    tissue = BoxQuadrature(lattice_.box(), {3 * cells[0], 3 * cells[1], 3 * cells[2]});
    tissue.weights = ElasticWeights(options(), surface_.bounds, tissue.points, tissue.weights);
  }
  if (energy.strain == StrainMeasure::kSmall) {
    stiffness_ =
        ScalarStiffness(MetricStiffness(lattice_, tissue, energy.alpha, energy.beta) + supports);
    return;
  }
  finite_energy_ =
      std::make_unique<FiniteMetricEnergy>(lattice_, tissue, energy.alpha, energy.beta, supports);
  FullStiffness K;
  finite_energy_->Clone()->Hessian(Points::Zero(lattice_.size(), 3), false, &K);
  stiffness_ = std::move(K);
}

void LatticeOrgan::BuildStrainEnergy(const Quadrature& tissue,
                                     const std::vector<Quadrature>& held) {
  const MaterialOptions& material = options().material;
  FullStiffness K = StrainStiffness(lattice_, tissue, material, Dilatation::kProjected);
  ScalarStiffness supports(lattice_.size(), lattice_.size());
  if (free_body_) {
    free_body_->AddInertia(free_flight_->Yield(), &K);
  } else {
    supports = SupportStiffness(lattice_, tissue, options().supports, held, material.young);
    AddAlongEachAxis(supports, &K);
  }
  fillings_and_layers_.AddTo(lattice_, &K);
  if (LocalFunctionsOf(options()) > 0) {
    const bool finite = options().energy.strain != StrainMeasure::kSmall;
    refinement_basis_.emplace(lattice_, options().lattice.local, tissue, material,
                              Dilatation::kProjected, held, K,
                              finite ? kLeastTissueFinite : kLeastTissue, fillings_and_layers_);
    finer_weights_ = SurfaceWeights(refinement_basis_->finer());
    refinement_weights_ = finer_weights_;
  }
  stiffness_ = std::move(K);
  if (options().energy.strain == StrainMeasure::kSmall) return;
  const Lattice* finer = refinement_basis_ ? &refinement_basis_->finer() : nullptr;
  finite_energy_ = std::make_unique<FiniteStrainEnergy>(
      lattice_, CompressedQuadrature(lattice_, finer, tissue, kFinitePointsDegree),
      options().energy.law, ToLame(material), Dilatation::kProjected, supports, finer);
}

std::unique_ptr<Relaxation> LatticeOrgan::MakeRelaxation(int slots,
                                                         std::function<Nanoseconds()> clock) const {
  const EnergyOptions& energy = options().energy;
  if (finite_energy_ != nullptr) {
    return MakeNewtonRelaxation(
        *finite_energy_,
        {.max_iterations = energy.newton_iterations,
         .budget = energy.newton_budget,
         .clock = std::move(clock),
         .elastic_supports = elastic_supports_.size() > 0 ? &elastic_supports_ : nullptr},
        std::get_if<FullStiffness>(&stiffness_), refinement_basis(), slots);
  }
  if (free_body_) {
    auto K = refinement_basis_ ? MakeComplianceSolver(*refinement_basis_, slots)
                               : MakeComplianceSolver(std::get<FullStiffness>(stiffness_));
    return MakeFreeRelaxation(std::move(K), *free_body_, *free_flight_, lattice_.size() + slots);
  }
  if (refinement_basis_) return MakeCholeskyRelaxation(*refinement_basis_, slots);
  return std::visit(
      [&](const auto& K) {
        return energy.solver == SolverType::kCholesky ? MakeCholeskyRelaxation(K)
                                                      : MakeGaussSeidelRelaxation(K);
      },
      stiffness_);
}

void LatticeOrgan::AddToRow(const SurfacePoint& at, double weight, const ActiveRefinement& active,
                            Eigen::Ref<Eigen::RowVectorXd> row) const {
  const Vector3d p_rest_W = at.Position(rest().vertices, rest().triangles);
  const auto site = [&](const Lattice& lattice) {
    if (lattice.inset() == 0) return lattice.SiteOf(p_rest_W);
    const Vector3d normal_W = at.Position(surface_.rest_normals, rest().triangles);
    return lattice.SiteOf(p_rest_W, p_rest_W - lattice.inset() * normal_W);
  };
  lattice_.ForEachFunction(site(lattice_),
                           [&](int column, double value) { row[column] += weight * value; });
  if (active.slots() == 0) return;
  const Lattice& finer = refinement_basis_->finer();
  finer.ForEachFunction(site(finer), [&](int function, double value) {
    const int slot = active.Slot(function);
    if (slot >= 0) row[lattice_.size() + slot] += weight * value;
  });
}

void LatticeOrgan::AddLocalDisplacements(const ActiveRefinement& active, const Points& U,
                                         Points* vertices) const {
  for (int slot = 0; slot < active.slots(); ++slot) {
    if (active.Function(slot) < 0) continue;
    const auto displacement = U.row(lattice_.size() + slot);
    for (Eigen::SparseMatrix<double>::InnerIterator it(refinement_weights_, active.Function(slot));
         it; ++it) {
      vertices->row(it.index()) += it.value() * displacement;
    }
  }
}

double LatticeOrgan::FinestRadius() const {
  const bool coupled = options().energy.type == EnergyType::kStrain &&
                       options().energy.solver == SolverType::kCholesky;
  return coupled ? resolution_ : 0;
}

double LatticeOrgan::ResolvedRadius(const SurfacePoint& at, double radius) const {
  if (!HasModulus()) return radius;
  double thickness = 0;
  for (int k = 0; k < 3; ++k) {
    thickness += at.barycentric[k] * thickness_[rest().triangles(at.triangle, k)];
  }
  return std::max(radius, thickness / 3);
}

}  // namespace hpdm
