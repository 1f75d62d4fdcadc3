#pragma once

#include <vector>

#include "engine/snapshots.h"

namespace hpdm {

/// The char marks that energised hooks leave where they press an organ, by vertices. They grow from
/// snapshot to snapshot, so they belong to a picture and not to the session. Render thread only.
class BurnMarks {
 public:
  static constexpr double kReach = 0.004;  ///< m, from the contact.
  static constexpr double kTime = 0.4;     ///< s, until the contact's place is black.
  static constexpr double kLongest = 0.1;  ///< s: a late snapshot burns no longer than this.

  /// `vertices`: number of each organ's.
  explicit BurnMarks(const std::vector<int>& vertices);

  /// Lets the marks grow by the time since the last call. True if one did.
  bool Follow(const SceneSnapshot& snapshot);

  /// How black each vertex of an organ is, 0..1.
  const std::vector<float>& Of(std::size_t organ) const { return black_[organ]; }

 private:
  std::vector<std::vector<float>> black_;
  Nanoseconds last_ns_ = 0;
};

}  // namespace hpdm
