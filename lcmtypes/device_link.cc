#include "lcmtypes/device_link.h"

#include <exception>
#include <lcm/lcm-cpp.hpp>
#include <thread>

#include "engine/realtime.h"
#include "lcmtypes/codec.h"
#include "lcmtypes/network.h"

namespace hpdm {
namespace {

constexpr char kOption[] = "--device lcm";
constexpr int kReceivePatienceMs = 20;

}  // namespace

DeviceLink::DeviceLink(const std::string& url, const SessionClock& clock, const Edges& edges)
    : clock_(clock), edges_(edges) {
  // LCM's own thread inherits the scheduling of the thread that subscribes.
  std::exception_ptr failure;
  std::jthread([&] {
    RealtimeOptions realtime;
    realtime.fifo_priority = kPriority;
    RequestRealtime(realtime);
    try {
      lcm_ = Connect(url, kOption);
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
  while (!stop.stop_requested()) {
    while (edges_.forces.Pop(&sample)) {
      ToMessage(sample, &force_);
      ++force_.sequence;
      const std::span<const std::uint8_t> bytes = EncodeMessage(force_, &buffer_);
      const int status =
          lcm_->publish(kForceChannel, bytes.data(), static_cast<unsigned int>(bytes.size()));
      ++(status == 0 ? sent_ : send_errors_);
    }
    clock_.SleepUntil(clock_.Now() + kSendPeriod);
  }
}

void DeviceLink::HandleReceived(const lcm::ReceiveBuffer* received, const std::string&,
                                DeviceLink* link) {
  const auto* data = static_cast<const std::uint8_t*>(received->data);
  link->Handle({data, received->data_size}, link->clock_.Now());
}

void DeviceLink::Handle(std::span<const std::uint8_t> bytes, Nanoseconds arrival) noexcept {
  device_t message;
  DeviceSample sample;
  int instrument = 0;
  if (!DecodeMessage(bytes, &message) || !FromMessage(message, &sample, &instrument) ||
      edges_.devices[instrument] == nullptr || sample.time_ns > DriverClock::kLargestStamp ||
      sample.time_ns < -DriverClock::kLargestStamp) {
    ++refused_;
    return;
  }
  Driver& driver = drivers_[instrument];
  if (driver.heard && sample.sequence <= driver.last_sequence &&
      arrival - driver.last_arrival < kRestartAfter) {
    ++refused_;
    return;
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

DeviceLinkSummary DeviceLink::Summary() const {
  return {received_, refused_, sent_, send_errors_, edges_.forces.Overflows()};
}

}  // namespace hpdm
