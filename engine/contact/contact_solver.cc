#include "engine/contact/contact_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/check.h"

namespace hpdm {
namespace {

// Relative round-off of positions, from the tools' poses.
constexpr double kRoundOff = 1e-12;

// Rounds of Newton's method for the tips' local laws, and the last change of a force over the
// largest. From no force it takes four to seven.
constexpr int kMaxTipRounds = 16;
constexpr double kTipTolerance = 1e-8;

// Rounds of the active set: in all, and without progress before contacts change one at a time.
constexpr int kMaxRounds = 4 * kMaxContacts;
constexpr int kPatience = 8;

// Rounds of the forces across pairs, sweeps in each, and the last change of a force over the
// largest.
constexpr int kMaxFrictionRounds = 50;
constexpr int kSweeps = 10;
constexpr double kFrictionTolerance = 1e-5;
// Forces across this close to the limit slide.
constexpr double kNearLimit = 1 - 1e-3;

// Returns two unit vectors across n.
std::array<Vector3d, 2> Across(const Vector3d& n) {
  const Vector3d first = n.unitOrthogonal();
  return {first, n.cross(first)};
}

}  // namespace

ContactSolver::ContactSolver()
    : equations_(kMaxEquations),
      sides_(2 * kMaxEquations),
      compliance_(kMaxEquations, kMaxEquations),
      relaxed_(kMaxEquations, kMaxEquations),
      active_compliance_(kMaxEquations, kMaxEquations),
      kept_compliance_(kMaxEquations, kMaxEquations),
      kept_relaxed_(kMaxEquations, kMaxEquations) {}

void ContactSolver::Build(std::span<const ContactConstraints* const> bodies,
                          std::span<const OrganContact> pairs) {
  HPDM_CHECK(bodies.size() <= kMaxBodies);
  size_ = 0;
  bodies_ = static_cast<int>(bodies.size());
  has_tip_law_ = false;
  change_.resize(kMaxEquations);
  for (const ContactConstraints* contacts : bodies) AddOwnEquations(*contacts);
  first_pair_equation_ = size_;
  AddPairEquations(pairs);
  change_.conservativeResize(size_);
  forces_.conservativeResize(size_);
  compliance().setZero();
  relaxed_.topLeftCorner(size_, size_).setZero();
  ListSides(bodies, pairs);
}

void ContactSolver::AddOwnEquations(const ContactConstraints& contacts) {
  for (int i = 0; i < contacts.size(); ++i) {
    const ContactConstraints::Row& row = contacts[i];
    if (row.kind == ContactConstraints::RowKind::kPair) continue;
    const bool is_press = row.kind == ContactConstraints::RowKind::kPress;
    for (int d = 0; d < (is_press ? 1 : 3); ++d) {
      HPDM_CHECK(size_ < kMaxEquations);
      Equation& equation = equations_[static_cast<std::size_t>(size_)];
      equation = {.row = &row, .unilateral = is_press};
      equation.axis_W = is_press ? Vector3d(-row.normal_W) : Vector3d(Vector3d::Unit(d));
      equation.force_W = is_press ? Vector3d(row.friction_W - row.normal_W) : equation.axis_W;
      equation.local_W = row.local_compliance_W * equation.force_W;
      double& change = change_[size_++];
      change = equation.axis_W.dot(row.target_W - row.p_rest_W - row.free_W);
      // Round-off must not make coincident contacts at rest contradict each other and slip.
      const double size = std::max(row.target_W.norm(), row.p_rest_W.norm());
      if (std::abs(change) <= kRoundOff * size) change = 0;
      if (!is_press || !row.indentation.indents()) continue;
      equation.tip_law.indentation = &row.indentation;
      equation.tip_law.along = equation.axis_W.dot(row.indentation.factor_W() * equation.force_W);
      has_tip_law_ = true;
    }
  }
}

void ContactSolver::AddPairEquations(std::span<const OrganContact> pairs) {
  pair_count_ = 0;
  has_pair_friction_ = false;
  forces_.setZero(kMaxEquations);
  for (const OrganContact& pair : pairs) {
    const int count = pair.friction > 0 ? 3 : 1;
    if (size_ + count > kMaxEquations || pair_count_ == kMaxContacts) break;
    pair_equation_[static_cast<std::size_t>(pair_count_++)] = size_;
    equations_[static_cast<std::size_t>(size_)] = {.axis_W = -pair.normal_W,
                                                   .force_W = -pair.normal_W,
                                                   .unilateral = true,
                                                   .friction = pair.friction};
    active_[static_cast<std::size_t>(size_)] = pair.f_n > 0;
    change_[size_++] = -pair.gap;
    if (count == 1) continue;
    has_pair_friction_ = true;
    for (const Vector3d& axis : Across(pair.normal_W)) {
      equations_[static_cast<std::size_t>(size_)] = {
          .axis_W = axis, .force_W = axis, .across = true};
      active_[static_cast<std::size_t>(size_)] = false;
      forces_[size_] = pair.f_n > 0 ? axis.dot(pair.f_t_W) : 0;
      change_[size_++] = -axis.dot(pair.tie_W);
    }
  }
}

// A pair's axes and forces are those on its first organ.
void ContactSolver::ListSides(std::span<const ContactConstraints* const> bodies,
                              std::span<const OrganContact> pairs) {
  std::size_t count = 0;
  int own = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    first_side_[b] = count;
    const ContactConstraints& contacts = *bodies[b];
    for (int i = 0; i < contacts.size(); ++i) {
      for (; own < first_pair_equation_; ++own) {
        const Equation& equation = equations_[static_cast<std::size_t>(own)];
        if (equation.row != &contacts[i]) break;
        sides_[count++] = {own, i, equation.axis_W, equation.force_W};
      }
    }
    for (int p = 0; p < pair_count_; ++p) {
      const OrganContact& pair = pairs[static_cast<std::size_t>(p)];
      const int e = pair_equation_[static_cast<std::size_t>(p)];
      for (std::size_t k = 0; k < 2; ++k) {
        if (static_cast<std::size_t>(pair.body[k]) != b) continue;
        const double sign = k == 0 ? 1 : -1;
        for (int g = e; g < e + (pair.friction > 0 ? 3 : 1); ++g) {
          const Equation& equation = equations_[static_cast<std::size_t>(g)];
          sides_[count++] = {g, pair.row[k], sign * equation.axis_W, sign * equation.force_W};
        }
      }
    }
  }
  first_side_[bodies.size()] = count;
}

