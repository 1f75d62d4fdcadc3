#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "engine/collision.h"
#include "engine/contact_set.h"
#include "engine/elastic_relaxation.h"
#include "engine/lattice.h"
#include "engine/organ_options.h"
#include "engine/relaxation.h"
#include "engine/support.h"
#include "engine/surface_mesh.h"
#include "engine/surface_topology.h"
#include "engine/viscous_recovery.h"

namespace hpdm {

/// One matrix for all three axes, or one that couples them.
using LatticeStiffness = std::variant<ScalarStiffness, FullStiffness>;

/// The constant part of an organ, built once from its options and mesh; read by any thread.
class OrganModel {
 public:
  /// `rest`: the posed rest surface, world, m. Throws InputError (organ's name, what, remedy) when
  /// the options cannot be built: no volume, supports without tissue and the like.
  OrganModel(const OrganOptions& options, SurfaceMesh rest);

  const OrganOptions& options() const { return options_; }
  const SurfaceMesh& rest() const { return rest_; }
  const Points& rest_normals() const { return rest_normals_; }  ///< V x 3, unit.
  const SurfaceTopology& topology() const { return topology_; }
  const Lattice& lattice() const { return lattice_; }
  const WeightMatrix& weights() const { return weights_; }  ///< V x n.
  /// N/m, with supports: n x n for the metric energy, 3n x 3n for the strain energy and for
  /// finite strain of either (at rest).
  const LatticeStiffness& stiffness() const { return stiffness_; }
  /// The energy of finite strain (Clone() it to use it), or nullptr for a constant stiffness.
  const ElasticEnergy* finite_energy() const { return finite_energy_.get(); }
  double tissue_volume() const { return tissue_volume_; }                     ///< m^3.
  const Vector3d& centre_of_volume_W() const { return centre_of_volume_W_; }  ///< m.
  /// Things that work but are probably not meant, one line each.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// A new solver for the energy as the options ask. `clock` (session time) makes the budget of
  /// finite strain count; without one (lockstep) iterations alone do.
  std::unique_ptr<Relaxation> MakeRelaxation(std::function<Nanoseconds()> clock = nullptr) const;

  /// Lattice row b of a surface point: `row` (n) = sum of corner weights x their lattice rows.
  void LatticeRow(const SurfacePoint& at, Eigen::Ref<Eigen::RowVectorXd> row) const;

 private:
  void BuildEnergy(const Quadrature& tissue, const std::array<int, 3>& cells,
                   const std::vector<Quadrature>& regions);

  OrganOptions options_;
  SurfaceMesh rest_;
  Points rest_normals_;
  SurfaceTopology topology_;
  Lattice lattice_;
  WeightMatrix weights_;
  LatticeStiffness stiffness_;
  std::unique_ptr<const ElasticEnergy> finite_energy_;
  double tissue_volume_ = 0;
  Vector3d centre_of_volume_W_ = Vector3d::Zero();
  std::vector<std::string> warnings_;
};

/// The part of an organ that a step changes. Owned by the deformation thread.
struct OrganState {
  /// `clock`: as of OrganModel::MakeRelaxation.
  explicit OrganState(const OrganModel& model, std::function<Nanoseconds()> clock = nullptr);

  Points control_displacements;  ///< n x 3, m, world axes: U. Set by reposition and relax.
  Points vertices;               ///< V x 3, m, world: X + B U. Set by relocate.
  SurfaceTree tree;              ///< Over `vertices`. Refitted by collide.
  ContactSet contacts;           ///< Filled by collide, forces set by relax.
  NeighbourhoodSearch neighbourhoods;
  std::unique_ptr<Relaxation> relaxation;
  ViscousRecovery recovery;  ///< Around `relaxation`.
  RelaxationResult relaxed;  ///< How the last relaxation ended.
};

/// The posed rest surface of an organ: reads options.mesh, applies unit_m, then X_WO. Throws
/// InputError. `repairs` gets one line a repair of the file.
SurfaceMesh LoadPosedMesh(const OrganOptions& options, std::vector<std::string>* repairs);

}  // namespace hpdm
