#pragma once

#include <optional>
#include <string>

#include "engine/base/types.h"
#include "engine/threads/loop_event.h"
#include "engine/threads/spsc_queue.h"
#include "engine/threads/triple_buffer.h"
#include "lcmtypes/live/teacher_link.h"
#include "render/overlay/picture_marks.h"

namespace hpdm {

/// Does what a teacher asks for during a session:
///
///     TeacherRequest queue --> [TeacherDesk] --PictureMarks, latest--> render loop
///                                  |  '--------LoopEvent queue-------> telemetry: log, exercise
///                                  '--pause--> window, or controls of the command line
///
/// Main thread.
class TeacherDesk {
 public:
  /// A pointed place is shown for so long, ns.
  static constexpr Nanoseconds kPointShown = 10 * kNanosecondsPerSecond;

  struct Edges {
    SpscQueue<TeacherRequest>& requests;
    TripleBuffer<PictureMarks>& marks;
    SpscQueue<LoopEvent>& events;
  };
  explicit TeacherDesk(const Edges& edges) : edges_(edges) {}

  /// Handles the requests that have come by session time `now`. `stopped`: number of the exercise's
  /// bleedings that were stopped; so many of the oldest marks are gone. Returns the pause that was asked
  /// for last, if any.
  std::optional<bool> Handle(Nanoseconds now, int stopped);

 private:
  void AddMark(const TeacherRequest& request, Nanoseconds now);
  void Remove(int mark);
  bool RemoveOld(Nanoseconds now, int stopped);
  void Log(const char* name, const std::string& text);

  Edges edges_;
  PictureMarks marks_;
  int stopped_ = 0;  // bleedings whose marks are gone
};

}  // namespace hpdm
