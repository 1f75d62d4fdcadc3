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

/// Every channel of an LCM network. A thread of its own takes the messages from LCM as they come,
/// so that a reader may look only now and then (a screen, 20 times a second): what it has not read
/// waits here, within bounds, and messages beyond them are dropped and counted; where the machine
/// keeps that thread from running, LCM drops all but 4,096 messages, uncounted. Time stamps are
/// those of the arrival at this machine, in microseconds since 1970. Nothing is ever sent.
class LiveSource : public MessageSource {
 public:
  static constexpr std::size_t kMaxWaitingMessages = 1 << 17;
  static constexpr std::size_t kMaxWaitingBytes = 64 << 20;

  /// Opens `url` with a large receive buffer, as far as the system grants one, for `option`
  /// ("spy"). Throws MachineError where no network lets it. "memq://" stays inside the program, for
  /// tests.
  LiveSource(const std::string& url, const std::string& option);
  ~LiveSource() override;
  LiveSource(const LiveSource&) = delete;
  LiveSource& operator=(const LiveSource&) = delete;

  bool Next(LogEvent* event, std::chrono::milliseconds patience) override;

  /// Messages that the reader left for too long. Any thread.
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
