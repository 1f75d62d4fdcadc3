#include "tools/stress/contact_energy.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <variant>

#include "engine/base/check.h"

namespace hpdm {
namespace {

// Running sums of one contact, J.
struct EnergySums {
  double put_in = 0;
  double work = 0;
  double friction = 0;
  double guard = 0;
};

// Tangential part of the force on the tissue, N.
Vector3d RubbingForce(const ContactTick& tick) {
  return tick.normal_W.dot(tick.reaction_W) * tick.friction_W;
}

void AddTickEnergy(const ContactTick& last, const ContactTick& tick, double tip_radius,
                   EnergySums* sums) {
  const Vector3d way = tick.p_tip_W - last.p_tip_W;
  const double work = -0.5 * (last.reaction_W + tick.reaction_W).dot(way);
  sums->work += work;
  sums->put_in += std::max(work, 0.0);
  sums->guard -= 0.5 * (last.force_W - last.reaction_W + tick.force_W - tick.reaction_W).dot(way);
  if (last.kind != ContactKind::kPress || tick.kind != ContactKind::kPress) return;
  const Vector3d slip = tick.slip_W + tip_radius * (tick.normal_W - last.normal_W);
  sums->friction += 0.5 * (RubbingForce(last) + RubbingForce(tick)).dot(slip);
}

double AllEnergy(const StoredEnergy& instant) { return instant.energy + instant.dissipated; }

// Returns the energy, stored and dissipated, of an instant between the ticks `from` and `to` when
// nothing touches the organ. Elastic tissue is then at rest.
std::optional<double> FreeEnergy(const std::vector<StoredEnergy>& stored, std::size_t from,
                                 std::size_t to) {
  if (stored.empty() || stored.back().dissipated == 0) return 0;
  const auto at = std::find_if(stored.begin(), stored.end(), [&](const StoredEnergy& each) {
    return each.tick >= from && each.tick < to;
  });
  return at == stored.end() ? std::nullopt : std::optional(AllEnergy(*at));
}

}  // namespace

double ContactBalance::Error() const { return put_in > 0 ? std::abs(unexplained) / put_in : 0; }

std::vector<ContactBalance> BalancesOf(const std::vector<ContactTick>& ticks,
                                       const std::vector<StoredEnergy>& stored, double tip_radius) {
  std::vector<ContactBalance> balances;
  auto instant = stored.begin();
  std::size_t last_end = 0;
  const auto next_contact = [&](std::size_t tick) {
    while (tick < ticks.size() && ticks[tick].kind == ContactKind::kNone) ++tick;
    return tick;
  };
  for (std::size_t first = next_contact(1); first < ticks.size();) {
    const ContactKind kind = ticks[first].kind;
    ContactBalance balance{.first = first, .kind = kind};
    const bool from_free = ticks[first - 1].kind == ContactKind::kNone;
    // Energy that is already in the organ, less the work until then.
    std::optional<double> before = from_free ? FreeEnergy(stored, last_end, first) : std::nullopt;
    EnergySums sums;
    const auto judge = [&](double all_energy) {
      const double left = sums.work - sums.friction - all_energy;
      if (!before) before = -left;
      ++balance.judged;
      const double unexplained = left + *before;
      if (std::abs(unexplained) > std::abs(balance.unexplained)) balance.unexplained = unexplained;
    };
    const double dissipated_before =
        instant == stored.begin() || stored.empty() ? 0 : std::prev(instant)->dissipated;
    std::size_t at = first;
    for (; at < ticks.size() && ticks[at].kind == kind; ++at) {
      AddTickEnergy(ticks[at - 1], ticks[at], tip_radius, &sums);
      while (instant != stored.end() && instant->tick < at) ++instant;
      if (instant == stored.end() || instant->tick != at) continue;
      judge(AllEnergy(*instant));
      balance.most_stored = std::max(balance.most_stored, instant->energy);
      balance.dissipated = instant->dissipated - dissipated_before;
    }
    balance.end = last_end = at;
    const std::size_t next = next_contact(at);
    const bool ends_free = at < ticks.size() && next > at;
    if (ends_free) {
      AddTickEnergy(ticks[at - 1], ticks[at], tip_radius, &sums);
      const std::optional<double> after = FreeEnergy(stored, at, next);
      if (after && before && kind == ContactKind::kPress) judge(*after);
    }
    balance.put_in = sums.put_in;
    balance.work = sums.work;
    balance.friction = sums.friction;
    balance.guard = sums.guard;
    balances.push_back(balance);
    first = next;
  }
  return balances;
}

// Returns the energy under a ball that presses with f_n, J: the sum of f d(f q(f)) a . H a over the
// way from no force to f_n, a the direction of the force.
static double EnergyUnderBall(const ContactConstraints::Row& row) {
  constexpr int kParts = 400;
  const double f_n = row.f_n();
  if (row.kind != ContactConstraints::RowKind::kPress || !row.indentation.indents()) return 0;
  if (!(f_n > 0)) return 0;
  const Vector3d direction_W = row.force_W / f_n;
  double sum = 0, last = 0;
  for (int i = 1; i <= kParts; ++i) {
    const double f = f_n * i / kParts;
    const double yielded = f * row.indentation.BallYield(f);
    sum += (f - 0.5 * f_n / kParts) * (yielded - last);
    last = yielded;
  }
  return sum * direction_W.dot(row.indentation.factor_W() * direction_W);
}

double EnergyInOrgan(const OrganModel& model, const OrganState& state) {
  HPDM_CHECK(state.contacts.refinement.slots() == 0);
  const Points& U = state.control_displacements;
  double energy = 0;
  if (model.finite_energy() != nullptr) {
    energy = model.finite_energy()->Clone()->Energy(U);
  } else if (const auto* K = std::get_if<FullStiffness>(&model.stiffness())) {
    const Eigen::Map<const Eigen::VectorXd> u(U.data(), U.size());
    energy = 0.5 * u.dot(*K * u);
  } else {
    const Points forces = std::get<ScalarStiffness>(model.stiffness()) * U;
    energy = 0.5 * U.cwiseProduct(forces).sum();
  }
  for (int i = 0; i < state.contacts.size(); ++i) {
    const ContactConstraints::Row& row = state.contacts[i];
    energy += 0.5 * row.force_W.dot(row.local_compliance_W * row.force_W) + EnergyUnderBall(row);
    for (int j = 0; j < state.contacts.size(); ++j) {
      const ContactConstraints::Row& other = state.contacts[j];
      if (j == i) continue;
      energy += 0.5 * row.force_W.dot(row.coupled.To(other.coupled) * other.force_W);
    }
  }
  return energy;
}

double LargestTurn(const std::vector<Vector3d>& forces, double least) {
  double turn = 0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    if (!(forces[i].norm() >= least)) continue;
    for (std::size_t j = i + 1; j < forces.size(); ++j) {
      if (!(forces[j].norm() >= least)) continue;
      turn =
          std::max(turn, std::atan2(forces[i].cross(forces[j]).norm(), forces[i].dot(forces[j])));
    }
  }
  return turn;
}

double RmsSpeed(const std::vector<Vector3d>& points, double period) {
  if (points.size() < 2) return 0;
  double sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    sum += (points[i] - points[i - 1]).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(points.size() - 1)) / period;
}

}  // namespace hpdm
