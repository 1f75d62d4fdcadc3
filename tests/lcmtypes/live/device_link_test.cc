#include "lcmtypes/live/device_link.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <lcm/lcm-cpp.hpp>
#include <limits>
#include <random>
#include <thread>

#include "engine/base/error.h"
#include "haptics/device/external_device.h"
#include "haptics/haptic_loop.h"
#include "lcmtypes/live/network.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/network_namespace.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kMs = 1'000'000;

TEST(DriverClock, KeepsTheDriversSpacingWhateverTheNetworksJitter) {
  std::mt19937 random(5);
  DriverClock clock;
  const Nanoseconds zero = 987'654'321'012'345;  // of the driver's clock at session time 0
  for (Nanoseconds t = 0; t < 5000 * kMs; t += kMs) {
    const Nanoseconds delay = 50'000 + static_cast<Nanoseconds>(random() % 400'000);
    const Nanoseconds mapped = clock.ToSession(zero + t, t + delay);
    EXPECT_LE(mapped, t + delay) << "no reading is from the future";
    // Until the shortest delay has been met, stamps are up to the jitter late; after 100 readings
    // they are within a twentieth of it, and the estimate rises by 0.2 us a reading.
    EXPECT_GE(mapped, t + 50'000);
    if (t > 100 * kMs) {
      EXPECT_LE(mapped, t + 50'000 + 60'000);
    }
  }
}

