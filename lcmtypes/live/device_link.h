#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "engine/snapshots.h"
#include "engine/threads/loop_event.h"
#include "engine/threads/session_clock.h"
#include "engine/threads/spsc_queue.h"
#include "engine/threads/triple_buffer.h"
#include "hpdm/force_t.hpp"
#include "lcmtypes/live/driver_clock.h"

namespace lcm {
class LCM;
struct ReceiveBuffer;
}  // namespace lcm

namespace hpdm {

struct DeviceLinkSummary {
  std::uint64_t received = 0;     ///< Readings handed on.
  std::uint64_t refused = 0;      ///< Invalid, of an instrument without external driver, or old.
  std::uint64_t sent = 0;         ///< Forces published.
  std::uint64_t send_errors = 0;  ///< Forces that the network refused.
  std::uint64_t overflows = 0;    ///< Ticks that found the queue to the link full.
};

/// Connects devices whose drivers are other programs: receives HPDM_DEVICE and sends HPDM_FORCE.
///
///     HPDM_DEVICE --> [Receive] --DeviceSample, latest--> ExternalDevice --> haptic loop
///     HPDM_FORCE <--- [Send] <---HapticSample queue, every tick-----------------'
///
/// Receive sleeps until a message comes. The haptic thread may not make a system call, so it cannot
/// wake Send: Send looks into the queue every kSendPeriod.
///
/// 1. Foreign bytes are checked before they are used.
/// 2. The sequence numbers of each instrument's readings must rise; a late reading is refused.
///    After kRestartAfter without a reading any number is accepted, since the driver may have
///    restarted.
/// 3. The driver's time stamps are converted to session time (DriverClock).
class DeviceLink {
 public:
  static constexpr Nanoseconds kSendPeriod = 100'000;
  static constexpr Nanoseconds kRestartAfter = 50'000'000;

  struct Edges {
    /// One per instrument. Null if it has no external driver; its readings are refused then.
    std::array<TripleBuffer<DeviceSample>*, kMaxInstruments> devices{};
    SpscQueue<HapticSample>& forces;
    SpscQueue<LoopEvent>* events = nullptr;  ///< Receives the first refusal of each kind.
  };

  /// Opens `url` and subscribes. The thread that LCM starts for its socket runs under SCHED_FIFO at
  /// kPriority if the system grants it. The edges outlive the link. Throws MachineError if the
  /// network cannot be opened. "memq://" stays inside the program, for tests.
  DeviceLink(const std::string& url, const SessionClock& clock, const Edges& edges);
  ~DeviceLink();
  DeviceLink(const DeviceLink&) = delete;
  DeviceLink& operator=(const DeviceLink&) = delete;

  /// Below the haptic loop, above the deformation loop.
  static constexpr int kPriority = 70;

  /// Receive and Send each run on a thread of their own. They return within 20 ms of the stop and
  /// do not throw.
  void Receive(std::stop_token stop) noexcept;
  void Send(std::stop_token stop) noexcept;

  /// Handles the bytes of one message that arrived at session time `arrival`. Call on the receiving
  /// thread.
  void Handle(std::span<const std::uint8_t> bytes, Nanoseconds arrival) noexcept;

  /// Returns the counts. Call after both threads have ended.
  DeviceLinkSummary Summary() const;

  lcm::LCM& connection() { return *lcm_; }

 private:
  // Reason for refusing a message.
  enum class Refusal { kNoReading, kNotOurs, kStale };
  static constexpr std::size_t kRefusals = 3;
  void Refuse(Refusal why, std::size_t bytes, int instrument) noexcept;
  static void HandleReceived(const lcm::ReceiveBuffer* received, const std::string& channel,
                             DeviceLink* link);

  struct Driver {
    DriverClock clock;
    bool heard = false;
    std::uint64_t last_sequence = 0;
    Nanoseconds last_arrival = 0;
  };

  SessionClock clock_;
  Edges edges_;
  std::unique_ptr<lcm::LCM> lcm_;

  // Used only by the receiving thread.
  std::array<Driver, kMaxInstruments> drivers_;
  std::uint64_t received_ = 0;
  std::array<std::uint64_t, kRefusals> refused_{};

  // Used only by the sending thread.
  force_t force_{};
  std::vector<std::uint8_t> buffer_;
  std::uint64_t sent_ = 0, send_errors_ = 0;
};

}  // namespace hpdm
