#include "lcmtypes/telemetry/live_publisher.h"

#include <lcm/lcm-cpp.hpp>
#include <utility>

#include "lcmtypes/live/network.h"
#include "lcmtypes/wire/codec.h"

namespace hpdm {

LivePublisher::LivePublisher(bool live, Nanoseconds mesh_repeat)
    : lcm_(live ? Connect(NetworkUrl(), "--live") : nullptr), mesh_repeat_(mesh_repeat) {}

LivePublisher::~LivePublisher() = default;

void LivePublisher::SetMeshes(std::vector<mesh_t> parts) {
  if (lcm_) parts_ = std::move(parts);
}

void LivePublisher::Publish(const char* channel, std::span<const std::uint8_t> message) noexcept {
  if (!lcm_) return;
  const int status =
      lcm_->publish(channel, message.data(), static_cast<unsigned int>(message.size()));
  ++(status == 0 ? messages_ : errors_);
}

void LivePublisher::PublishMeshPart(Nanoseconds now) noexcept {
  if (parts_.empty()) return;
  if (next_part_ == parts_.size()) {
    if (now < next_repeat_) return;
    next_part_ = 0;
  }
  if (next_part_ == 0) next_repeat_ = now + mesh_repeat_;
  mesh_t& part = parts_[next_part_++];
  part.sequence = ++mesh_sequence_;
  Publish(kMeshChannel, EncodeMessage(part, &buffer_));
}

}  // namespace hpdm
