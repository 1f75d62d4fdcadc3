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
///                                  '--Wishes--> window, or controls of the command line
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

  /// What the teacher asked for last, if anything.
  struct Wishes {
    std::optional<bool> pause;
    std::optional<int> restart_step;  ///< As in RestartRequest.
  };
  /// Handles the requests that have come by session time `now`. `over`: number of the exercise's
  /// bleedings that are over; so many of the oldest marks are gone.
  Wishes Handle(Nanoseconds now, int over);

 private:
  void AddMark(const TeacherRequest& request, Nanoseconds now);
  void Remove(int mark);
  bool RemoveOld(Nanoseconds now, int over);
  void Log(const char* name, const std::string& text);

  Edges edges_;
  PictureMarks marks_;
  int removed_ = 0;  // bleedings whose marks are gone
};

}  // namespace hpdm