void ContactSolver::AddLocalCompliance() {
  for (int e = 0; e < first_pair_equation_; ++e) {
    const Equation& equation = equations_[static_cast<std::size_t>(e)];
    for (int g = 0; g < first_pair_equation_; ++g) {
      const Equation& other = equations_[static_cast<std::size_t>(g)];
      if (equation.row == other.row) {
        compliance_(e, g) += equation.axis_W.dot(other.local_W);
      } else if (equation.row->coupled.coupling != nullptr) {
        compliance_(e, g) +=
            equation.axis_W.dot(equation.row->coupled.To(other.row->coupled) * other.force_W);
      }
    }
  }
}

void ContactSolver::Keep() {
  kept_compliance_.topLeftCorner(size_, size_) = compliance();
  kept_relaxed_.topLeftCorner(size_, size_) = relaxed_.topLeftCorner(size_, size_);
  kept_change_ = change_;
}

void ContactSolver::TakeBack() {
  compliance() = kept_compliance_.topLeftCorner(size_, size_);
  relaxed_.topLeftCorner(size_, size_) = kept_relaxed_.topLeftCorner(size_, size_);
  change_ = kept_change_;
}

void ContactSolver::LineariseTipLaws() {
  for (int e = 0; e < first_pair_equation_; ++e) {
    const TipLaw& law = equations_[static_cast<std::size_t>(e)].tip_law;
    if (law.indentation == nullptr) continue;
    const double f = std::max(forces_[e], 0.0);
    const double rate = law.indentation->BallYieldRate(f);
    compliance_(e, e) = law.compliance + law.along * rate;
    change_[e] = law.change - law.along * f * (law.indentation->BallYield(f) - rate);
  }
}

RelaxationResult ContactSolver::Solve() {
  RelaxationResult result;
  if (size_ == 0) return result;
  AddLocalCompliance();
  if (!has_tip_law_) {
    SolveLinear(&result);
    return result;
  }
  for (int e = 0; e < first_pair_equation_; ++e) {
    TipLaw& law = equations_[static_cast<std::size_t>(e)].tip_law;
    law.compliance = compliance_(e, e);
    law.change = change_[e];
  }
  Vector last = forces_;
  for (int round = 0; round < kMaxTipRounds; ++round) {
    LineariseTipLaws();
    SolveLinear(&result);
    if ((forces_ - last).cwiseAbs().maxCoeff() <= kTipTolerance * forces_.cwiseAbs().maxCoeff())
      break;
    last = forces_;
  }
  return result;
}

void ContactSolver::SolveLinear(RelaxationResult* result) {
  for (int e = 0; e < first_pair_equation_; ++e) {
    const auto i = static_cast<std::size_t>(e);
    active_[i] = !equations_[i].unilateral || change_[e] > 0;
  }
  result->converged = SolveNormals(result);
  if (!has_pair_friction_) return;
  double change = 1;
  for (int round = 0; round < kMaxFrictionRounds && change > kFrictionTolerance; ++round) {
    change = UpdateFriction();
    if (change > 0) result->converged = SolveNormals(result);
  }
}

