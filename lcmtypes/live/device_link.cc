#include "lcmtypes/live/device_link.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <iterator>
#include <lcm/lcm-cpp.hpp>
#include <numeric>
#include <thread>

#include "engine/threads/realtime.h"
#include "lcmtypes/live/network.h"
#include "lcmtypes/wire/codec.h"

namespace hpdm {
namespace {

constexpr char kOption[] = "--device lcm";

}  // namespace

DeviceLink::DeviceLink(const std::string& url, const SessionClock& clock, const Edges& edges)
    : clock_(clock), edges_(edges) {
  // LCM's receiving thread inherits the scheduling of the thread that subscribes.
  std::exception_ptr failure;
  std::jthread([&] {
    RealtimeOptions realtime;
    realtime.fifo_priority = kPriority;
    RequestRealtime(realtime);
    try {
      lcm_ = ConnectToReceive(url, kOption);
      lcm::Subscription* subscription =
          lcm_->subscribeFunction(kDeviceChannel, HandleReceived, this);
      if (subscription == nullptr) FailToConnect(url, kOption);
      subscription->setQueueCapacity(64);
    } catch (...) {
      failure = std::current_exception();
    }
  }).join();
  if (failure) std::rethrow_exception(failure);
}

DeviceLink::~DeviceLink() = default;

void DeviceLink::Receive(std::stop_token stop) noexcept {
  while (!stop.stop_requested()) lcm_->handleTimeout(kReceivePatienceMs);
}

void DeviceLink::Send(std::stop_token stop) noexcept {
  HapticSample sample;
  const auto send = [&] {
    ++force_.sequence;
    const std::span<const std::uint8_t> bytes = EncodeMessage(force_, &buffer_);
    return lcm_->publish(kForceChannel, bytes.data(), static_cast<unsigned int>(bytes.size()));
  };
  for (bool last = false; !last;) {
    last = stop.stop_requested();
    while (edges_.forces.Pop(&sample)) {
      ToMessage(sample, &force_);
      ++(send() == 0 ? sent_ : send_errors_);
    }
    if (!last) clock_.SleepUntil(clock_.Now() + kSendPeriod);
  }
  if (force_.sequence == 0) return;
  // The session is over: sends zero forces, so that no motor holds its last force.
  for (tool_force_t& tool : force_.tools) {
    std::fill(std::begin(tool.force), std::end(tool.force), 0.0);
    std::fill(std::begin(tool.effort), std::end(tool.effort), 0.0);
  }
  send();
}

void DeviceLink::HandleReceived(const lcm::ReceiveBuffer* received, const std::string&,
                                DeviceLink* link) {
  const auto* data = static_cast<const std::uint8_t*>(received->data);
  link->Handle({data, received->data_size}, link->clock_.Now());
}

void DeviceLink::Handle(std::span<const std::uint8_t> bytes, Nanoseconds arrival) noexcept {
  device_t message;
  DeviceSample sample;
  int instrument = -1;
  if (!DecodeMessage(bytes, &message) || !FromMessage(message, &sample, &instrument) ||
      sample.time_ns > DriverClock::kMaxStamp || sample.time_ns < -DriverClock::kMaxStamp) {
    return Refuse(Refusal::kNoReading, bytes.size(), instrument);
  }
  if (edges_.devices[instrument] == nullptr) {
    return Refuse(Refusal::kNotOurs, bytes.size(), instrument);
  }
  Driver& driver = drivers_[instrument];
  if (driver.heard && sample.sequence <= driver.last_sequence &&
      arrival - driver.last_arrival < kRestartAfter) {
    return Refuse(Refusal::kStale, bytes.size(), instrument);
  }
  driver.heard = true;
  driver.last_sequence = sample.sequence;
  driver.last_arrival = arrival;
  sample.time_ns = driver.clock.ToSession(sample.time_ns, arrival);
  ++received_;
  TripleBuffer<DeviceSample>& readings = *edges_.devices[instrument];
  readings.Back() = sample;
  readings.Publish();
}

/// Reports the first refusal of its kind; later ones are only counted.
void DeviceLink::Refuse(Refusal why, std::size_t bytes, int instrument) noexcept {
  if (++refused_[static_cast<std::size_t>(why)] > 1 || edges_.events == nullptr) return;
  constexpr const char* kReasons[kRefusals] = {
      "is not a device reading (another type, or impossible values); keep other programs "
      "off this channel, or build the driver with this version's lcmtypes",
      "is of an instrument without an external driver; give it --device NAME=lcm, or correct the "
      "driver's instrument",
      "came after a newer one: are two drivers running?"};
  char text[sizeof LoopEvent::text];
  std::snprintf(text, sizeof text,
                "a message of %zu bytes on HPDM_DEVICE was refused (reported once): it %s", bytes,
                kReasons[static_cast<std::size_t>(why)]);
  if (instrument >= 0) {
    std::snprintf(text, sizeof text,
                  "a reading of instrument %d on HPDM_DEVICE was refused (reported once): it %s",
                  instrument, kReasons[static_cast<std::size_t>(why)]);
  }
  edges_.events->Push(MakeLoopEvent(EventSeverity::kWarning, "device.refused", text));
}

DeviceLinkSummary DeviceLink::Summary() const {
  const std::uint64_t refused = std::accumulate(refused_.begin(), refused_.end(), std::uint64_t{0});
  return {received_, refused, sent_, send_errors_, edges_.forces.Overflows()};
}

}  // namespace hpdm
