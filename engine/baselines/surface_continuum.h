#pragma once

#include <memory>
#include <string>

#include "engine/baselines/contact_forces.h"
#include "engine/baselines/skin.h"
#include "engine/solver/relaxation.h"
#include "engine/solver/sparse_cholesky.h"

namespace hpdm {

/// Returns the stiffness K of a surface over its vertices, V x V, N/m, with the energy
///     E(u) = 1/2 int tension |grad u|^2 + bending |Laplace u|^2 da = 1/2 u^T K u,
/// `tension` in N/m and `bending` in N m.
///
/// 1. Model: the elastic surface of Terzopoulos, Platt, Barr and Fleischer, "Elastically Deformable
///    Models" (SIGGRAPH 1987). Its energy takes the first and second fundamental form about the
///    rest shape (Eq. 13-18 of the paper).
/// 2. In the paper the metric's force acts on positions with the weight alpha = 4 eta (G - G0),
///    which vanishes at rest. It is the variation of eta |G - G0|^2; Eq. 17 lost the 4.
/// 3. Here constant weights act on displacements, as for the lattice, so K is factorised once. For
///    small displacements without rotation, eta |G - G0|^2 is this energy with tension = 8 eta.
/// 4. Translations cost no energy, rotations do, as in the lattice's "metric" energy.
/// 5. Discretisation on the organ's triangles: The metric uses linear elements, that is cotangent
///    weights (Pinkall and Polthier 1993). The curvature uses L^T M^-1 L with vertex areas M, the
///    linearised thin shell of Botsch and Sorkine 2008. Both are symmetric and positive
///    semi-definite with zero row sums on any mesh. Triangles without area are left out.
ScalarStiffness SurfaceStiffness(const SurfaceMesh& rest, const Eigen::VectorXd& areas,
                                 double tension, double bending);

struct SurfaceContinuumOptions {
  double alpha = 2000;  ///< Pa; the surface's tension is alpha x thickness (skin.h).
  /// N; the bending stiffness is beta x thickness. The default, alpha (20 mm)^2, makes a 15 mm
  /// press as wide as on a quadratic lattice of 6^3 cells with the same alpha.
  double beta = 0.8;
  double density = 1060;       ///< kg/m^3.
  double damping = 20;         ///< 1/s, force per momentum: C = damping M.
  double time_step = 1. / 30;  ///< s; infinity: every step is the static solution.
  /// If set, each step also computes the static residual (RelaxationResult::residual). It costs one
  /// product with K.
  bool report_residual = true;
};

/// Returns the surface for a material, from the organ's `thickness` (m, skin.h):
///     alpha = 0.18 E',   beta = 0.32 E' thickness^2,
/// with the modulus E' = E / (1 - nu^2) of a sheet or a press in bulk. A surface without tissue
/// under it only approximates a solid. The two factors have the least error in
/// scenes/cases/liver_press.toml (search in steps of 10^0.25): 58 % against quadratic tetrahedra,
/// with 0.64 of their compliance. Additional springs to rest would give 57 %. The errors in the
/// other cases are 59 to 107 %.
SurfaceContinuumOptions ContinuumOf(const MaterialOptions& material, double thickness,
                                    double time_step);

/// The surface model that the paper compares with: the semi-implicit scheme of Terzopoulos et al.,
/// section 6, on displacements u with v = (u_t - u_{t-dt}) / dt:
///     (K + M/dt^2 + C/2dt) u_{t+dt} = (M/dt^2 + C/2dt) u_t + (M/dt - C/2) v_t + B^T f,
/// stable for any dt. The matrix is constant and factorised once. A step is one pair of triangular
/// solves. Between the two, the contact forces f follow from the rows' compliance. So the contacts
/// hold exactly at t + dt. Unlike the lattice, the surface has a velocity: Relax only writes `U`,
/// and steps must be taken in order.
class SurfaceContinuum final : public Relaxation {
 public:
  /// `rest`: closed; `ground_springs`: V, N/m (GroundSprings). Throws InputError (`name`: the
  /// organ's) if the surface cannot be measured or, for an infinite time step, nothing holds it.
  SurfaceContinuum(const SurfaceMesh& rest, const Eigen::VectorXd& ground_springs,
                   const SurfaceContinuumOptions& options, const std::string& name);

  std::unique_ptr<Relaxation> Clone() const override {
    return std::make_unique<SurfaceContinuum>(*this);
  }
  void Take(const Relaxation& other) override {
    *this = static_cast<const SurfaceContinuum&>(other);
  }
  bool AtRest() const override { return v_.isZero(0) && u_.isZero(0); }

  /// Starts from the displacement `u` (V x 3, m) without velocity.
  void Reset(const Points& u);

  const ScalarStiffness& stiffness() const { return K_; }  ///< V x V, N/m, with ground springs.
  const Points& velocity() const { return v_; }            ///< V x 3, m/s.
  double Mass() const { return mass_.sum(); }              ///< kg.
  /// Number of multiplications in a step without contacts.
  std::int64_t StepMultiplications() const;

 private:
  // Runs one time step. Contact rows are over the V vertices; `U` (V x 3, m) is the displacement at
  // its end.
  RelaxationResult DoRelax(const RelaxationInput& input, ContactConstraints* contacts,
                           Points* U) override;
  SurfaceContinuum(const SurfaceMesh& rest, const Skin& skin, const Eigen::VectorXd& ground_springs,
                   const SurfaceContinuumOptions& options, const std::string& name);
  ScalarStiffness StepMatrix() const;
  double StaticResidual(const ContactConstraints& contacts);

  SurfaceContinuumOptions options_;
  Eigen::VectorXd mass_;  // V, kg
  ScalarStiffness K_;
  SparseCholesky factor_;
  Points u_;                  // V x 3, m
  Points v_;                  // V x 3, m/s
  Points solution_;           // V x 3, in factor order
  Points pull_;               // V x 3, N: K u
  Eigen::MatrixXd response_;  // V x kMaxContacts: L^-1 P B^T
  ContactRows rows_;
  ContactSolver contact_solver_;
  ContactCompliance compliance_;
  ContactPoints p_free_W_;
  ContactPoints targets_W_;
};

}  // namespace hpdm
