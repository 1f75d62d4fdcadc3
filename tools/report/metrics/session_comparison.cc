#include "tools/report/metrics/session_comparison.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "engine/base/text_list.h"
#include "tools/report/metrics/report_json.h"
#include "tools/session/session_path.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Returns the session's folder, or a bare log's path.
fs::path PlaceOf(const SessionReport& report) {
  std::error_code error;
  fs::path log = fs::absolute(report.log, error).lexically_normal();
  if (error) log = report.log;
  return log.filename() == kSessionLogName && log.has_parent_path() ? log.parent_path() : log;
}

/// Returns the last `count` parts of a path.
fs::path LastParts(const fs::path& path, std::ptrdiff_t count) {
  fs::path last;
  const std::ptrdiff_t all = std::distance(path.begin(), path.end());
  for (auto part = std::next(path.begin(), std::max<std::ptrdiff_t>(all - count, 0));
       part != path.end(); ++part) {
    last /= *part;
  }
  return last;
}

std::vector<std::string> Instruments(const SessionReport& report) {
  std::vector<std::string> names;
  for (const HandReport& hand : report.hands) names.push_back(hand.name);
  return names;
}

std::string Listed(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) AppendToList(name, &list);
  return list.empty() ? "none" : list;
}

std::uint64_t ContactCount(const SessionReport& report) {
  std::uint64_t count = 0;
  for (const HandReport& hand : report.hands) count += hand.contact.count;
  return count;
}

const char* VerdictName(MetricDifference::Verdict verdict) {
  switch (verdict) {
    case MetricDifference::kSame:
      return "same";
    case MetricDifference::kBetter:
      return "better";
    case MetricDifference::kWorse:
      return "worse";
    default:
      return nullptr;
  }
}

}  // namespace

std::pair<std::string, std::string> SessionNames(const SessionReport& a, const SessionReport& b) {
  const fs::path first = PlaceOf(a), second = PlaceOf(b);
  std::ptrdiff_t count = 1;
  const std::ptrdiff_t most = std::max(std::distance(first.begin(), first.end()),
                                       std::distance(second.begin(), second.end()));
  while (count < most && LastParts(first, count) == LastParts(second, count)) ++count;
  if (first == second) count = 1;
  return {LastParts(first, count).string(), LastParts(second, count).string()};
}

TaskComparison CompareTasks(const SessionReport& report, const SessionReport& against) {
  TaskComparison task;
  if (!report.scene.empty() && !against.scene.empty() && report.scene != against.scene) {
    task.same_scene = false;
    task.warnings.push_back("another scene: " + report.scene + "; before: " + against.scene);
  } else if (report.organs != against.organs) {
    task.same_scene = false;
    task.warnings.push_back("other organs: " + Listed(report.organs) +
                            "; before: " + Listed(against.organs));
  }
  const std::vector<std::string> now = Instruments(report), before = Instruments(against);
  if (now != before) {
    task.same_instruments = false;
    task.warnings.push_back("other instruments: " + Listed(now) + "; before: " + Listed(before));
  }
  if (report.left_handed != against.left_handed) {
    task.same_instruments = false;
    task.warnings.emplace_back(report.left_handed ? "left-handed ports; before: right-handed"
                                                  : "right-handed ports; before: left-handed");
  }
  const bool touches = ContactCount(report) > 0;
  if (touches != (ContactCount(against) > 0)) {
    task.both_touch = false;
    task.warnings.push_back(
        touches ? "contact with tissue; before: none, so no figure is called better or worse"
                : "no contact with tissue, so no figure is called better or worse; before: some");
  }
  const double longer = std::max(report.active, against.active);
  if (std::abs(report.active - against.active) > kSameLength * longer) {
    task.same_length = false;
    task.warnings.push_back(
        Format("another length: %.1f s; before: %.1f s. Times, paths and counts grow with it, so a "
               "lower one is better only if the task was completed both times",
               report.active, against.active));
  }
  return task;
}

std::string MetricText(const MetricDefinition& metric, double displayed) {
  // The format is from the table of definitions.
  char text[64];
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
  std::snprintf(text, sizeof text, metric.format, displayed);
#pragma GCC diagnostic pop
  return text;
}

MetricDifference CompareMetric(const MetricDefinition& metric, const Json& now, const Json& before,
                               bool may_judge) {
  if (!now.is_number() || !before.is_number()) return {};
  // A difference is that of the numbers that the reader sees.
  const auto displayed = [&metric](const Json& value) {
    return std::strtod(MetricText(metric, metric.scale * value.get<double>()).c_str(), nullptr);
  };
  const double a = displayed(now), b = displayed(before);
  MetricDifference difference;
  difference.value = a - b;
  if (a == b) {
    difference.verdict = MetricDifference::kSame;
  } else if (may_judge && metric.better != Better::kNeither) {
    difference.verdict = (a < b) == (metric.better == Better::kLower) ? MetricDifference::kBetter
                                                                      : MetricDifference::kWorse;
  }
  return difference;
}

const Json* SameHand(const Json& report, const Json& name, std::size_t index) {
  for (const Json& hand : report["hands"]) {
    if (hand["name"] == name) return &hand;
  }
  return index < report["hands"].size() ? &report["hands"][index] : nullptr;
}

Json ComparisonToJson(const SessionReport& report, const SessionReport& against) {
  const TaskComparison task = CompareTasks(report, against);
  const auto [now_name, before_name] = SessionNames(report, against);
  const Json now = ToJson(report), before = ToJson(against);
  Json json = {{"sessions", {now_name, before_name}}, {"warnings", task.warnings}};
  json["hands"] = Json::array();
  for (std::size_t h = 0; h < now["hands"].size(); ++h) {
    const Json& hand = now["hands"][h];
    const Json* other = SameHand(before, hand["name"], h);
    if (other == nullptr) continue;
    Json differences = Json::object();
    for (const MetricDefinition& metric : MetricDefinitions()) {
      const Json &a = hand[metric.key], &b = (*other)[metric.key];
      const MetricDifference difference = CompareMetric(metric, a, b, task.MayJudge());
      if (!difference.value) continue;
      const char* verdict = VerdictName(difference.verdict);
      differences[metric.key] = {{"difference", a.get<double>() - b.get<double>()},
                                 {"verdict", verdict != nullptr ? Json(verdict) : Json(nullptr)}};
    }
    json["hands"].push_back({{"name", hand["name"]},
                             {"against", (*other)["name"]},
                             {"differences", std::move(differences)}});
  }
  return json;
}

}  // namespace hpdm
