#include "haptics/safety/energy_tank.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"

namespace hpdm {
namespace {

// The limit is full once the tissue has given back the inverse of this share of its energy. Without any
// energy in the tank half of that share is lost.
constexpr double kSteep = 8;

// The share of the largest recent E below which the limit sets in, whatever the springs store. It is full
// at half of that.
constexpr double kNearlySpent = 0.1;

// m/s. A tip that moves faster is no hand's, but a reading that jumps or comes after a gap.
constexpr double kFastest = 10;

}  // namespace

EnergyTank::EnergyTank(const EnergyTankOptions& options)
    : options_(options), kept_(std::exp(-options.period / options.settle)) {}

double EnergyTank::Limit(std::span<const Press> presses) noexcept {
  HPDM_CHECK(presses.size() <= tools_.size());
  double tissue = 0, walls = 0;
  bool touches = false, jumps = false;
  for (std::size_t i = 0; i < presses.size(); ++i) {
    const Press& press = presses[i];
    Tool& tool = tools_[i];
    tool.moved_W = started_ ? Vector3d(press.p_tip_W - tool.p_tip_W) : Vector3d::Zero();
    tool.p_tip_W = press.p_tip_W;
    jumps = jumps || tool.moved_W.norm() > kFastest * options_.period;
    tool.asked_W = press.reaction_W.allFinite() ? press.reaction_W : Vector3d::Zero();
    energy_ -= 0.5 * (tool.force_W + tool.asked_W).dot(tool.moved_W);
    if (std::isfinite(press.tissue_stored)) tissue += press.tissue_stored;
    if (std::isfinite(press.wall_stored)) walls += press.wall_stored;
    held_ = held_ || press.kind == ContactKind::kGrasp;
    touches = touches || press.kind != ContactKind::kNone;
  }
  started_ = true;
  free_ = touches ? 0 : free_ + options_.period;
  if (free_ >= options_.released) {
    energy_ = largest_ = most_left_ = 0;
    held_ = false;
    share_ = end_share_ = 1;
    end_left_.reset();
  }
  if (jumps) {
    for (Tool& tool : tools_) tool.moved_W.setZero();
    energy_ = tissue + walls;
    largest_ = tissue;
  }
  largest_ = LargestRecent(largest_, tissue);
  if (!options_.control || held_) return share_ = 1;
  const double left = energy_ + options_.reserve - walls;
  most_left_ = LargestRecent(most_left_, left);
  if (!(tissue > 0)) {
    if (!end_left_) end_left_ = left;
    const double given = (*end_left_ - left) / std::max(*end_left_, options_.reserve);
    return share_ = end_share_ * std::clamp(1 - given, 0.0, 1.0);
  }
  const double covered = std::clamp(left / tissue, 0.0, 1.0);
  const double released = 1 - tissue / largest_;
  const double spent = 1 - left / (kNearlySpent * std::max(most_left_, options_.reserve));
  const double given_back = std::min(1.0, std::max(kSteep * released, 2 * spent));
  end_left_.reset();
  return share_ = end_share_ = 1 - (1 - covered) * given_back;
}

// Returns the largest recent value of which `last` was it a tick ago. It returns to `now` with the time constant
// `settle`.
double EnergyTank::LargestRecent(double last, double now) const {
  return std::max(now, now + kept_ * (last - now));
}

void EnergyTank::Observe(std::span<const Vector3d> forces_W) noexcept {
  for (std::size_t i = 0; i < forces_W.size(); ++i) {
    Tool& tool = tools_[i];
    energy_ -= 0.5 * (forces_W[i] - tool.asked_W).dot(tool.moved_W);
    tool.force_W = forces_W[i];
  }
}

}  // namespace hpdm
