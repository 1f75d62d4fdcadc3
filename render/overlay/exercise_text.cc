#include "render/overlay/exercise_text.h"

#include <algorithm>
#include <cmath>

#include "engine/exercise/duct_judge.h"
#include "render/overlay/status_lines.h"

namespace hpdm {
namespace {

constexpr double kErrorShown = 8;         // s for which an error stays on the screen
constexpr double kRestartShown = 6;       // s
constexpr double kDoneShown = 5;          // s for which a step that has just been done is named
constexpr double kInstructionShown = 20;  // s of a step; later its name, which covers less
constexpr double kNearlyTorn = 0.75;      // share of the way to tearing from which a pull is eased
constexpr std::size_t kMaxResult = 26;    // lines that fit on the picture

// Returns the name of the last error, or of a clip its faults with their figures.
std::string LastErrorText(const ExerciseStatus& status, const ExerciseOptions& exercise) {
  const auto duct = static_cast<std::size_t>(status.last_error_duct);
  const bool has_duct = status.last_error_duct >= 0 && duct < exercise.ducts.size();
  const std::string faults =
      FaultText(status.last_error_clip, has_duct ? exercise.ducts[duct].name : "", true);
  const std::string& name = exercise.errors[static_cast<std::size_t>(status.last_error)].name;
  if (faults.empty()) {
    const auto rule = static_cast<std::size_t>(status.last_error);
    const bool is_force = exercise.errors[rule].kind == ExerciseErrorKind::kForce;
    return is_force ? name + Format(": %.1f N", status.last_error_force) : name;
  }
  const bool lost = (status.last_error_clip.faults & (kClipOnNothing | kClipRefused)) != 0;
  if (lost) return name + ": " + faults;
  return (has_duct ? "bad clip on " : "bad clip: ") + faults;
}

std::string CountOf(int count, const char* noun) {
  return Format("%d %s%s", count, noun, count == 1 ? "" : "s");
}

// Returns when the present step began, last if it was restarted, in the exercise's time, s.
double BeganAt(const ExerciseStatus& status) {
  const auto step = static_cast<std::size_t>(status.step);
  const double before = step > 0 && step <= kShownSteps ? status.step_times[step - 1] : 0;
  return status.restarts > 0 ? std::max(before, status.restarted) : before;
}

}  // namespace

const ExerciseStepOptions* PresentStep(const ExerciseStatus& status, const StatusNames& names) {
  const auto step = static_cast<std::size_t>(status.step);
  const bool is_known = names.exercise && status.present && step < names.exercise->steps.size();
  return is_known ? &names.exercise->steps[step] : nullptr;
}

std::vector<StatusLine> GuidanceLines(const ExerciseStatus& status, const ExerciseOptions& exercise,
                                      double tautness, bool paused) {
  std::vector<StatusLine> lines;
  const auto step = static_cast<std::size_t>(status.step);
  if (!paused && status.last_error >= 0 && status.time - status.last_error_time < kErrorShown) {
    AddWrapped(LastErrorText(status, exercise), Tone::kAlarm, &lines);
  }
  if (status.restarts > 0 && status.time - status.restarted < kRestartShown) {
    lines.push_back({"begins again: instruments have let go", Tone::kWarning});
    lines.push_back({"and touch organs once they are outside", Tone::kWarning});
  }
  for (std::size_t s = 0; s < std::min({step, exercise.steps.size(), kShownSteps}); ++s) {
    if (status.time - status.step_times[s] > kDoneShown) continue;
    AddWrapped("done: " + exercise.steps[s].name, Tone::kPlain, &lines);
  }
  if (step < exercise.steps.size()) {
    const double began = BeganAt(status);
    const bool in_full = paused || status.time - began < kInstructionShown;
    const ExerciseStepOptions& present = exercise.steps[step];
    AddWrapped(Format("%zu/%zu ", step + 1, exercise.steps.size()) +
                   (in_full ? present.instruction : present.name + " (p: how)"),
               Tone::kGood, &lines);
    // Rounded down: 100 % is done.
    if (status.progress > 0)
      lines.push_back({Format("%.0f %%", std::floor(100 * status.progress))});
    if (tautness > 0) {
      const bool nearly = tautness >= kNearlyTorn;
      lines.push_back(
          {Format("pull: %.0f %% of tearing", 100 * tautness) + (nearly ? ", ease it" : ""),
           nearly ? Tone::kWarning : Tone::kPlain});
    }
  }
  lines.push_back({Format("%.0f s left, ", status.time_left) + CountOf(status.errors, "error") +
                       Format(", score %.0f", status.score),
                   Tone::kDim});
  return lines;
}

std::vector<StatusLine> ErrorLines(const ExerciseStatus& status, const ExerciseOptions& exercise) {
  std::vector<StatusLine> lines;
  for (std::size_t rule = 0; rule < std::min(exercise.errors.size(), kShownRules); ++rule) {
    const int count = status.error_counts[rule];
    if (count == 0) continue;
    AddWrapped((count > 1 ? Format("%d times ", count) : "") + exercise.errors[rule].name,
               Tone::kWarning, &lines);
  }
  return lines;
}

std::vector<StatusLine> ResultLines(const ExerciseStatus& status, const ExerciseOptions& exercise) {
  std::vector<StatusLine> lines = {
      {status.passed ? "EXERCISE DONE" : "TIME IS OVER",
       status.passed ? Tone::kGood : Tone::kWarning},
      {Format("%s, score %.0f of 100", status.passed ? "passed" : "not passed", status.score),
       status.passed ? Tone::kGood : Tone::kWarning},
      {exercise.name +
       Format(": %d of %zu steps in %.1f s, ", status.step, exercise.steps.size(), status.time) +
       CountOf(status.errors, "error") +
       (status.restarts > 0 ? ", " + CountOf(status.restarts, "restart") : "")}};
  for (std::size_t s = 0; s < std::min(exercise.steps.size(), kShownSteps); ++s) {
    const bool done = static_cast<int>(s) < status.step;
    lines.push_back({exercise.steps[s].name,
                     done ? Tone::kPlain : Tone::kDim,
                     {},
                     done ? Format("%.1f s", status.step_times[s]) : "\u2013"});
  }
  const std::size_t rules = std::min(exercise.errors.size(), kShownRules);
  std::size_t left = static_cast<std::size_t>(
      std::ranges::count_if(status.error_counts, [](std::uint16_t count) { return count > 0; }));
  for (std::size_t rule = 0; rule < rules; ++rule) {
    const int count = status.error_counts[rule];
    if (count == 0) continue;
    if (lines.size() + 2 >= kMaxResult && left > 1) {
      lines.push_back({"and more kinds of errors: see the report"});
      break;
    }
    --left;
    const std::string times = count > 1 ? Format(" (%d times)", count) : "";
    lines.push_back({exercise.errors[rule].name + times,
                     Tone::kWarning,
                     {},
                     Format("\u2212%g", count * exercise.errors[rule].points)});
  }
  lines.push_back({"Esc ends the session (s: screenshot)", Tone::kDim});
  return lines;
}

}  // namespace hpdm
