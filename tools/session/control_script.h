#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/snapshots.h"
#include "engine/threads/triple_buffer.h"
#include "scenes/loader/scene.h"

namespace hpdm {

/// The controls of the haptic loop from a session time on.
struct TimedControl {
  Nanoseconds time_ns = 0;
  SessionControl control;
  std::string name = {};  ///< For people: "exchange of probe to hook at 9 s".
  /// Step at which the exercise restarts then (RestartRequest). The control's own request is not used.
  std::optional<int> restart_step = {};
};

/// Scripted SessionControl changes for unattended runs. One thread, which writes the edge.
class ControlScript {
 public:
  ControlScript() = default;
  /// The times of `controls` do not decrease.
  explicit ControlScript(std::vector<TimedControl> controls) : controls_(std::move(controls)) {}

  /// Publishes the controls of session time `now_ns` to the edge if they have changed since the
  /// last call. `now_ns` does not decrease from call to call.
  void Advance(Nanoseconds now_ns, TripleBuffer<SessionControl>* edge);

  /// Pauses the session, from now on and whatever controls follow, or leaves it to them again.
  void SetPaused(bool paused, TripleBuffer<SessionControl>* edge);

  /// Restarts the exercise at a step, as in RestartRequest.
  void Restart(int step, TripleBuffer<SessionControl>* edge);

  /// Returns the names of the controls whose time no call has reached, in their order.
  std::vector<std::string> Left() const;

 private:
  void Publish(TripleBuffer<SessionControl>* edge) const;

  std::vector<TimedControl> controls_;
  std::size_t next_ = 0;
  bool paused_ = false;
  RestartRequest restart_;
};

/// Arguments of the command line.
struct ControlArguments {
  std::vector<std::string> exchanges, pedals, restarts;
};

/// Parses arguments of
///   --exchange, NAME=OTHER@SECONDS: at that time the hand whose first instrument is NAME takes OTHER, which
///       is one of its exchanges or NAME itself;
///   --pedal, NAME@FROM-TO: the pedal of that hand is pressed between these times (s);
///   --restart, STEP@SECONDS: the exercise restarts at this step, from 1.
/// Throws InputError for any other argument.
ControlScript ParseControls(const ControlArguments& arguments, const Scene& scene);

}  // namespace hpdm