TEST(DriverClock, FollowsAClockThatRunsTooSlowOrTooFast) {
  for (const double ppm : {-100.0, 100.0}) {
    DriverClock clock;
    Nanoseconds mapped = 0, t = 0;
    for (; t < 3600'000 * kMs; t += 100 * kMs) {
      mapped = clock.ToSession(std::llround(static_cast<double>(t) * (1 + 1e-6 * ppm)), t + kMs);
    }
    // The clocks diverge by 360 ms in an hour. The estimate lags by 200 ppm of one interval.
    EXPECT_NEAR(static_cast<double>(mapped), static_cast<double>(t - 99 * kMs), 30'000) << ppm;
  }
}

TEST(DriverClock, ARestartedDriverIsFollowedAtOnceAndTimeNeverFalls) {
  DriverClock clock;
  Nanoseconds last = 0;
  for (const Nanoseconds zero :
       {5'000'000 * kMs, Nanoseconds{0}, 9'000'000 * kMs, -7 * kMs, DriverClock::kMaxStamp / 2}) {
    const Nanoseconds start = last + 200 * kMs;
    for (Nanoseconds t = start; t < start + 100 * kMs; t += kMs) {
      const Nanoseconds mapped = clock.ToSession(zero + (t - start), t);
      EXPECT_GE(mapped, last);
      EXPECT_LE(mapped, t);
      // At 200 ppm a tenth of a second is 20 us.
      EXPECT_GE(mapped, t - 20'000);
      last = mapped;
    }
  }
}

device_t Reading(std::int64_t sequence, Nanoseconds time, int instrument = 0) {
  device_t message;
  message.sequence = sequence;
  message.time_ns = time;
  message.instrument = instrument;
  for (int i = 0; i < 5; ++i) message.joints[i] = 0.01 * static_cast<double>(sequence) + i;
  message.valid = true;
  return message;
}

/// A link inside the program, and its edges.
struct Bench {
  Bench() : link("memq://", SessionClock(), {{&readings, nullptr}, forces, &events}) {}

  void Handle(const device_t& message, Nanoseconds arrival) {
    std::vector<std::uint8_t> buffer;
    link.Handle(EncodeMessage(message, &buffer), arrival);
  }

  TripleBuffer<DeviceSample> readings;
  SpscQueue<HapticSample> forces{64};
  SpscQueue<LoopEvent> events{16};
  DeviceLink link;
};

TEST(DeviceLink, AReadingArrivesExactAtSessionTime) {
  Bench bench;
  bench.Handle(Reading(7, 123'456), 10 * kMs);
  ASSERT_TRUE(bench.readings.Update());
  const DeviceSample& sample = bench.readings.Front();
  EXPECT_EQ(sample.sequence, 7u);
  EXPECT_EQ(sample.time_ns, 10 * kMs);
  EXPECT_TRUE(sample.valid);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(sample.joints[i], 0.07 + i);
  bench.Handle(Reading(8, 1'123'456), 11 * kMs + 300'000);
  ASSERT_TRUE(bench.readings.Update());
  // 0.3 ms late, but taken 1 ms after the one before; the estimate rises by 200 ppm.
  EXPECT_NEAR(static_cast<double>(bench.readings.Front().time_ns), 11e6, 300);
}

TEST(DeviceLink, ForeignBytesAreRefusedAndCounted) {
  Bench bench;
  std::vector<std::uint8_t> sound;
  EncodeMessage(Reading(1, 0), &sound);
  std::uint64_t refused = 0;
  for (std::size_t size = 0; size < sound.size(); ++size, ++refused) {
    bench.link.Handle({sound.data(), size}, 0);
  }
  std::vector<std::uint8_t> longer = sound;
  longer.push_back(0);
  bench.link.Handle(longer, 0);
  std::vector<std::uint8_t> other_type = sound;
  other_type[3] ^= 1;
  bench.link.Handle(other_type, 0);
  bench.Handle(Reading(1, 0, -1), 0);
  bench.Handle(Reading(1, 0, kMaxInstruments), 0);
  bench.Handle(Reading(1, 0, 1), 0);  // has no external device
  bench.Handle(Reading(1, std::numeric_limits<std::int64_t>::min()), 0);
  bench.Handle(Reading(1, std::numeric_limits<std::int64_t>::max()), 0);
  refused += 7;
  EXPECT_EQ(bench.link.Summary().refused, refused);
  EXPECT_EQ(bench.link.Summary().received, 0u);
  EXPECT_FALSE(bench.readings.Update());
}

TEST(DeviceLink, NoFlippedByteGivesThePoseOfANonReading) {
  Bench bench;
  std::vector<std::uint8_t> sound;
  EncodeMessage(Reading(1, 0), &sound);
  ExternalDevice device{DeviceLimits{}};
  std::mt19937 random(6);
  Nanoseconds now = 0;
  for (int i = 0; i < 5000; ++i) {
    std::vector<std::uint8_t> bytes = sound;
    for (int k = 0; k < 3; ++k)
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    bench.link.Handle(bytes, now += 100 * kMs);
    if (!bench.readings.Update()) continue;
    device.readings().Back() = bench.readings.Front();
    device.readings().Publish();
    EXPECT_TRUE(device.Read(now).joints.allFinite());
  }
}

TEST(DeviceLink, TheFirstRefusalOfEachKindIsReported) {
  Bench bench;
  for (int i = 0; i < 100; ++i) {
    bench.link.Handle(std::vector<std::uint8_t>(60'000), 0);
    bench.Handle(Reading(1, 0, 1), 0);
    bench.Handle(Reading(5, 0), 0);  // taken once, old afterwards
  }
  std::vector<std::string> reported;
  for (LoopEvent event; bench.events.Pop(&event);) {
    EXPECT_STREQ(event.name.data(), "device.refused");
    EXPECT_EQ(event.severity, EventSeverity::kWarning);
    reported.emplace_back(event.text.data());
    // The whole sentence has room.
    EXPECT_LT(reported.back().size(), event.text.size() - 1) << reported.back();
  }
  ASSERT_EQ(reported.size(), 3u);
  EXPECT_TRUE(reported[0].starts_with("a message of 60000 bytes on HPDM_DEVICE was refused"));
  EXPECT_NE(reported[1].find("instrument 1"), std::string::npos);
  EXPECT_NE(reported[2].find("two drivers"), std::string::npos);
  EXPECT_EQ(bench.link.Summary().refused, 299u);
}

TEST(DeviceLink, SequencesRiseUntilTheDriverWasSilent) {
  Bench bench;
  for (const std::int64_t sequence : {100, 101, 101, 99, 105, 104, 1}) {
    bench.Handle(Reading(sequence, 0), kMs);
  }
  EXPECT_EQ(bench.link.Summary().received, 3u);
  EXPECT_EQ(bench.link.Summary().refused, 4u);
  bench.Handle(Reading(1, 0), kMs + DeviceLink::kRestartAfter);
  ASSERT_TRUE(bench.readings.Update());
  EXPECT_EQ(bench.readings.Front().sequence, 1u);
}

TEST(DeviceLink, ANetworkThatIsNotThereIsAMachineError) {
  TripleBuffer<DeviceSample> readings;
  SpscQueue<HapticSample> forces(4);
  EXPECT_THROW(DeviceLink("nonsense://", SessionClock(), {{&readings, nullptr}, forces}),
               MachineError);
}

/// Forces as a driver sees them.
struct Heard {
  std::int64_t last_sequence = 0;
  std::uint64_t last_tick = 0;
  int count = 0;
  bool in_order = true;
};

// A plain function: GCC 12's undefined-behaviour sanitizer misjudges LCM's calls of members.
void Hear(const lcm::ReceiveBuffer* received, const std::string&, Heard* heard) {
  force_t message;
  HapticSample sample;
  const auto* data = static_cast<const std::uint8_t*>(received->data);
  ASSERT_TRUE(DecodeMessage({data, received->data_size}, &message));
  ASSERT_TRUE(FromMessage(message, &sample));
  heard->in_order &= message.sequence == heard->last_sequence + 1;
  heard->last_sequence = message.sequence;
  heard->last_tick = sample.tick;
  ++heard->count;
}

template <typename Done>
bool Within(std::chrono::seconds patience, const Done& done) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

constexpr auto kLinkPatience =
    std::chrono::seconds(20);  // a machine under load; usual are a few ms

// Runs the link's two threads and the haptic loop in virtual time: a driver appears, vanishes and
// returns.
TEST(DeviceLink, ADriverThatVanishesAndComesBackLosesAndRegainsItsDevice) {
  const DeviceLimits limits = LimitsOf({});
  ExternalDevice device(limits);
  SpscQueue<HapticSample> forces(1024);
  DeviceLink link("memq://", SessionClock(), {{&device.readings(), nullptr}, forces});
  Heard heard;
  link.connection().subscribeFunction(kForceChannel, Hear, &heard)->setQueueCapacity(0);
  std::jthread receive([&](std::stop_token stop) { link.Receive(stop); });
  std::jthread send([&](std::stop_token stop) { link.Send(stop); });

  TripleBuffer<ToolState> tool_states;
  TripleBuffer<ContactPatch> patches;
  SpscQueue<HapticSample> samples(1024);
  HapticLoop loop({{&device, {Vector3d(0, 0, 0.1), -Vector3d::UnitZ(), {}}}}, kMs,
                  {tool_states, patches, samples, &forces});
  std::uint64_t tick = 0;
  const auto valid_after_a_tick = [&] {
    loop.Tick(tick, static_cast<Nanoseconds>(tick) * kMs, {});
    ++tick;
    HapticSample sample;
    EXPECT_TRUE(samples.Pop(&sample));
    return sample.tools[0].device_valid;
  };
  std::int64_t sequence = 0;
  const auto speak = [&] {
    ++sequence;
    device_t message = Reading(sequence, sequence * kMs);
    for (double& joint : message.joints) joint = 0.05;
    link.connection().publish(kDeviceChannel, &message);
  };

  EXPECT_FALSE(valid_after_a_tick());
  for (int time = 0; time < 3; ++time) {
    EXPECT_TRUE(Within(kLinkPatience, [&] {
      speak();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      return valid_after_a_tick();
    }));
    // Readings that are still on their way may come within these ticks.
    EXPECT_TRUE(Within(kLinkPatience, [&] {
      for (int i = 0; i < 51; ++i) valid_after_a_tick();
      return !valid_after_a_tick();
    }));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  for (std::jthread* thread : {&send, &receive}) {
    thread->request_stop();
    thread->join();
  }
  const DeviceLinkSummary summary = link.Summary();
  EXPECT_EQ(summary.sent + summary.overflows, tick);
  EXPECT_EQ(summary.send_errors, 0u);
  EXPECT_GT(summary.received, 2u);
  EXPECT_EQ(summary.refused, 0u);
  EXPECT_TRUE(heard.in_order);
  EXPECT_GT(heard.count, 0);
}

// Two programs' connections on the machine's multicast, in a network namespace of their own.
TEST(DeviceLink, ReadingsAndForcesCrossTheMulticast) {
  if (!InsideNetworkNamespace()) {
    const std::string enter = NetworkNamespaceCommand();
    if (enter.empty()) GTEST_SKIP() << "network namespaces are refused here";
    EXPECT_EQ(RunInNetworkNamespace(enter, "DeviceLink.ReadingsAndForcesCrossTheMulticast"), 0);
    return;
  }
  TripleBuffer<DeviceSample> readings;
  SpscQueue<HapticSample> forces(64);
  DeviceLink link(NetworkUrl(), SessionClock(), {{&readings, nullptr}, forces});
  std::jthread receive([&](std::stop_token stop) { link.Receive(stop); });
  std::jthread send([&](std::stop_token stop) { link.Send(stop); });

  lcm::LCM driver(kLocalUrl);
  ASSERT_TRUE(driver.good());
  Heard heard;
  driver.subscribeFunction(kForceChannel, Hear, &heard)->setQueueCapacity(0);
  constexpr int kCount = 200;
  for (int i = 1; i <= kCount; ++i) {
    const device_t message = Reading(i, i * kMs);
    driver.publish(kDeviceChannel, &message);
    HapticSample sample;
    sample.tick = static_cast<std::uint64_t>(i);
    sample.tool_count = 1;
    forces.Push(sample);
    while (driver.handleTimeout(1) > 0) {
    }
  }
  EXPECT_TRUE(Within(kLinkPatience, [&] {
    driver.handleTimeout(1);
    readings.Update();
    return heard.count == kCount && readings.Front().sequence == kCount;
  }));
  EXPECT_EQ(heard.count, kCount);
  EXPECT_EQ(heard.last_tick, static_cast<std::uint64_t>(kCount));
  EXPECT_TRUE(heard.in_order);
}

}  // namespace
}  // namespace hpdm
