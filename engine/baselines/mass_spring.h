#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/baselines/contact_forces.h"
#include "engine/baselines/skin.h"
#include "engine/organ_options.h"
#include "engine/solver/relaxation.h"

namespace hpdm {

/// A spring between two vertices.
struct Spring {
  enum class Kind : std::uint8_t { kStructural, kShear, kFlexion };
  int a = 0;
  int b = 0;
  double length = 0;     ///< At rest, m.
  double stiffness = 0;  ///< N/m.
  Kind kind = Kind::kStructural;
};

struct MassSpringOptions {
  double alpha = 2000;         ///< Pa; the skin's modulus is alpha x thickness (skin.h).
  double shear = 0.5;          ///< Stiffness of the shear springs, of that of an edge like them.
  double flexion = 0.5;        ///< The same of the flexion springs.
  double home = 0;             ///< Pa/m^2: springs to rest of every vertex, by its volume.
  double density = 1060;       ///< kg/m^3.
  double damping = 20;         ///< 1/s, force per momentum.
  double time_step = 1. / 30;  ///< s, of one Relax.
  int substeps = 0;            ///< In one time step; 0: as many as stability asks.
};

/// What the springs are for a material, from the organ's `thickness` (m, skin.h): alpha = 3.2 E'
/// and home = 0.32 E' / thickness^2 with E' = E / (1 - nu^2). No springs on a surface are that
/// material: the two factors are those of a search in steps of 10^0.5 that answer
/// scenes/cases/liver_press.toml about best, 91 % off quadratic tetrahedra with 1.02 of their
/// compliance. Without springs to rest a flat part has next to nothing against a press (several
/// times too soft); stiffer edges than these gain 0.3 % and cost substeps.
MassSpringOptions MassSpringOf(const MaterialOptions& material, double thickness, double time_step);

/// The springs of Eq. 23-25 (Provot 1995's three kinds) on a triangle mesh:
/// - structural: the edges;
/// - shear: the two corners that face each other across an edge, the other diagonal of its two
///   triangles;
/// - flexion: from a neighbour of a vertex over that vertex to the neighbour that continues most
///   nearly straight on (at least 135 degrees apart), so that both paths bend alike.
/// No pair twice, the first kind wins. An edge has the stiffness modulus x area of its triangles /
/// length^2, which gives the sheet the Young's modulus `modulus` (N/m) on even triangles (Van
/// Gelder 1998); the other kinds the same by the triangles that they span, times their factor.
std::vector<Spring> SurfaceSprings(const SurfaceMesh& rest, double modulus, double shear,
                                   double flexion);

/// The second model that the paper compares with: vertices as point masses, explicit integration.
///     m dv/dt + c m v = -sum k (l - d l / |l|) + springs to rest + contacts   (Eq. 23-25, with the
/// norms that Eq. 24 lost), d: rest length, by symplectic Euler: velocity first, then position from
/// the new velocity. What has a diagonal matrix (springs to rest, damping) is taken at the end of a
/// substep, so that neither limits it. Rigid motions cost nothing but the springs to rest.
///
/// A surface of springs alone has no volume to keep and, where it is flat, nothing but flexion
/// springs against a press; `home` holds the shape as springs to rest usually do for such models.
class MassSpring final : public Relaxation {
 public:
  /// Share of SafeSubstep() that a substep takes.
  static constexpr double kSafety = 0.95;

  /// `rest`: closed; `ground_springs`: V, N/m (GroundSprings). Throws InputError (`name`: the
  /// organ's) when the surface cannot be measured.
  MassSpring(const SurfaceMesh& rest, const Eigen::VectorXd& ground_springs,
             const MassSpringOptions& options, const std::string& name);

  /// One time step of substeps() substeps, over which the targets of contacts that are to move (and
  /// the planes of presses that are pierced) go there evenly; the contacts hold after each substep.
  /// The rows' forces are the means over the step; residual is the static one at its end. Contact
  /// rows are over the V vertices; `U` (V x 3, m) is the displacement at the end of the step: only
  /// set, as the masses have their own motion. Deformation thread; allocates nothing.
  RelaxationResult Relax(ContactConstraints* contacts, Points* U) override;
  bool AtRest() const override { return v_.isZero(0) && p_ == rest_; }

  /// Starts from the displacement `u` (V x 3, m) without velocity.
  void Reset(const Points& u);

  /// Forces of the springs between vertices at positions `p` (V x 3, m), V x 3, N.
  void SpringForces(const Points& p, Points* forces) const;
  /// Energy that they store, J: 1/2 sum k (|l| - d)^2.
  double SpringEnergy(const Points& p) const;

  /// Longest substep with which small motion about rest is stable without damping, s:
  /// 2 / sqrt(largest eigenvalue of M^-1 K), K the springs' tangent at rest.
  double StableSubstepAtRest() const;
  /// The same for any state whose springs are not compressed, s: the tangent of a spring is then at
  /// most k in every direction. Not above StableSubstepAtRest().
  double SafeSubstep() const;

  /// Minus the forces that the springs and those to rest put on the masses displaced by `u`
  /// (V x 3, m): V x 3, N, the gradient of StoredEnergy().
  Points RestoringForces(const Points& u) const;
  /// What all of them store then, J.
  double StoredEnergy(const Points& u) const;

  const Points& rest() const { return rest_; }               ///< V x 3, m.
  const Eigen::VectorXd& ground() const { return ground_; }  ///< V, N/m: supports, home springs.
  const std::vector<Spring>& springs() const { return springs_; }
  const Points& velocity() const { return v_; }  ///< V x 3, m/s.
  double Mass() const { return mass_.sum(); }    ///< kg.
  int substeps() const { return substeps_; }
  /// Springs plus masses: what a substep visits.
  std::int64_t SubstepVisits() const {
    return static_cast<std::int64_t>(springs_.size()) + mass_.size();
  }

 private:
  MassSpring(const SurfaceMesh& rest, const Skin& skin, const Eigen::VectorXd& ground_springs,
             const MassSpringOptions& options);
  void Substep(double share, RelaxationResult* result, ContactConstraints* contacts);
  void SolveContacts(double share, RelaxationResult* result, ContactConstraints* contacts);
  double StaticResidual(const ContactConstraints& contacts);

  MassSpringOptions options_;
  Points rest_;             // V x 3, m
  Eigen::VectorXd mass_;    // V, kg
  Eigen::VectorXd ground_;  // V, N/m: supports and home springs
  std::vector<Spring> springs_;
  int substeps_ = 1;
  double h_ = 0;                    // s
  Eigen::VectorXd effective_mass_;  // V, kg: m (1 + h c) + h^2 ground
  Points p_;                        // V x 3, m
  Points v_;                        // V x 3, m/s
  Points force_;                    // V x 3, N
  ContactRows rows_;
  ContactSolver contact_solver_;
  ContactCompliance compliance_;  // h^2 B M^-1 B^T
  ContactPoints start_W_;         // contact points when the step began
  ContactPoints p_free_W_;
  ContactPoints targets_W_;
  ContactPoints force_sum_;
};

}  // namespace hpdm
