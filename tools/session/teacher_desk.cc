#include "tools/session/teacher_desk.h"

#include <algorithm>

#include "lcmtypes/telemetry/session_info.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

std::string PlaceText(const TeacherRequest& request) {
  std::string text = Format("at %.0f %% from the left and %.0f %% from the top of the picture",
                            100 * request.x, 100 * request.y);
  if (request.text[0] != '\0') text += std::string(": ") + request.text.data();
  return text;
}

std::string StepText(int step) {
  return step < 0 ? "its present step" : Format("step %d", step + 1);
}

}  // namespace

TeacherDesk::Wishes TeacherDesk::Handle(Nanoseconds now, int over) {
  Wishes wishes;
  bool changed = RemoveOld(now, over);
  TeacherRequest request;
  while (edges_.requests.Pop(&request)) {
    switch (request.kind) {
      case TeacherRequest::Kind::kPause:
        wishes.pause = true;
        Log("teacher.paused", "the teacher pauses the session");
        break;
      case TeacherRequest::Kind::kContinue:
        wishes.pause = false;
        Log("teacher.continued", "the teacher continues the session");
        break;
      case TeacherRequest::Kind::kPoint:
        AddMark(request, now);
        changed = true;
        Log("teacher.point", "the teacher points " + PlaceText(request));
        break;
      case TeacherRequest::Kind::kBleed:
        AddMark(request, now);
        changed = true;
        Log(std::string(kBleeding).c_str(), "a bleeding begins " + PlaceText(request));
        break;
      case TeacherRequest::Kind::kRestart:
        wishes.restart_step = request.step;
        Log("teacher.restart", "the teacher restarts the exercise at " + StepText(request.step));
        break;
    }
  }
  if (changed) {
    edges_.marks.Back() = marks_;
    edges_.marks.Publish();
  }
  return wishes;
}

// The oldest point makes place for a new mark, or else the oldest bleeding.
void TeacherDesk::AddMark(const TeacherRequest& request, Nanoseconds now) {
  const auto begin = marks_.marks.begin();
  if (marks_.count == PictureMarks::kMost) {
    const auto end = begin + marks_.count;
    const auto point = std::find_if(
        begin, end, [](const PictureMark& mark) { return mark.kind == PictureMark::Kind::kPoint; });
    if (point == end) ++removed_;
    Remove(point == end ? 0 : static_cast<int>(point - begin));
  }
  PictureMark& mark = marks_.marks[static_cast<std::size_t>(marks_.count++)];
  mark.kind = request.kind == TeacherRequest::Kind::kPoint ? PictureMark::Kind::kPoint
                                                           : PictureMark::Kind::kBleeding;
  mark.x = request.x;
  mark.y = request.y;
  mark.since_ns = now;
  mark.text = request.text;
}

void TeacherDesk::Remove(int mark) {
  std::copy(marks_.marks.begin() + mark + 1, marks_.marks.begin() + marks_.count,
            marks_.marks.begin() + mark);
  --marks_.count;
}

// Removes points that were shown long enough, and bleedings that are over.
bool TeacherDesk::RemoveOld(Nanoseconds now, int over) {
  const int before = marks_.count;
  for (int m = 0; m < marks_.count;) {
    const PictureMark& mark = marks_.marks[static_cast<std::size_t>(m)];
    const bool is_point = mark.kind == PictureMark::Kind::kPoint;
    const bool gone = is_point ? now - mark.since_ns >= kPointShown : removed_ < over;
    if (gone && !is_point) ++removed_;
    gone ? Remove(m) : static_cast<void>(++m);
  }
  return marks_.count != before;
}

void TeacherDesk::Log(const char* name, const std::string& text) {
  edges_.events.Push(MakeLoopEvent(EventSeverity::kInfo, name, text));
}

}  // namespace hpdm
