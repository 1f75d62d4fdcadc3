#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <thread>

#include "engine/snapshots.h"
#include "engine/threads/spsc_queue.h"

namespace lcm {
class LCM;
struct ReceiveBuffer;
}  // namespace lcm

namespace hpdm {

/// A checked request of a teacher (teacher.lcm).
struct TeacherRequest {
  enum class Kind { kPause, kContinue, kPoint, kBleed, kRestart };
  Kind kind = Kind::kPause;
  int step = RestartRequest::kPresent;  ///< As in RestartRequest.
  double x = 0, y = 0;                  ///< Place in the picture, 0..1 from its left and top.
  std::array<char, 64> text{};          ///< Ends with a zero.
};

/// Reads a message. Returns false if it is none, its request is unknown, its place is outside the picture,
/// or its text is longer than 60 bytes or has control characters.
bool ReadRequest(std::span<const std::uint8_t> bytes, TeacherRequest* request);

/// Receives a teacher's requests on HPDM_TEACHER and hands them on:
///
///     HPDM_TEACHER --> [own thread] --TeacherRequest queue--> TeacherDesk, main thread
///
/// Requests that are invalid, or find the queue full, are dropped. Messages are not
/// authenticated: whoever is on the network is the teacher.
class TeacherLink {
 public:
  /// Opens `url` and begins to receive. The queue outlives the link. Throws MachineError if the network
  /// cannot be opened. "memq://" stays inside the program, for tests.
  TeacherLink(const std::string& url, SpscQueue<TeacherRequest>* requests);
  ~TeacherLink();
  TeacherLink(const TeacherLink&) = delete;
  TeacherLink& operator=(const TeacherLink&) = delete;

  lcm::LCM& connection() { return *lcm_; }

 private:
  static void HandleReceived(const lcm::ReceiveBuffer* received, const std::string& channel,
                             TeacherLink* link);

  SpscQueue<TeacherRequest>& requests_;
  std::unique_ptr<lcm::LCM> lcm_;
  std::jthread receiver_;  // ends first
};

}  // namespace hpdm
