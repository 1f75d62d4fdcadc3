#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "lcmtypes/log/message_source.h"

namespace lcm {
class LCM;
struct ReceiveBuffer;
}  // namespace lcm

namespace hpdm {

/// Receives every channel of an LCM network. Sends nothing.
///
/// 1. Its own thread takes the messages from LCM, so a reader may read rarely (a screen: 20 times a
///    second).
/// 2. Unread messages wait here, within bounds. Messages beyond the bounds are dropped and counted.
/// 3. If the machine keeps the thread from running, LCM drops all but 4,096 messages, uncounted.
/// 4. Time stamps are the arrival at this machine, in microseconds since 1970.
class LiveSource : public MessageSource {
 public:
  static constexpr std::size_t kMaxWaitingMessages = 1 << 17;
  static constexpr std::size_t kMaxWaitingBytes = 64 << 20;

  /// Opens `url` with a large receive buffer, as far as the system grants one, for `option`
  /// ("spy"). Throws MachineError if the network cannot be opened. "memq://" stays inside the
  /// program, for tests.
  LiveSource(const std::string& url, const std::string& option);
  ~LiveSource() override;
  LiveSource(const LiveSource&) = delete;
  LiveSource& operator=(const LiveSource&) = delete;

  bool Next(LogEvent* event, std::chrono::milliseconds patience) override;

  /// Messages dropped because they were not read in time. Any thread.
  std::uint64_t dropped() const;

  lcm::LCM& connection() { return *lcm_; }

 private:
  static void Receive(const lcm::ReceiveBuffer* received, const std::string& channel,
                      LiveSource* source);
  void Collect(std::stop_token stop);

  std::unique_ptr<lcm::LCM> lcm_;
  std::vector<LogEvent> batch_;  // of the collecting thread
  std::size_t batched_ = 0;

  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<LogEvent> waiting_;
  std::vector<LogEvent> spent_;  // whose memory serves again
  std::size_t waiting_bytes_ = 0;
  std::uint64_t dropped_ = 0;

  std::jthread collector_;  // ends first
};

}  // namespace hpdm
