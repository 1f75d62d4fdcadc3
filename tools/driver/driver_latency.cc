// Measures the latency that driving an instrument over LCM adds. Both ends run in one program and
// share its clock. A driver publishes HPDM_DEVICE through the system's multicast, a haptic loop at
// 1 kHz uses it, and the driver receives HPDM_FORCE. Prints JSON on stdout.
//
//   hpdm_driver_latency [SECONDS]
//
// Keep it off real networks, in a network namespace of its own:
//
//   unshare -n sh -c 'ip link set lo up; ip link set lo multicast on;
//     ip route add 239.255.76.67 dev lo; exec build/tools/hpdm_driver_latency 30'

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <lcm/lcm-cpp.hpp>
#include <thread>
#include <vector>

#include "engine/base/error.h"
#include "engine/threads/histogram.h"
#include "engine/threads/realtime.h"
#include "haptics/device/external_device.h"
#include "haptics/haptic_loop.h"
#include "lcmtypes/live/device_link.h"
#include "lcmtypes/live/network.h"
#include "lcmtypes/wire/codec.h"
#include "tools/shared/json_text.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kPeriod = 1'000'000;
// Slightly off the loop's period, so that the readings meet the ticks at every phase.
constexpr Nanoseconds kDriverPeriod = 1'003'100;

/// An external device that records which reading each tick used, and when.
class RecordedDevice : public ExternalDevice {
 public:
  struct Use {
    Nanoseconds at = 0;
    std::uint64_t sequence = 0;
    bool valid = false;
  };
  RecordedDevice(const DeviceLimits& limits, const SessionClock& clock, std::size_t ticks)
      : ExternalDevice(limits), clock_(clock), uses_(ticks) {}

  DeviceSample Read(Nanoseconds now) noexcept override {
    const DeviceSample sample = ExternalDevice::Read(now);
    const auto tick = static_cast<std::size_t>(now / kPeriod);  // the loop starts at 0
    if (tick < uses_.size()) uses_[tick] = {clock_.Now(), sample.sequence, sample.valid};
    return sample;
  }
  const std::vector<Use>& uses() const { return uses_; }

 private:
  SessionClock clock_;
  std::vector<Use> uses_;
};

/// The driver's record of the forces that it received, by tick.
struct Ear {
  SessionClock clock;
  std::vector<Nanoseconds> heard;  // 0: never
};

void Hear(const lcm::ReceiveBuffer* received, const std::string&, Ear* ear) {
  const Nanoseconds now = ear->clock.Now();
  force_t force;
  const auto* data = static_cast<const std::uint8_t*>(received->data);
  if (!DecodeMessage({data, received->data_size}, &force) || force.tick < 0) return;
  const auto tick = static_cast<std::size_t>(force.tick);
  if (tick < ear->heard.size() && ear->heard[tick] == 0) ear->heard[tick] = now;
}

void AskForPriority(int priority) {
  RealtimeOptions realtime;
  realtime.fifo_priority = priority;
  RequestRealtime(realtime);
}

/// Publishes a reading each kDriverPeriod and notes its time, until `published` is full.
void Speak(const std::stop_token& stop, const SessionClock& clock, lcm::LCM* driver,
           std::vector<Nanoseconds>* published) {
  device_t reading{0, 0, 0, {0, 0, 0.1, 0, 1}, true, false};
  for (std::size_t i = 1; i < published->size() && !stop.stop_requested(); ++i) {
    clock.SleepUntil(static_cast<Nanoseconds>(i) * kDriverPeriod);
    reading.sequence = static_cast<std::int64_t>(i);
    reading.time_ns = (*published)[i] = clock.Now();
    driver->publish(kDeviceChannel, &reading);
  }
}

