#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "engine/baselines/mass_spring.h"
#include "engine/baselines/surface_continuum.h"
#include "engine/contact/contact_constraints.h"
#include "engine/contact/half_space.h"
#include "engine/contact/surface_kernel.h"
#include "engine/contact/tip_compliance.h"
#include "engine/energy/inversion_detector.h"
#include "engine/lattice/lattice.h"
#include "engine/lattice/relocation.h"
#include "engine/mesh/collision.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/mesh/surface_topology.h"
#include "engine/organ_options.h"
#include "engine/snapshots.h"
#include "engine/solver/elastic_relaxation.h"
#include "engine/solver/refinement_basis.h"
#include "engine/solver/relaxation.h"
#include "engine/solver/viscous_recovery.h"
#include "engine/tissue/support.h"

namespace hpdm {

/// Either one n x n matrix for all three axes, or a 3n x 3n matrix that couples them.
using LatticeStiffness = std::variant<ScalarStiffness, FullStiffness>;

/// The constant part of an organ, built once from its options and mesh. Any thread may read it.
class OrganModel {
 public:
  /// `rest`: the posed rest surface, world, m. Throws InputError (organ's name, fault, remedy) if
  /// the model cannot be built, for example without volume or with a support without tissue.
  OrganModel(const OrganOptions& options, SurfaceMesh rest);

  const OrganOptions& options() const { return options_; }
  const SurfaceMesh& rest() const { return rest_; }
  const Points& rest_normals() const { return rest_normals_; }  ///< V x 3, unit.
  const SurfaceTopology& topology() const { return topology_; }
  /// True if the organ does not deform: no lattice and no control points (n = 0). The hand feels a
  /// virtual wall with the tool's stiffness (ToolOptions) unless the options give one.
  bool rigid() const { return options_.model == OrganModelType::kRigid; }
  /// Present in model "hpdm". In the surface models every vertex is a control point (n = V).
  const std::optional<Lattice>& lattice() const { return lattice_; }
  int control_points() const { return static_cast<int>(weights_.cols()); }  ///< n.
  const WeightMatrix& weights() const { return weights_; }                  ///< V x n.
  const Relocation& relocation() const { return *relocation_; }             ///< Eq. 4.
  /// Stiffness with supports, N/m: n x n for the metric energy and the continuum; 3n x 3n for the
  /// strain energy and for finite strain of either energy (at rest). Empty for mass_spring, whose
  /// stiffness changes with its motion, and for a rigid organ.
  const LatticeStiffness& stiffness() const { return stiffness_; }
  /// The energy of finite strain (Clone() it to use it), or nullptr for a constant stiffness.
  const ElasticEnergy* finite_energy() const { return finite_energy_.get(); }
  /// The springs of model "mass_spring" at rest, to copy; nullptr for the other models.
  const MassSpring* springs() const { return springs_ ? &*springs_ : nullptr; }
  /// Inversion detector of a lattice's tissue; nullptr for the other models.
  const InversionDetector* inversion_detector() const {
    return inversion_detector_ ? &*inversion_detector_ : nullptr;
  }
  double tissue_volume() const { return tissue_volume_; }                     ///< m^3.
  const Vector3d& centre_of_volume_W() const { return centre_of_volume_W_; }  ///< m.
  /// Valid but suspicious inputs, one line each.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Returns a new solver for the energy in the options, with `slots` slots for local functions.
  /// `clock` (session time) enforces the time budget of finite strain; without a clock (lockstep)
  /// only iterations are limited.
  std::unique_ptr<Relaxation> MakeRelaxation(int slots,
                                             std::function<Nanoseconds()> clock = nullptr) const;

  /// Lattice row of a vertex, without local functions.
  SparseRow LatticeRow(int vertex) const;
  /// Basis of the local functions; nullptr if the organ has none.
  const RefinementBasis* refinement_basis() const {
    return refinement_basis_.has_value() ? &*refinement_basis_ : nullptr;
  }
  /// Number of slots for local functions at `contacts` places; 0 if the organ has none.
  int RefinementSlots(int contacts) const;
  /// Adds `weight` times the basis values at a surface point to `row` (n + slots of `active`). The
  /// basis is the lattice (or the triangle's corners), then the local functions in use. No
  /// allocation.
  void AddToRow(const SurfacePoint& at, double weight, const ActiveRefinement& active,
                Eigen::Ref<Eigen::RowVectorXd> row) const;

  /// Adds the displacements by the local functions in use to `vertices` (V x 3, m). `U`: (n +
  /// slots) x 3, m. No allocation.
  void AddLocalDisplacements(const ActiveRefinement& active, const Points& U,
                             Points* vertices) const;
  /// Adds an indentation to the `vertices` (V x 3, m, any scalar) on its side of the surface. O(V),
  /// no allocation.
  template <typename Vertices>
  void AddIndentation(const IndentationSnapshot& indentation, Vertices* vertices) const;

