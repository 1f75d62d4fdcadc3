#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/contact/half_space.h"
#include "engine/lattice/relocation.h"
#include "engine/organ/lattice_organ.h"
#include "engine/organ/organ_mechanics.h"
#include "engine/organ/surface_organ.h"
#include "engine/snapshots.h"

namespace hpdm {

/// The constant part of an organ, built once from its options and mesh. Any thread may read it.
/// Copies share all of it.
class OrganModel {
 public:
  /// `rest`: the posed rest surface, world, m. Throws InputError (organ's name, fault, remedy) if
  /// the model cannot be built, for example without volume or with a support without tissue.
  OrganModel(const OrganOptions& options, SurfaceMesh rest);

  const OrganOptions& options() const { return surface_->options; }
  const SurfaceMesh& rest() const { return surface_->rest; }
  const Points& rest_normals() const { return surface_->rest_normals; }  ///< V x 3, unit.
  const SurfaceTopology& topology() const { return surface_->topology; }
  /// The rest surface by large triangles; nullptr if its own are large.
  const CoarseSurface* coarse_surface() const {
    return surface_->coarse ? &*surface_->coarse : nullptr;
  }
  /// True if the organ does not deform (rigid_organ.h). The hand feels a virtual wall with the
  /// tool's stiffness (ToolOptions) unless the options give one.
  bool rigid() const { return options().model == OrganModelType::kRigid; }
  /// The organ's lattice and its tissue; nullptr unless the model is "hpdm".
  const LatticeOrgan* lattice_organ() const {
    return dynamic_cast<const LatticeOrgan*>(mechanics_.get());
  }
  /// True if the control points and their grid do not describe the surface, because functions are
  /// split by tissue or stand on several levels: outside the engine the vertices' displacements
  /// stand for them.
  bool HasSplitFunctions() const {
    const LatticeOrgan* organ = lattice_organ();
    return organ != nullptr && organ->split();
  }
  /// The springs of model "mass_spring" at rest, to copy; nullptr for the other models.
  const MassSpring* springs() const {
    const auto* surface = dynamic_cast<const SurfaceOrgan*>(mechanics_.get());
    return surface != nullptr ? surface->springs() : nullptr;
  }
  /// Mass of a free organ; nullptr for others.
  const FreeBody* free_body() const {
    const LatticeOrgan* organ = options().free ? lattice_organ() : nullptr;
    return organ != nullptr ? organ->free_body() : nullptr;
  }
  int control_points() const { return static_cast<int>(weights().cols()); }  ///< n.
  const WeightMatrix& weights() const { return mechanics_->weights(); }      ///< V x n.
  const Relocation& relocation() const { return *relocation_; }              ///< Eq. 4.
  /// Stiffness with supports, N/m. It is n x n for the metric energy and the continuum. For the
  /// strain energy, and for finite strain of either energy (at rest), it is 3n x 3n. It is empty
  /// for mass_spring, whose stiffness changes with its motion, and for a rigid organ.
  const LatticeStiffness& stiffness() const { return mechanics_->stiffness(); }
  /// The energy of finite strain (Clone() it to use it), or nullptr for a constant stiffness.
  const ElasticEnergy* finite_energy() const { return mechanics_->finite_energy(); }
  double tissue_volume() const { return mechanics_->tissue_volume(); }  ///< m^3.
  /// World, m.
  const Vector3d& centre_of_volume_W() const { return mechanics_->centre_of_volume_W(); }
  /// Valid but suspicious inputs, one line each.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Returns a new solver for the energy in the options, with `slots` slots for local functions.
  /// `clock` (session time) enforces the time budget of finite strain; without a clock (lockstep)
  /// only iterations are limited.
  std::unique_ptr<Relaxation> MakeRelaxation(int slots,
                                             std::function<Nanoseconds()> clock = nullptr) const {
    return mechanics_->MakeRelaxation(slots, std::move(clock));
  }

