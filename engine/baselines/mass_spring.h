#pragma once

#include <cstdint>
#include <memory>
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
  double length = 0;     ///< Rest length, m.
  double stiffness = 0;  ///< N/m.
  Kind kind = Kind::kStructural;
};

struct MassSpringOptions {
  double alpha = 2000;         ///< Pa; the skin's modulus is alpha x thickness (skin.h).
  double shear = 0.5;          ///< Stiffness of a shear spring relative to an equal edge.
  double flexion = 0.5;        ///< Stiffness of a flexion spring relative to an equal edge.
  double home = 0;             ///< Pa/m^2: spring to rest per volume of each vertex.
  double density = 1060;       ///< kg/m^3.
  double damping = 20;         ///< 1/s, force per momentum.
  double time_step = 1. / 30;  ///< s per Relax.
  int substeps = 0;            ///< Substeps per time step; 0: as many as stability needs.
};

/// Returns springs for a material, from the organ's `thickness` (m, skin.h):
///     alpha = 3.2 E',   home = 0.32 E' / thickness^2,   E' = E / (1 - nu^2).
/// Springs on a surface only approximate a solid. The two factors come from a search in steps of
/// 10^0.5 and are about the best for scenes/cases/liver_press.toml. Against quadratic tetrahedra
/// they have an error of 91 % and 1.02 of the compliance. Without springs to rest a flat part
/// hardly resists a press (several times too soft). Stiffer edges gain 0.3 % and cost substeps.
MassSpringOptions MassSpringOf(const MaterialOptions& material, double thickness, double time_step);

/// Returns the springs of Eq. 23-25 (Provot 1995's three kinds) on a triangle mesh:
/// - structural: the edges;
/// - shear: the two corners opposite an edge, the other diagonal of its two triangles;
/// - flexion: two neighbours of a vertex that lie most nearly on a straight line through it (at
///   least 135 degrees apart).
/// Each pair occurs once, with the first kind that has it. The stiffness of an edge is modulus x
/// area of its triangles / length^2. On even triangles this gives the sheet the Young's modulus
/// `modulus` (N/m) (Van Gelder 1998). The other kinds use the triangles that they span, times their
/// factor.
std::vector<Spring> SurfaceSprings(const SurfaceMesh& rest, double modulus, double shear,
                                   double flexion);

/// The second model that the paper compares with: vertices as point masses, explicit integration of
///     m dv/dt + c m v = -sum k (l - d l / |l|) + springs to rest + contacts
/// (Eq. 23-25 with the norms that Eq. 24 lost; d: rest length).
///
/// 1. Symplectic Euler: velocity first, then position from the new velocity.
/// 2. Springs to rest and damping have a diagonal matrix and are implicit, so that they do not
///    limit the substep.
/// 3. Rigid motions strain only the springs to rest.
/// 4. A surface of springs does not preserve volume, and where it is flat only flexion springs
///    resist a press. `home` holds the shape, as is usual for such models.
class MassSpring final : public Relaxation {
 public:
  /// Share of SafeSubstep() that a substep takes.
  static constexpr double kSafety = 0.95;

  /// `rest`: closed; `ground_springs`: V, N/m (GroundSprings). Throws InputError (`name`: the
  /// organ's) if the surface cannot be measured.
  MassSpring(const SurfaceMesh& rest, const Eigen::VectorXd& ground_springs,
             const MassSpringOptions& options, const std::string& name);

  std::unique_ptr<Relaxation> Clone() const override { return std::make_unique<MassSpring>(*this); }
  void Take(const Relaxation& other) override { *this = static_cast<const MassSpring&>(other); }
  bool AtRest() const override { return v_.isZero(0) && p_ == rest_; }

  /// Starts from the displacement `u` (V x 3, m) without velocity.
  void Reset(const Points& u);

  /// Forces of the springs between vertices at positions `p` (V x 3, m), V x 3, N.
  void SpringForces(const Points& p, Points* forces) const;
  /// Energy of the springs between vertices, J: 1/2 sum k (|l| - d)^2.
  double SpringEnergy(const Points& p) const;

  /// Longest substep with which small motion about rest is stable without damping, s:
  /// 2 / sqrt(largest eigenvalue of M^-1 K), K the springs' tangent at rest.
  double StableSubstepAtRest() const;
  /// Longest stable substep for any state without compressed springs, s: there a spring's tangent
  /// is at most k in every direction. Not above StableSubstepAtRest().
  double SafeSubstep() const;

  /// Gradient of StoredEnergy() at the displacement `u` (V x 3, m), V x 3, N: minus the forces of
  /// all springs, those to rest included.
  Points RestoringForces(const Points& u) const;
  /// Energy of all springs at the displacement `u`, J.
  double StoredEnergy(const Points& u) const;

  const Points& rest() const { return rest_; }               ///< V x 3, m.
  const Eigen::VectorXd& ground() const { return ground_; }  ///< V, N/m: supports, home springs.
  const std::vector<Spring>& springs() const { return springs_; }
  const Points& velocity() const { return v_; }  ///< V x 3, m/s.
  double Mass() const { return mass_.sum(); }    ///< kg.
  int substeps() const { return substeps_; }
  /// Springs plus masses that a substep visits.
  std::int64_t SubstepVisits() const {
    return static_cast<std::int64_t>(springs_.size()) + mass_.size();
  }

 private:
  // Runs one time step of substeps() substeps:
  // - Contact targets (and the planes of pierced presses) move evenly over the substeps, and the
  //   contacts hold after each substep.
  // - Contact rows are over the V vertices. Their forces are means over the step.
  // - `U` (V x 3, m) is only written: the displacement at the end of the step.
  // - The result's residual is the static one at the end.
  RelaxationResult DoRelax(const RelaxationInput& input, ContactConstraints* contacts,
                           Points* U) override;
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