// Solves for the forces of all equations but those across pairs. Each round releases the contacts
// that would pull and adds those that would penetrate. False if the rounds were used up.
bool ContactSolver::SolveNormals(RelaxationResult* result) {
  loads_.setZero(size_);
  for (int e = first_pair_equation_; e < size_; ++e) {
    if (equations_[static_cast<std::size_t>(e)].across && forces_[e] != 0)
      loads_ += forces_[e] * compliance_.col(e).head(size_);
  }
  int fewest = std::numeric_limits<int>::max(), waited = 0;
  for (int round = 0; round < kMaxRounds; ++round) {
    ++result->iterations;
    result->regularised = SolveActive();
    const int wrong = UpdateActiveSet(waited >= kPatience);
    if (wrong == 0) return true;
    waited = wrong < fewest ? 0 : waited + 1;
    fewest = std::min(fewest, wrong);
  }
  return false;
}

bool ContactSolver::Slides(int e) const {
  const double limit = equations_[static_cast<std::size_t>(e)].friction * forces_[e];
  return Eigen::Vector2d(forces_[e + 1], forces_[e + 2]).norm() >= kNearLimit * limit;
}

bool ContactSolver::IsActive(int equation) const {
  auto e = static_cast<std::size_t>(equation);
  if (!equations_[e].across) return active_[e];
  while (equations_[e].across) --e;
  return active_[e] && !Slides(static_cast<int>(e));
}

double ContactSolver::WithFriction(int e, int g) const {
  const double entry = relaxed_(e, g);
  if (!(equations_[static_cast<std::size_t>(g)].friction > 0) || !(forces_[g] > 0) || !Slides(g))
    return entry;
  return entry +
         (forces_[g + 1] * relaxed_(e, g + 1) + forces_[g + 2] * relaxed_(e, g + 2)) / forces_[g];
}

Vector3d ContactSolver::ForceWithFriction(const Side& side) const {
  const int e = side.equation;
  const Equation& normal = equations_[static_cast<std::size_t>(e)];
  if (!(normal.friction > 0) || !(forces_[e] > 0) || !Slides(e)) return side.force_W;
  const double sign = side.force_W.dot(normal.force_W) > 0 ? 1 : -1;  // -1: on the second body
  return side.force_W + sign / forces_[e] *
                            (forces_[e + 1] * equations_[static_cast<std::size_t>(e + 1)].force_W +
                             forces_[e + 2] * equations_[static_cast<std::size_t>(e + 2)].force_W);
}

// Computes the forces that satisfy the active equations; the others are zero. True if the equations
// are (nearly) dependent.
bool ContactSolver::SolveActive() {
  slip_ = 0;
  int count = 0;
  for (int e = 0; e < size_; ++e) {
    const auto i = static_cast<std::size_t>(e);
    if (!equations_[i].across) forces_[e] = 0;
    if (active_[i]) active_list_[static_cast<std::size_t>(count++)] = e;
  }
  if (count == 0) return false;
  double way = 0, softest = 0;
  double stiffest = HUGE_VAL;  // of the tools' equations
  int tools = 0;               // active equations of tools, which stand first
  for (int i = 0; i < count; ++i) {
    const int e = active_list_[static_cast<std::size_t>(i)];
    way = std::max(way, std::abs(change_[e]));
    softest = std::max(softest, compliance_(e, e));
    if (e >= first_pair_equation_) continue;
    stiffest = std::min(stiffest, compliance_(e, e));
    ++tools;
  }
  const bool friction = HasFriction();
  const auto solve = [&](double pad) {
    auto A = active_compliance_.topLeftCorner(count, count);
    active_forces_.resize(count);
    for (int i = 0; i < count; ++i) {
      const int e = active_list_[static_cast<std::size_t>(i)];
      active_forces_[i] = change_[e] - loads_[e];
      for (int j = 0; j < count; ++j) {
        A(i, j) = compliance_(e, active_list_[static_cast<std::size_t>(j)]);
      }
    }
    A.diagonal().array() += pad;
    Eigen::Ref<Matrix> active_compliance(A);
    if (friction) {
      const Eigen::PartialPivLU<Eigen::Ref<Matrix>> factor(active_compliance);
      active_forces_ = factor.solve(active_forces_).eval();
      return factor.matrixLU().diagonal().cwiseAbs().minCoeff() < 10 * pad;
    }
    const Eigen::LDLT<Eigen::Ref<Matrix>> factor(active_compliance);
    factor.solveInPlace(active_forces_);
    return factor.vectorD().minCoeff() < 10 * pad;
  };
  // With a pad compliance of 1e-9 of the softest contact, coincident contacts share their force.
  // Other contacts move by one part in 1e9.
  double pad = 1e-9 * softest;
  bool dependent = solve(pad);
  // Contacts of organs only push, so they cannot contradict each other, and organs that others hold
  // have forces of many times that of one alone.
  const double alone = way / stiffest;
  const auto largest = [&] { return active_forces_.head(tools).cwiseAbs().maxCoeff(); };
  if (tools > 0 && largest() > kContradicting * alone) {
    while (largest() > kSlipping * alone && pad < softest) {
      pad *= 10;
      solve(pad);
    }
    dependent = true;
    slip_ = pad;
  }
  for (int i = 0; i < count; ++i) {
    forces_[active_list_[static_cast<std::size_t>(i)]] = active_forces_[i];
  }
  return dependent;
}

