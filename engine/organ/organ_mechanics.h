#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <variant>

#include "engine/energy/elastic_energy.h"
#include "engine/lattice/active_refinement.h"
#include "engine/lattice/lattice.h"
#include "engine/mesh/coarse_surface.h"
#include "engine/mesh/mesh_facts.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/mesh/surface_topology.h"
#include "engine/organ_options.h"
#include "engine/solver/refinement_basis.h"
#include "engine/solver/relaxation.h"

namespace hpdm {

/// Either one n x n matrix for all three axes, or a 3n x 3n matrix that couples them.
using LatticeStiffness = std::variant<ScalarStiffness, FullStiffness>;

/// An organ's options and its posed surface at rest, world, m. Constant.
struct OrganSurface {
  OrganSurface(const OrganOptions& organ_options, SurfaceMesh posed);

  OrganOptions options;
  SurfaceMesh rest;
  Box bounds;
  Points rest_normals;  ///< V x 3, unit.
  SurfaceTopology topology;
  std::optional<CoarseSurface> coarse;  ///< Of `rest`.
};

/// How the tissue under an organ's surface deforms: n control points move V vertices. A lattice
/// (lattice_organ.h), the surface itself (surface_organ.h), or nothing (rigid_organ.h). Constant
/// once built; any thread may read it.
class OrganMechanics {
 public:
  virtual ~OrganMechanics() = default;

  const WeightMatrix& weights() const { return weights_; }  ///< V x n.
  /// V x N, values of the local functions at the vertices; empty if there are none.
  const WeightMatrix& finer_weights() const { return finer_weights_; }
  /// Stiffness with supports, N/m (OrganModel::stiffness).
  const LatticeStiffness& stiffness() const { return stiffness_; }
  double tissue_volume() const { return tissue_volume_; }                     ///< m^3.
  const Vector3d& centre_of_volume_W() const { return centre_of_volume_W_; }  ///< m.

  /// The energy of finite strain (Clone() it to use it), or nullptr for a constant stiffness.
  virtual const ElasticEnergy* finite_energy() const { return nullptr; }
  /// Basis of the local functions; nullptr if the organ has none.
  virtual const RefinementBasis* refinement_basis() const { return nullptr; }

  /// See OrganModel, for each.
  virtual std::unique_ptr<Relaxation> MakeRelaxation(int slots,
                                                     std::function<Nanoseconds()> clock) const = 0;
  virtual void AddToRow(const SurfacePoint& at, double weight, const ActiveRefinement& active,
                        Eigen::Ref<Eigen::RowVectorXd> row) const = 0;
  virtual void AddLocalDisplacements(const ActiveRefinement& /*active*/, const Points& /*U*/,
                                     Points* /*vertices*/) const {}
  /// True if the material's Young's modulus is that of the organ.
  virtual bool HasModulus() const { return false; }
  virtual double ResolvedRadius(const SurfacePoint& /*at*/, double radius) const { return radius; }
  virtual double FinestRadius() const { return 0; }

 protected:
  /// `surface` must outlive it.
  explicit OrganMechanics(const OrganSurface& surface) : surface_(surface) {}
  const OrganOptions& options() const { return surface_.options; }
  const SurfaceMesh& rest() const { return surface_.rest; }

  const OrganSurface& surface_;
  WeightMatrix weights_;
  WeightMatrix finer_weights_;
  LatticeStiffness stiffness_;
  double tissue_volume_ = 0;
  Vector3d centre_of_volume_W_ = Vector3d::Zero();
};

}  // namespace hpdm
