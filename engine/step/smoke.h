#pragma once

#include <array>

#include "engine/base/types.h"

namespace hpdm {

/// A puff of smoke: where and when an energised hook heated tissue.
struct SmokePuff {
  static constexpr double kLife = 1.5;  ///< s: then nothing of it is seen.
  Vector3d p_W = Vector3d::Zero();      ///< m.
  Nanoseconds time_ns = 0;              ///< Session time of the step.
};

/// The smoke of the last seconds, for pictures. A value; allocates nothing.
class Smoke {
 public:
  static constexpr std::size_t kMost = 64;  ///< Beyond it the oldest puff goes.

  void Add(const SmokePuff& puff) { puffs_[next_++ % kMost] = puff; }

  /// Removes what began within `reach` (m) of a place.
  void Take(const Vector3d& p_W, double reach) {
    for (SmokePuff& puff : puffs_) {
      if ((puff.p_W - p_W).norm() <= reach) puff.time_ns = kTaken;
    }
  }

  /// Calls use(puff, age in s) for those that are seen at a time, the oldest first.
  template <typename Use>
  void ForEach(Nanoseconds time_ns, const Use& use) const {
    for (std::size_t i = next_ < kMost ? 0 : next_ - kMost; i < next_; ++i) {
      const SmokePuff& puff = puffs_[i % kMost];
      if (puff.time_ns == kTaken) continue;
      const double age = ToSeconds(time_ns - puff.time_ns);
      if (age >= 0 && age < SmokePuff::kLife) use(puff, age);
    }
  }

 private:
  static constexpr Nanoseconds kTaken = -1;  // before the session

  std::array<SmokePuff, kMost> puffs_;
  std::size_t next_ = 0;
};

}  // namespace hpdm
