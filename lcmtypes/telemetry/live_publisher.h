#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/types.h"
#include "lcmtypes/wire/mesh_codec.h"

namespace lcm {
class LCM;
}

namespace hpdm {

/// Publishes a session's messages over LCM on NetworkUrl(), and repeats its meshes for listeners
/// that join late. Counts what the network refuses; nothing is sent twice.
///
/// Thread: that of its owner. Guarantee: a call never throws and never waits for a listener.
class LivePublisher {
 public:
  /// Opens no socket and publishes nothing unless `live`. `mesh_repeat` is the session time between
  /// two repeats of the meshes. Throws MachineError if the network cannot be opened.
  LivePublisher(bool live, Nanoseconds mesh_repeat);
  ~LivePublisher();

  /// Sets the parts that PublishMeshPart sends. Call it once.
  void SetMeshes(std::vector<mesh_t> parts);

  void Publish(const char* channel, std::span<const std::uint8_t> message) noexcept;
  /// Publishes at most one part, so that the meshes never crowd out the ticks. `now`: session time.
  void PublishMeshPart(Nanoseconds now) noexcept;

  std::uint64_t messages() const { return messages_; }  ///< Published.
  std::uint64_t errors() const { return errors_; }      ///< Refused by the network.

 private:
  std::unique_ptr<lcm::LCM> lcm_;  // null unless live
  std::uint64_t messages_ = 0;
  std::uint64_t errors_ = 0;

  Nanoseconds mesh_repeat_;
  std::vector<mesh_t> parts_;
  std::size_t next_part_ = 0;
  Nanoseconds next_repeat_ = 0;
  std::int64_t mesh_sequence_ = 0;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace hpdm
