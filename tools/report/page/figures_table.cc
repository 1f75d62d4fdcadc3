#include "tools/report/page/figures_table.h"

#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "tools/report/metrics/report_json.h"
#include "tools/report/metrics/session_comparison.h"
#include "tools/report/metrics/verdicts.h"
#include "tools/report/page/html_text.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kNone = "\u2013";

std::string WithUnit(const std::string& number, const std::string& unit) {
  if (unit.empty()) return number;
  return number + (unit == "\u00b0" ? "" : "\u00a0") + unit;
}

std::string Shown(const MetricDefinition& metric, const Json& value) {
  if (value.is_null()) return kNone;
  return WithUnit(MetricText(metric, metric.scale * value.get<double>()), metric.unit);
}

/// Returns a difference with its sign, and a difference of percentages in points.
std::string Shown(const MetricDefinition& metric, const MetricDifference& difference) {
  if (!difference.value) return kNone;
  const std::string number = MetricText(metric, std::abs(*difference.value));
  const std::string unit = metric.unit == std::string("%") ? "points" : metric.unit;
  if (difference.verdict == MetricDifference::kSame) return WithUnit(number, unit);
  std::string text = WithUnit((*difference.value > 0 ? "+" : "-") + number, unit);
  if (difference.verdict == MetricDifference::kBetter) {
    text += " <span class=\"good\">better</span>";
  } else if (difference.verdict == MetricDifference::kWorse) {
    text += " <span class=\"bad\">worse</span>";
  }
  return text;
}

std::string RowHeading(const MetricDefinition& metric, const SessionReport& report) {
  return std::string("<tr><th scope=\"row\"><a href=\"#def-") + metric.key + "\" title=\"" +
         EscapeHtml(MeaningOf(metric, report)) + "\">" + metric.label + "</a></th>";
}

std::string ValueCell(const MetricDefinition& metric, const Json& value, std::size_t hand) {
  return "<td class=\"number\" data-key=\"hands." + std::to_string(hand) + "." + metric.key +
         "\">" + Shown(metric, value) + "</td>";
}

std::string HandHeading(const std::string& text, std::size_t hand) {
  return "<th class=\"number hand-" + std::to_string(hand % 2) + "\">" + EscapeHtml(text) + "</th>";
}

/// Returns one line about a session: its name, start and length.
std::string SessionLine(const std::string& role, const std::string& name,
                        const SessionReport& report) {
  return "<li>" + role + ": <b>" + EscapeHtml(name) + "</b>, " +
         (report.scene.empty() ? "" : EscapeHtml(report.scene) + ", ") + StartText(report) + ", " +
         LengthText(report.duration) + "</li>\n";
}

}  // namespace

std::string MeaningOf(const MetricDefinition& metric, const SessionReport& report) {
  return Replaced(Replaced(metric.meaning, "%LIMIT%", LimitText(report.force_limit)),
                  "%DEPTH_LIMIT%", DepthLimitText(report.depth_limit));
}

std::string LengthText(double seconds) {
  if (seconds < 99.95) return Format("%.1f s", seconds);
  const long whole = std::lround(seconds);
  return Format("%ld:%02ld min", whole / 60, whole % 60);
}

std::string StartText(const SessionReport& report) {
  const Json start = ToJson(report)["start"];
  return start.is_string() ? Replaced(Replaced(start.get<std::string>(), "T", " "), "Z", " UTC")
                           : "lockstep clock, no date";
}

std::string FiguresTable(const SessionReport& report) {
  const Json json = ToJson(report);
  std::string html = "<div class=\"wide\"><table id=\"metrics\"><thead><tr><th>Figure</th>";
  for (std::size_t h = 0; h < report.hands.size(); ++h) {
    html += HandHeading(report.hands[h].Label(), h);
  }
  html += "</tr></thead><tbody>\n";
  for (const MetricDefinition& metric : MetricDefinitions()) {
    html += RowHeading(metric, report);
    for (std::size_t h = 0; h < report.hands.size(); ++h) {
      html += ValueCell(metric, json["hands"][h][metric.key], h);
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string ComparedFigures(const SessionReport& report, const SessionReport& against) {
  const Json json = ToJson(report), other_json = ToJson(against);
  const auto [name, other_name] = SessionNames(report, against);
  const TaskComparison task = CompareTasks(report, against);
  std::string html = "<ul class=\"sessions\">\n" + SessionLine("This session", name, report) +
                     SessionLine("Compared with", other_name, against) + "</ul>\n";
  if (!task.warnings.empty()) {
    html += "<ul class=\"verdict\" id=\"not-the-same-task\">\n";
    for (const std::string& warning : task.warnings) {
      html += "<li class=\"bad\">" + EscapeHtml(warning) + "</li>\n";
    }
    html += "</ul>\n";
  }
  if (!task.MayJudge()) {
    html += "<p>Not comparable: no difference is called better or worse.</p>\n";
  }
  html += "<div class=\"hands\">\n";
  for (std::size_t h = 0; h < report.hands.size(); ++h) {
    const Json& hand = json["hands"][h];
    const Json* other = SameHand(other_json, hand["name"], h);
    html += "<table class=\"compare\"><thead><tr>" +
            Replaced(HandHeading(report.hands[h].Label(), h), "number ", "") +
            "<th class=\"number\">" + EscapeHtml(name) + "</th><th class=\"number\">" +
            EscapeHtml(other_name);
    if (other != nullptr && (*other)["instruments"] != hand["instruments"]) {
      html += ": " + EscapeHtml((*other)["instruments"].get<std::string>());
    }
    html += "</th><th class=\"number\">change</th></tr></thead><tbody>\n";
    for (const MetricDefinition& metric : MetricDefinitions()) {
      const Json before = other != nullptr ? (*other)[metric.key] : Json();
      html += RowHeading(metric, report) + ValueCell(metric, hand[metric.key], h) +
              "<td class=\"number\">" + Shown(metric, before) +
              "</td><td class=\"number difference\">" +
              Shown(metric, CompareMetric(metric, hand[metric.key], before, task.MayJudge())) +
              "</td></tr>\n";
    }
    html += "</tbody></table>\n";
  }
  return html + "</div>\n";
}

}  // namespace hpdm
