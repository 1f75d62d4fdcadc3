#include "render/tissue/smoke_renderer.h"

#include <cmath>

namespace hpdm {
namespace {

constexpr double kRise = 0.025;   // m/s
constexpr double kDrift = 0.006;  // m/s, sideways, another way for each puff
constexpr double kFirstRadius = 0.0015, kSpread = 0.009;  // m, m/s
constexpr float kOpacity = 0.045f;                        // of a disc at the start
constexpr int kDiscs = 5;  // of each puff, one in another, so that its border is soft
const Colour kSmokeColour(0.80f, 0.80f, 0.82f);

}  // namespace

void AddSmokeMarks(const SceneSnapshot& snapshot, const Laparoscope& scope, Marks* marks) {
  snapshot.smoke.ForEach(snapshot.step.time_ns, [&](const SmokePuff& puff, double age) {
    // The step's time tells puffs apart.
    const double way = 1e-7 * static_cast<double>(puff.time_ns % 1'000'000'007);
    const Vector3d p_W =
        puff.p_W + age * Vector3d(kDrift * std::cos(way), kDrift * std::sin(way), kRise);
    const double radius = kFirstRadius + kSpread * age;
    const double px_per_m = scope.MostPixelsPerMetre(p_W, p_W);
    if (!std::isfinite(px_per_m)) return;  // behind the lens
    const auto left = static_cast<float>(1 - age / SmokePuff::kLife);
    for (int disc = 1; disc <= kDiscs; ++disc) {
      const auto radius_px = static_cast<float>(radius * px_per_m * disc / kDiscs);
      marks->push_back({.a_W = p_W.cast<float>(),
                        .radius_a = radius_px,
                        .b_W = p_W.cast<float>(),
                        .radius_b = radius_px,
                        .colour = kSmokeColour,
                        .opacity = kOpacity * left});
    }
  });
}

void SmokeRenderer::Draw(const SceneSnapshot& snapshot, const Laparoscope& scope) {
  marks_.clear();
  AddSmokeMarks(snapshot, scope, &marks_);
  if (!marks_.empty()) mark_renderer_.Draw(marks_, 0, Laparoscope::kFar);
}

}  // namespace hpdm