  /// Lattice row of a vertex, without local functions.
  SparseRow LatticeRow(int vertex) const;
  /// Values of the local functions at a vertex, of an organ that has some.
  SparseRow FinerRow(int vertex) const;
  /// Basis of the local functions; nullptr if the organ has none.
  const RefinementBasis* refinement_basis() const { return mechanics_->refinement_basis(); }
  /// Number of slots for local functions at `contacts` places; 0 if the organ has none.
  int RefinementSlots(int contacts) const;
  /// Adds `weight` times the basis values at a surface point to `row` (n + slots of `active`). The
  /// basis is the lattice (or the triangle's corners), then the local functions in use. No
  /// allocation.
  void AddToRow(const SurfacePoint& at, double weight, const ActiveRefinement& active,
                Eigen::Ref<Eigen::RowVectorXd> row) const {
    mechanics_->AddToRow(at, weight, active, row);
  }

  /// Adds the displacements by the local functions in use to `vertices` (V x 3, m). `U`: (n +
  /// slots) x 3, m. No allocation.
  void AddLocalDisplacements(const ActiveRefinement& active, const Points& U,
                             Points* vertices) const {
    mechanics_->AddLocalDisplacements(active, U, vertices);
  }
  /// Adds an indentation to the `vertices` (V x 3, m, any scalar) on its side of the surface. O(V),
  /// no allocation.
  template <typename Vertices>
  void AddIndentation(const IndentationSnapshot& indentation, Vertices* vertices) const;

  /// Returns the kernel radius (m, at least `radius`) that spreads a force on a patch of `radius`
  /// over the lattice (half_space.h). It is the radius that the finest functions resolve, or a
  /// third of the tissue's thickness there, whichever is smaller. No allocation.
  double ResolvedRadius(const SurfacePoint& at, double radius) const {
    return mechanics_->ResolvedRadius(at, radius);
  }
  /// Returns the kernel radius that the finest functions resolve, m; 0 if contact rows have no
  /// local compliance to each other: other mechanics than a lattice with a strain energy, and the
  /// Gauss-Seidel solver.
  double FinestRadius() const { return mechanics_->FinestRadius(); }
  /// Returns the material at a surface point: Young's modulus is that of its region.
  MaterialOptions MaterialAt(const SurfacePoint& at) const;
  /// Returns the local indentation that the lattice does not resolve; none for an organ without a
  /// Young's modulus. No allocation.
  LocalIndentation Indentation(const SurfacePoint& at, double radius) const;
  /// Adds the resolved kernel of a load's patch of `radius` (m) around the rest point `p_centre_W`
  /// (m) to `row` and returns the unresolved indentation. Set-up only; throws InputError if no
  /// surface lies within the radius.
  LocalIndentation AddLoadToRow(const Vector3d& p_centre_W, double radius,
                                const ActiveRefinement& active,
                                Eigen::Ref<Eigen::RowVectorXd> row) const;

 private:
  std::vector<std::string> warnings_;
  std::shared_ptr<const OrganSurface> surface_;
  std::shared_ptr<const OrganMechanics> mechanics_;
  std::shared_ptr<const Relocation> relocation_;
};

template <typename Vertices>
void OrganModel::AddIndentation(const IndentationSnapshot& indentation, Vertices* vertices) const {
  const double reach = IndentationReach(indentation.radius, indentation.resolved_radius);
  for (Eigen::Index v = 0; v < vertices->rows(); ++v) {
    const double distance2 =
        (rest().vertices.row(v).transpose() - indentation.p_rest_W).squaredNorm();
    if (distance2 >= reach * reach) continue;
    if (rest_normals().row(v).dot(indentation.normal_W) <= 0) continue;
    const Vector3d moved =
        IndentationProfile(std::sqrt(distance2), indentation.radius, indentation.resolved_radius) *
        indentation.amplitude_W;
    vertices->row(v) += moved.transpose().template cast<typename Vertices::Scalar>();
  }
}

/// Scales an indentation by the force on the tissue (N) at a rest point (m).
IndentationSnapshot AppliedIndentation(const LocalIndentation& indentation,
                                       const Vector3d& p_rest_W, const Vector3d& force_W);

/// Returns the posed rest surface of an organ: reads options.mesh, applies unit_m, subdivides it,
/// then applies X_WO. Appends one line per repair of the file to `repairs`. Throws InputError.
SurfaceMesh LoadPosedMesh(const OrganOptions& options, std::vector<std::string>* repairs);

}  // namespace hpdm
