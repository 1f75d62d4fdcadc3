#include "tools/haptics/tissue_trials.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"

namespace hpdm {
namespace {

OrganOptions Options(const TissuePress& press, const PronySeries& prony) {
  OrganOptions options = press.block.Options();
  options.material.prony = prony;
  return options;
}

ToolPose At(const TissuePress& press, double depth) {
  return FeltBench::At(press.place_W + Vector3d(0, 0, press.tip_radius - depth));
}

int Ticks(double seconds) { return static_cast<int>(std::lround(seconds / kTissuePeriod)); }

}  // namespace

std::vector<double> FeltForce(const TissuePress& press,
                              const std::function<double(double time)>& depth, double seconds) {
  FeltBench bench(Options(press, press.prony), press.block.Rest(), BallTip(press.tip_radius));
  bench.friction = press.friction;
  std::vector<double> felt;
  for (int tick = 0; tick < Ticks(seconds); ++tick) {
    bench.SessionTick(At(press, depth(tick * kTissuePeriod)));
    felt.push_back(bench.Hand().z());
  }
  return felt;
}

RelaxedPress::RelaxedPress(const TissuePress& press, double deepest) {
  constexpr int kParts = 40;
  spacing_ = deepest / kParts;
  FeltBench bench(Options(press, {}), press.block.Rest(), BallTip(press.tip_radius));
  bench.friction = press.friction;
  roots_.push_back(0);
  for (int i = 1; i <= kParts; ++i) {
    const ToolPose pressed = At(press, i * spacing_);
    bench.Step(pressed);
    bench.Settle(pressed);
    bench.Step(pressed);
    bench.Settle(pressed);
    roots_.push_back(std::pow(bench.Hand().z(), 2.0 / 3));
  }
}

double RelaxedPress::Force(double depth) const {
  if (depth <= 0) return 0;
  const double along = depth / spacing_;
  const auto part = std::min(static_cast<std::size_t>(along), roots_.size() - 2);
  HPDM_CHECK(along < static_cast<double>(roots_.size()) - 1 + 1e-6);
  const double share = along - static_cast<double>(part);
  return std::pow((1 - share) * roots_[part] + share * roots_[part + 1], 1.5);
}

}  // namespace hpdm
