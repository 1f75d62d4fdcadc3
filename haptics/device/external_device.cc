#include "haptics/device/external_device.h"

#include <algorithm>

namespace hpdm {

DeviceSample ExternalDevice::Read(Nanoseconds now) noexcept {
  if (readings_.Update()) {
    const DeviceSample& newest = readings_.Front();
    arrived_ns_ = now;
    usable_ = newest.valid && newest.joints.allFinite();
    if (usable_) {
      sample_ = newest;
      sample_.joints = newest.joints.cwiseMax(limits_.min_joints).cwiseMin(limits_.max_joints);
      // Clamps the link's time: a reading cannot be from the future.
      sample_.time_ns = std::min(newest.time_ns, now);
    }
  }
  sample_.valid = usable_ && now - arrived_ns_ <= kLostAfter;
  return sample_;
}

}  // namespace hpdm
