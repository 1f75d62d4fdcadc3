#include "haptics/device/simulated_hand.h"

#include <cmath>
#include <numbers>

#include "engine/base/error.h"

namespace hpdm {
namespace {

constexpr double kTremorLow = 8;  // Hz
constexpr std::uint32_t kTremorSeed = 0x9e3779b9u;

}  // namespace

SimulatedHand::SimulatedHand(const HandOptions& options, const HandSite& site)
    : Hand(options.stiffness, options.damping),
      plan_(options, site),
      tremor_(options.tremor),
      from_(plan_.Start()),
      to_(plan_.Next()) {
  if (!(std::isfinite(tremor_) && tremor_ >= 0)) {
    throw InputError("instrument.hand: tremor: negative or not finite; give m");
  }
  HandRandom random(options.seed ^ kTremorSeed);
  for (auto& axis : sinusoids_) {
    for (int i = 0; i < kSinusoids; ++i) {
      const double hertz = kTremorLow + i + random.Uniform(0, 1);
      axis[i].angular_frequency = 2 * std::numbers::pi * hertz;
      axis[i].phase = random.Uniform(0, 2 * std::numbers::pi);
    }
  }
}

HandIntent SimulatedHand::At(Nanoseconds t_ns) noexcept {
  while (t_ns - departed_ns_ >= to_.duration_ns) {
    departed_ns_ += to_.duration_ns;
    from_ = to_;
    to_ = plan_.Next();
  }
  const double duration = ToSeconds(to_.duration_ns);
  const double tau = ToSeconds(t_ns - departed_ns_) / duration;
  const double s = MinimumJerk::Position(tau);
  HandIntent intent;
  intent.p_W = from_.p_W + s * (to_.p_W - from_.p_W);
  intent.v_W = (MinimumJerk::Velocity(tau) / duration) * (to_.p_W - from_.p_W);
  intent.roll = from_.roll + s * (to_.roll - from_.roll);
  intent.jaw = from_.jaw + s * (to_.jaw - from_.jaw);
  AddTremor(ToSeconds(t_ns), &intent);
  return intent;
}

void SimulatedHand::AddTremor(double t, HandIntent* intent) const {
  if (tremor_ == 0) return;
  const double amplitude = tremor_ / 2;
  for (int axis = 0; axis < 3; ++axis) {
    for (const Sinusoid& s : sinusoids_[axis]) {
      const double angle = s.angular_frequency * t + s.phase;
      intent->p_W[axis] += amplitude * std::sin(angle);
      intent->v_W[axis] += amplitude * s.angular_frequency * std::cos(angle);
    }
  }
}

}  // namespace hpdm
