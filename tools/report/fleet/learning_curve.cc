#include "tools/report/fleet/learning_curve.h"

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <map>
#include <utility>

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

// How a figure of a report is found from those of the hands.
enum class Over { kSession, kSum, kLargest };

struct Figure {
  const char* key;
  const char* label;
  const char* unit;
  const char* place;  // JSON pointer in the report, or in its hands
  Over over;
  double scale;
  bool rises;  // with learning
};

constexpr Figure kFigures[] = {
    {"score", "Score of the exercise", "of 100", "/exercise/score", Over::kSession, 1, true},
    {"exercise_time", "Time of the exercise", "s", "/exercise/time_s", Over::kSession, 1, false},
    {"restarts", "Steps that began again", "", "/exercise/restart_count", Over::kSession, 1, false},
    {"errors", "Errors", "", "/exercise/error_count", Over::kSession, 1, false},
    {"depth_perception", "GOALS: depth perception, estimated", "1 to 5",
     "/goals/depth_perception/rating", Over::kSession, 1, true},
    {"bimanual_dexterity", "GOALS: bimanual dexterity, estimated", "1 to 5",
     "/goals/bimanual_dexterity/rating", Over::kSession, 1, true},
    {"efficiency", "GOALS: efficiency, estimated", "1 to 5", "/goals/efficiency/rating",
     Over::kSession, 1, true},
    {"tissue_handling", "GOALS: tissue handling, estimated", "1 to 5",
     "/goals/tissue_handling/rating", Over::kSession, 1, true},
    {"path_length", "Path of all tips", "m", "/path_length_m", Over::kSum, 1, false},
    {"peak_force", "Peak force", "N", "/peak_force_N", Over::kLargest, 1, false},
    {"over_limit", "Time above the force limit", "s", "/over_limit_s", Over::kSum, 1, false},
};

std::optional<double> NumberAt(const Json& values, const char* place) {
  const Json::json_pointer pointer{std::string(place)};
  if (!values.is_object() || !values.contains(pointer) || !values.at(pointer).is_number()) {
    return std::nullopt;
  }
  return values.at(pointer).get<double>();
}

std::string TextAt(const Json& values, const char* place) {
  const Json::json_pointer pointer{std::string(place)};
  if (!values.is_object() || !values.contains(pointer) || !values.at(pointer).is_string())
    return "";
  return values.at(pointer);
}

std::optional<double> ValueOf(const Figure& figure, const Json& report) {
  if (figure.over == Over::kSession) {
    const std::optional<double> value = NumberAt(report, figure.place);
    return value ? std::optional(figure.scale * *value) : std::nullopt;
  }
  std::optional<double> result;
  if (!report.contains("hands") || !report["hands"].is_array()) return result;
  for (const Json& hand : report["hands"]) {
    const std::optional<double> value = NumberAt(hand, figure.place);
    if (!value) continue;
    const double so_far = result.value_or(0);
    result = figure.over == Over::kSum ? so_far + *value : std::max(so_far, *value);
  }
  if (result) *result *= figure.scale;
  return result;
}

/// Returns when a session began, or else when its log was last written, as the report has it.
std::string StartOf(const Json& line) {
  std::string start = TextAt(line, "/report/start");
  if (!start.empty()) return start;
  const auto seconds =
      static_cast<std::time_t>(NumberAt(line, "/log_mtime_ns").value_or(0) / 1'000'000'000);
  std::tm utc{};
  char text[40];
  if (gmtime_r(&seconds, &utc) == nullptr ||
      std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc) == 0) {
    return "";
  }
  return text;
}

}  // namespace

std::optional<LearningFit> FitLearning(std::span<const std::optional<double>> values) {
  double count = 0, mean_x = 0, mean_y = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i]) continue;
    ++count;
    mean_x += 1 / static_cast<double>(i + 1);
    mean_y += *values[i];
  }
  if (count < static_cast<double>(kFewestForFit)) return std::nullopt;
  mean_x /= count;
  mean_y /= count;
  double xx = 0, xy = 0, yy = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i]) continue;
    const double x = 1 / static_cast<double>(i + 1) - mean_x, y = *values[i] - mean_y;
    xx += x * x;
    xy += x * y;
    yy += y * y;
  }
  if (yy <= 0) return std::nullopt;
  LearningFit fit;
  fit.drop = -xy / xx;
  fit.plateau = mean_y + fit.drop * mean_x;
  fit.explained = xy * xy / (xx * yy);
  if (fit.drop > 0 && fit.plateau > 0) fit.sessions_to_90 = 10 * fit.drop / fit.plateau;
  return fit;
}

std::vector<LearningCurve> LearningCurves(std::span<const Json> lines) {
  // The first key is the task. The second is the start, then the name of the session.
  std::map<std::string, std::map<std::pair<std::string, std::string>, const Json*>> tasks;
  for (const Json& line : lines) {
    if (!line.contains("report") || !line["report"].is_object()) continue;
    std::string task = TextAt(line, "/report/exercise/name");
    if (task.empty()) task = TextAt(line, "/report/scene");
    if (task.empty()) continue;
    tasks[task][{StartOf(line), TextAt(line, "/session")}] = &line;
  }
  std::vector<LearningCurve> curves;
  for (const auto& [task, sessions] : tasks) {
    LearningCurve curve;
    curve.task = task;
    for (const auto& [key, line] : sessions) {
      curve.starts.push_back(key.first);
      curve.names.push_back(key.second);
    }
    for (const Figure& figure : kFigures) {
      LearningSeries series{figure.key, figure.label, figure.unit, {}, {}};
      for (const auto& [key, line] : sessions) {
        series.values.push_back(ValueOf(figure, (*line)["report"]));
      }
      const bool any =
          std::ranges::any_of(series.values, [](const auto& value) { return !!value; });
      if (!any) continue;
      if (figure.rises) series.fit = FitLearning(series.values);
      curve.series.push_back(std::move(series));
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace hpdm
