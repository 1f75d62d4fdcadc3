#include "haptics/contact/lattice_reaction.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "engine/contact/contact_solver.h"

namespace hpdm {
namespace {

constexpr double kNeighbourDistance = 1e10;  // m

// Coincident tips act as one contact. Fractions of their own compliance are added to separate them,
// as in the step's contact solver. These are the smallest, and the largest for tips that move apart
// and slip.
constexpr double kApart = 1e-9;
constexpr double kMaxApart = 1;

// Direction a of the force on the tissue: F = f_n a.
Vector3d Direction(const CondensedTip& tip) { return tip.friction_W - tip.normal_W; }

// Two presses: f >= 0, A f >= depth, f . (A f - depth) = 0.
void SolvePresses(const CondensedTip& a, const CondensedTip& c, const Matrix3d& C_ac, double* f_a,
                  double* f_c) {
  const double A_aa = -a.normal_W.dot(a.compliance_W * Direction(a));
  const double A_cc = -c.normal_W.dot(c.compliance_W * Direction(c));
  const double A_ac = -a.normal_W.dot(C_ac * Direction(c));
  const double A_ca = -c.normal_W.dot(C_ac.transpose() * Direction(a));
  const double determinant = A_aa * A_cc - A_ac * A_ca;
  *f_a = A_aa > 0 ? std::max(0.0, a.depth / A_aa) : 0;
  *f_c = A_cc > 0 ? std::max(0.0, c.depth / A_cc) : 0;
  if (!(determinant > 0)) return;  // interpolation made A indefinite: solve each tip alone
  const double both_a = (A_cc * a.depth - A_ac * c.depth) / determinant;
  const double both_c = (A_aa * c.depth - A_ca * a.depth) / determinant;
  if (both_a >= 0 && both_c >= 0) {
    *f_a = both_a;
    *f_c = both_c;
  } else if (A_ca * *f_a >= c.depth) {
    *f_c = 0;  // a alone keeps the tissue away from c
  } else {
    *f_a = 0;
  }
}

// Tip a, condensed on the grasp of c.
CondensedTip BesideHeld(const CondensedTip& a, const CondensedTip& c, const Matrix3d& C_ac) {
  const Eigen::LDLT<Matrix3d> own(c.compliance_W);
  CondensedTip tip = a;
  const Vector3d moved = C_ac * own.solve(c.p_current_W - c.p_original_W);
  tip.p_original_W += moved;
  tip.depth += a.normal_W.dot(moved);
  tip.compliance_W -= C_ac * own.solve(C_ac.transpose());
  return tip;
}

// Solves the two tips without regard to coincidence.
void Couple(const CondensedTip& a, const CondensedTip& c, const Matrix3d& coupling_W,
            Vector3d* force_a_W, Vector3d* force_c_W) {
  if (!a.holds && !c.holds) {
    double f_a = 0, f_c = 0;
    SolvePresses(a, c, coupling_W, &f_a, &f_c);
    *force_a_W = f_a * Direction(a);
    *force_c_W = f_c * Direction(c);
    return;
  }
  if (!c.holds) {
    Couple(c, a, coupling_W.transpose(), force_c_W, force_a_W);
    return;
  }
  *force_a_W = TipForce(BesideHeld(a, c, coupling_W));
  CondensedTip rest = c;
  rest.p_original_W += coupling_W.transpose() * *force_a_W;
  *force_c_W = TipForce(rest);
}

}  // namespace

Vector3d TipForce(const CondensedTip& tip) noexcept {
  if (tip.holds) return tip.compliance_W.ldlt().solve(tip.p_current_W - tip.p_original_W);
  const double compliance = -tip.normal_W.dot(tip.compliance_W * Direction(tip));
  if (!(compliance > 0) || !(tip.depth > 0)) return Vector3d::Zero();
  return tip.depth / compliance * Direction(tip);
}

void TipForces(const CondensedTip& a, const CondensedTip& c, const Matrix3d& coupling_W,
               Vector3d* force_a_W, Vector3d* force_c_W) noexcept {
  double apart = kApart;
  const auto solve = [&] {
    CondensedTip tip_a = a, tip_c = c;
    tip_a.compliance_W *= 1 + apart;
    tip_c.compliance_W *= 1 + apart;
    Couple(tip_a, tip_c, coupling_W, force_a_W, force_c_W);
    return std::max(force_a_W->norm(), force_c_W->norm());
  };
  const double alone = std::max(TipForce(a).norm(), TipForce(c).norm());
  if (!(solve() > ContactSolver::kContradicting * alone)) return;
  do {
    apart *= 10;
  } while (solve() > ContactSolver::kSlipping * alone && apart < kMaxApart);
}

ReactionNode NodeOfCompliance(const Matrix3d& C) noexcept {
  // Eigenvalues ascend in C, so they descend in S.
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(C);
  const Vector3d stiffness = eigen.eigenvalues().cwiseInverse();
  ReactionNode node;
  node.k1 = stiffness[2];
  node.neighbour_count = 2;
  for (int i = 0; i < 2; ++i) {
    const Vector3d edge = kNeighbourDistance * eigen.eigenvectors().col(i);
    node.neighbours[i] = {edge, edge.norm(), stiffness[i] - stiffness[2]};
  }
  return node;
}

}  // namespace hpdm