bool ContactSolver::HasFriction() const {
  for (int e = 0; e < size_; ++e) {
    const Equation& equation = equations_[static_cast<std::size_t>(e)];
    if (equation.force_W != equation.axis_W) return true;
  }
  return false;
}

bool ContactSolver::IsWrong(int e, double slack) const {
  if (active_[static_cast<std::size_t>(e)]) return forces_[e] < 0;
  return change_[e] - compliance_.row(e).head(size_).dot(forces_) > slack;
}

// Returns the number of contacts that were wrong.
int ContactSolver::UpdateActiveSet(bool one_at_a_time) {
  int wrong = 0;
  const double slack = 1e-9 * change_.cwiseAbs().maxCoeff();  // round-off of the solve, in any unit
  for (int e = 0; e < size_; ++e) {
    const auto i = static_cast<std::size_t>(e);
    if (!equations_[i].unilateral || !IsWrong(e, slack)) continue;
    active_[i] = !active_[i];
    ++wrong;
    if (one_at_a_time) break;
  }
  return wrong;
}

// Moves the forces across the pairs against their slip, within the limits by the present forces along
// the normals. Returns the largest change over the largest force.
double ContactSolver::UpdateFriction() {
  double largest = 0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (int e = first_pair_equation_; e < size_; ++e) {
      const Equation& normal = equations_[static_cast<std::size_t>(e)];
      if (!(normal.friction > 0)) continue;
      Eigen::Vector2d across(forces_[e + 1], forces_[e + 2]);
      const Eigen::Vector2d before = across;
      const double limit = normal.friction * std::max(0.0, forces_[e]);
      if (limit > 0) {
        const Eigen::Vector2d slip(
            compliance_.row(e + 1).head(size_).dot(forces_) - change_[e + 1],
            compliance_.row(e + 2).head(size_).dot(forces_) - change_[e + 2]);
        across -= slip / std::max(compliance_(e + 1, e + 1), compliance_(e + 2, e + 2));
        if (across.norm() > limit) across *= limit / across.norm();
      } else {
        across.setZero();
      }
      forces_[e + 1] = across[0];
      forces_[e + 2] = across[1];
      largest = std::max(largest, (across - before).norm());
    }
  }
  const double size = forces_.cwiseAbs().maxCoeff();
  return size > 0 ? largest / size : 0;
}

ContactSolver::Vector ContactSolver::ForcesOn(int body) const {
  const std::span<const Side> own = sides(body);
  Vector forces(static_cast<Eigen::Index>(own.size()));
  for (Eigen::Index i = 0; i < forces.size(); ++i) {
    forces[i] = forces_[own[static_cast<std::size_t>(i)].equation];
  }
  return forces;
}

void ContactSolver::WriteForces(int body, ContactConstraints* contacts) const {
  for (int i = 0; i < contacts->size(); ++i) {
    (*contacts)[i].force_W.setZero();
    (*contacts)[i].slip = slip_;
  }
  for (const Side& side : sides(body)) {
    (*contacts)[side.row].force_W += forces_[side.equation] * side.force_W;
  }
}

void ContactSolver::WriteForces(std::span<OrganContact> pairs) const {
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    OrganContact& pair = pairs[p];
    const bool solved = static_cast<int>(p) < pair_count_;
    const int e = pair_equation_[p];
    pair.f_n = solved ? forces_[e] : 0;
    pair.indentation = solved ? compliance_(e, e) * forces_[e] : 0;
    pair.f_t_W.setZero();
    if (!solved || !(pair.friction > 0)) continue;
    for (int g = e + 1; g <= e + 2; ++g) {
      pair.f_t_W += forces_[g] * equations_[static_cast<std::size_t>(g)].force_W;
    }
  }
}

}  // namespace hpdm