  /// Returns the kernel radius (m, at least `radius`) that spreads a force on a patch of `radius`
  /// over the lattice (half_space.h). It is the radius that the finest functions resolve, or a
  /// third of the tissue's thickness there, whichever is smaller. No allocation.
  double ResolvedRadius(const SurfacePoint& at, double radius) const;
  /// Returns the local indentation that the lattice does not resolve. No allocation.
  LocalIndentation Indentation(const SurfacePoint& at, double radius) const;
  /// Adds the resolved kernel of a load's patch of `radius` (m) around the rest point `p_centre_W`
  /// (m) to `row` and returns the unresolved indentation. Set-up only; throws InputError if no
  /// surface lies within the radius.
  LocalIndentation AddLoadToRow(const Vector3d& p_centre_W, double radius,
                                const ActiveRefinement& active,
                                Eigen::Ref<Eigen::RowVectorXd> row) const;

 private:
  void BuildLatticeModel();
  void BuildSurfaceModel();
  void BuildRigidModel();
  void BuildEnergy(const Quadrature& elastic, const std::array<int, 3>& cells,
                   const std::vector<Quadrature>& held);

  OrganOptions options_;
  SurfaceMesh rest_;
  Box bounds_;  // rest surface's
  Points rest_normals_;
  SurfaceTopology topology_;
  std::optional<Lattice> lattice_;
  WeightMatrix weights_;
  std::optional<Relocation> relocation_;
  Eigen::VectorXd thickness_;  // V, m, at most twice the resolution
  double resolution_ = 0;      // m: kernel radius that the finest functions resolve
  LatticeStiffness stiffness_;
  std::unique_ptr<const ElasticEnergy> finite_energy_;
  std::optional<RefinementBasis> refinement_basis_;
  Eigen::SparseMatrix<double> refinement_weights_;  // V x N: basis values of the local functions
  std::optional<InversionDetector> inversion_detector_;
  std::optional<SurfaceContinuum> continuum_;
  std::optional<MassSpring> springs_;
  double tissue_volume_ = 0;
  Vector3d centre_of_volume_W_ = Vector3d::Zero();
  std::vector<std::string> warnings_;
};

template <typename Vertices>
void OrganModel::AddIndentation(const IndentationSnapshot& indentation, Vertices* vertices) const {
  const double reach = IndentationReach(indentation.radius, indentation.resolved_radius);
  for (Eigen::Index v = 0; v < vertices->rows(); ++v) {
    const double distance2 =
        (rest_.vertices.row(v).transpose() - indentation.p_rest_W).squaredNorm();
    if (distance2 >= reach * reach) continue;
    if (rest_normals_.row(v).dot(indentation.normal_W) <= 0) continue;
    const Vector3d moved =
        IndentationProfile(std::sqrt(distance2), indentation.radius, indentation.resolved_radius) *
        indentation.amplitude_W;
    vertices->row(v) += moved.transpose().template cast<typename Vertices::Scalar>();
  }
}

/// Scales an indentation by the force on the tissue (N) at a rest point (m).
IndentationSnapshot AppliedIndentation(const LocalIndentation& indentation,
                                       const Vector3d& p_rest_W, const Vector3d& force_W);

/// The part of an organ that a step changes. Owned by the deformation thread.
struct OrganState {
  /// Makes room for at most `tools` tools. `clock`: see OrganModel::MakeRelaxation.
  OrganState(const OrganModel& model, int tools, std::function<Nanoseconds()> clock = nullptr);

  Vector3d offset_W = Vector3d::Zero();       ///< Rigid offset by breathing (OrganMotion), m.
  Vector3d offset_last_W = Vector3d::Zero();  ///< Offset in the previous step, m.
  Points control_displacements;  ///< (n + slots of local functions) x 3, m, world axes: U. Set by
                                 ///< reposition and relax.
  Points vertices;               ///< V x 3, m, world: X + B U, without indentations and the organ's
                                 ///< offset. Set by relocate.
  SurfaceTree tree;              ///< Over `vertices`. Refitted by collide after they moved.
  ContactConstraints contacts;   ///< Filled by collide, forces set by relax.
  NeighbourhoodSearch neighbourhoods;
  std::unique_ptr<Relaxation> relaxation;
  ViscousRecovery recovery;  ///< Wraps `relaxation`.
  RelaxationResult relaxed;  ///< Outcome of the last relaxation.
  StepQuality quality;       ///< Set before each step.

  /// True if a step must relax and relocate the organ: it is touched or still moves. An organ that
  /// is not awake is at rest to the last bit and costs only a collision test.
  bool awake = false;
  bool tree_fits = true;      ///< `tree` matches the present `vertices`.
  std::uint64_t version = 0;  ///< OrganSnapshot::version.

  TipCompliance tips;  ///< Tips on the organ. Filled when the contact patches are built.
  /// Self-compliance of each vertex at rest, m/N: V symmetric 3 x 3; empty without a compliance.
  std::vector<Matrix3d> vertex_compliances;
};

/// Returns the posed rest surface of an organ: reads options.mesh, applies unit_m, subdivides it,
/// then applies X_WO. Appends one line per repair of the file to `repairs`. Throws InputError.
SurfaceMesh LoadPosedMesh(const OrganOptions& options, std::vector<std::string>* repairs);

}  // namespace hpdm
