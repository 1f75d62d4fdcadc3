#include "haptics/contact/lattice_reaction.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <utility>

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

// Newton's method for the tips' local laws takes two to seven rounds.
constexpr int kMaxRounds = 12;
constexpr double kSettledForce = 1e-9;  // last change of a force over the force

// The equation of one press: depth = f (compliance + along q(f)), q = LocalIndentation::BallYield.
struct PressEquation {
  explicit PressEquation(const CondensedTip& tip)
      : indentation(tip.indentation),
        depth(tip.depth),
        compliance(-tip.normal_W.dot(tip.compliance_W * Direction(tip))),
        along(-tip.normal_W.dot(tip.indentation.factor_W() * Direction(tip))) {}

  double ForceAlone() const {
    return compliance > 0 && depth > 0 ? indentation.PressingForce(depth, compliance, along) : 0;
  }
  double Slope(double f) const { return compliance + along * indentation.BallYieldRate(f); }
  // Depth of the linear law with the slope at f.
  double LinearDepth(double f) const {
    return depth - along * f * (indentation.BallYield(f) - indentation.BallYieldRate(f));
  }

  const LocalIndentation& indentation;
  double depth, compliance, along;
};

// Two presses that both act: A f = depth. Starts at f_a and f_c.
void SolveBoth(const PressEquation& a, const PressEquation& c, double A_ac, double A_ca,
               double* f_a, double* f_c) {
  double next_a = *f_a, next_c = *f_c;
  for (int round = 0; round < kMaxRounds; ++round) {
    const double at_a = next_a, at_c = next_c;
    const double A_aa = a.Slope(at_a), A_cc = c.Slope(at_c);
    const double depth_a = a.LinearDepth(at_a), depth_c = c.LinearDepth(at_c);
    const double determinant = A_aa * A_cc - A_ac * A_ca;
    if (!(determinant > 0)) return;  // interpolation made A indefinite: solve each tip alone
    next_a = std::max(0.0, (A_cc * depth_a - A_ac * depth_c) / determinant);
    next_c = std::max(0.0, (A_aa * depth_c - A_ca * depth_a) / determinant);
    if (std::abs(next_a - at_a) + std::abs(next_c - at_c) <= kSettledForce * (next_a + next_c))
      break;
  }
  *f_a = next_a;
  *f_c = next_c;
}

// Two presses: f >= 0, A f >= depth, f . (A f - depth) = 0.
void SolvePresses(const CondensedTip& a, const CondensedTip& c, const Matrix3d& C_ac, double* f_a,
                  double* f_c) {
  const PressEquation of_a(a), of_c(c);
  const double A_ac = -a.normal_W.dot(C_ac * Direction(c));
  const double A_ca = -c.normal_W.dot(C_ac.transpose() * Direction(a));
  *f_a = of_a.ForceAlone();
  *f_c = of_c.ForceAlone();
  if (A_ca * *f_a >= c.depth) {
    *f_c = 0;  // a alone keeps the tissue away from c
  } else if (A_ac * *f_c >= a.depth) {
    *f_a = 0;
  } else {
    SolveBoth(of_a, of_c, A_ac, A_ca, f_a, f_c);
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

Matrix3d ComplianceAt(const CondensedTip& tip, const Vector3d& force_W) noexcept {
  if (tip.holds || !tip.indentation.indents()) return tip.compliance_W;
  const double f_n = std::max(0.0, -tip.normal_W.dot(force_W));
  return tip.compliance_W + tip.indentation.BallYield(f_n) * tip.indentation.factor_W();
}

double TipEnergy(const CondensedTip& tip, const Vector3d& force_W) noexcept {
  const double lattice = 0.5 * force_W.dot(tip.compliance_W * force_W);
  const double f = -tip.normal_W.dot(force_W);
  if (tip.holds || !tip.indentation.indents() || !(f > 0)) return lattice;
  // The integral of f d(f q), where d(f q) = BallYieldRate df, by Gauss' rule with three points.
  constexpr double kAside = 0.3872983346207417;  // sqrt(3 / 20)
  double sum = 0;
  for (const auto& [share, weight] :
       {std::pair(0.5 - kAside, 5.0 / 18), {0.5, 8.0 / 18}, {0.5 + kAside, 5.0 / 18}}) {
    sum += weight * share * f * f * tip.indentation.BallYieldRate(share * f);
  }
  const Vector3d a_W = force_W / f;
  return lattice + sum * a_W.dot(tip.indentation.factor_W() * a_W);
}

Vector3d TipForce(const CondensedTip& tip) noexcept {
  if (tip.holds) return tip.compliance_W.ldlt().solve(tip.p_current_W - tip.p_original_W);
  return PressEquation(tip).ForceAlone() * Direction(tip);
}

Vector3d HoldingForce(const CondensedTip& tip, const Vector3d& moved_W) noexcept {
  const LocalIndentation& indentation = tip.indentation;
  if (!indentation.indents()) return tip.compliance_W.ldlt().solve(moved_W);
  Vector3d force_W = Vector3d::Zero();
  for (int round = 0; round < kMaxRounds; ++round) {
    const double f_n = std::max(0.0, -tip.normal_W.dot(force_W));
    const double yield = indentation.BallYield(f_n);
    const Matrix3d C = tip.compliance_W + yield * indentation.factor_W();
    Matrix3d slope = C;
    if (f_n > 0) {
      const Vector3d along = indentation.factor_W() * force_W / f_n;
      slope -= (indentation.BallYieldRate(f_n) - yield) * along * tip.normal_W.transpose();
    }
    const Vector3d change = slope.inverse() * (moved_W - C * force_W);
    force_W += change;
    if (change.norm() <= kSettledForce * force_W.norm()) break;
  }
  return force_W;
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