/// Prints the latencies as JSON. `uses` and `heard` have one entry a tick; `published` has the time
/// of each reading by its sequence number.
void Report(const std::vector<RecordedDevice::Use>& uses, const std::vector<Nanoseconds>& heard,
            const std::vector<Nanoseconds>& published, const DeviceLinkSummary& summary,
            const RealtimeReport& realtime) {
  Histogram published_to_tick, tick_to_heard, round_trip;
  std::uint64_t last = 0, run = 0, unheard = 0;
  for (std::size_t tick = 0; tick < uses.size(); ++tick) {
    const RecordedDevice::Use& use = uses[tick];
    if (use.at == 0) continue;  // tick was skipped
    ++run;
    if (heard[tick] == 0) {
      ++unheard;
      continue;
    }
    tick_to_heard.Add(heard[tick] - use.at);
    if (!use.valid || use.sequence == last) continue;  // a reading that an earlier tick used
    last = use.sequence;
    published_to_tick.Add(use.at - published[use.sequence]);
    round_trip.Add(heard[tick] - published[use.sequence]);
  }
  const nlohmann::ordered_json report = {{"ticks", run},
                                         {"readings_received", summary.received},
                                         {"readings_refused", summary.refused},
                                         {"forces_sent", summary.sent},
                                         {"forces_unheard", unheard},
                                         {"reading_published_to_tick", ToJson(published_to_tick)},
                                         {"tick_to_force_heard", ToJson(tick_to_heard)},
                                         {"round_trip", ToJson(round_trip)},
                                         {"realtime", realtime.Lines()}};
  std::cout << JsonText(report) << "\n";
}

void Measure(double seconds) {
  constexpr int kDriverPriority = 60;  // a real driver would ask for it too
  const SessionClock clock;
  const auto ticks = static_cast<std::size_t>(seconds * 1000);
  const ImpulseEngineKinematics kinematics(Vector3d(0, 0, 0.1), -Vector3d::UnitZ(), {});
  RecordedDevice device(kinematics.limits(), clock, ticks);
  device.Home();
  device.EnableForce(true);
  SpscQueue<HapticSample> forces(64), samples(64);
  TripleBuffer<ToolState> tool_states;
  TripleBuffer<ContactPatch> patches;
  DeviceLink link(NetworkUrl(), clock, {{&device.readings(), nullptr}, forces});
  HapticLoop loop({{&device, kinematics}}, kPeriod, {tool_states, patches, samples, &forces});

  AskForPriority(kDriverPriority);  // LCM's own thread for the driver's socket inherits it
  Ear ear{clock, std::vector<Nanoseconds>(ticks)};
  const auto driver = ConnectToReceive(NetworkUrl(), "hpdm_driver_latency");
  driver->subscribeFunction(kForceChannel, Hear, &ear)->setQueueCapacity(0);
  std::vector<Nanoseconds> published(ticks + 1000);  // by sequence number
  RealtimeOptions haptic;
  haptic.fifo_priority = 80;
  haptic.lock_memory = haptic.prefault_stack = true;
  RealtimeReport granted;
  {
    std::jthread receive([&](std::stop_token stop) {
      AskForPriority(DeviceLink::kPriority);
      link.Receive(stop);
    });
    std::jthread send([&](std::stop_token stop) {
      AskForPriority(DeviceLink::kPriority);
      link.Send(stop);
    });
    std::jthread listen([&](std::stop_token stop) {
      AskForPriority(kDriverPriority);
      while (!stop.stop_requested()) driver->handleTimeout(20);
    });
    std::jthread speak([&](std::stop_token stop) {
      AskForPriority(kDriverPriority);
      Speak(stop, clock, driver.get(), &published);
    });
    std::jthread([&] {
      granted = RequestRealtime(haptic);
      RealLoopClock loop_clock(clock);
      loop.RunRealClock({}, loop_clock, 0, ticks);
    }).join();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));  // lets the last force arrive
  }

  Report(device.uses(), ear.heard, published, link.Summary(), granted);
}

}  // namespace
}  // namespace hpdm

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 10;
  if (!(seconds >= 0.1 && seconds <= 3600)) {
    std::fprintf(stderr, "hpdm_driver_latency: give seconds from 0.1 to 3600\n");
    return 2;
  }
  try {
    hpdm::Measure(seconds);
  } catch (const hpdm::MachineError& error) {
    std::fprintf(stderr, "hpdm_driver_latency: %s\n", error.what());
    return 3;
  }
  return 0;
}
