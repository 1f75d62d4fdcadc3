#include "tools/report/page/report_page.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

#include "tools/report/metrics/metric_definitions.h"
#include "tools/report/metrics/report_json.h"
#include "tools/report/metrics/verdicts.h"
#include "tools/report/page/html_text.h"
#include "tools/report/page/page_data.h"
#include "tools/shared/json_text.h"
#include "tools/shared/report_text.h"
#include "tools/web/web_pages.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxEventRows = 200;
constexpr const char* kNone = "\u2013";

/// "2:05 min", "12.3 s".
std::string Length(double seconds) {
  if (seconds < 99.95) return Format("%.1f s", seconds);
  const long whole = std::lround(seconds);
  return Format("%ld:%02ld min", whole / 60, whole % 60);
}

std::string Shown(const MetricDefinition& metric, const Json& value) {
  if (value.is_null()) return kNone;
  // The format is from the table of definitions.
  char text[64];
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
  std::snprintf(text, sizeof text, metric.format, metric.scale * value.get<double>());
#pragma GCC diagnostic pop
  const std::string unit = metric.unit;
  return text + (unit.empty() ? "" : (unit == "\u00b0" ? "" : "\u00a0") + unit);
}

std::string Meaning(const MetricDefinition& metric, double limit) {
  return Replaced(metric.meaning, "%LIMIT%", LimitText(limit));
}

std::string Panel(const std::string& id, const std::string& heading, const std::string& body,
                  const std::string& further_class = "") {
  return "<section class=\"panel" + further_class + "\" id=\"" + id + "\">\n<h2>" + heading +
         "</h2>\n" + body + "</section>\n";
}

/// Formats the change from `before` to `now`: "+12 %"; empty if it is undefined.
std::string Change(const Json& now, const Json& before) {
  if (now.is_null() || before.is_null() || before.get<double>() == 0) return "";
  const double change = std::round(100 * (now.get<double>() / before.get<double>() - 1));
  return change == 0 ? "0\u00a0%" : Format("%+.0f\u00a0%%", change);
}

const Json* HandOf(const Json& report, const Json& name, std::size_t index) {
  for (const Json& hand : report["hands"]) {
    if (hand["name"] == name) return &hand;
  }
  return index < report["hands"].size() ? &report["hands"][index] : nullptr;
}

std::string MetricsTable(const SessionReport& report, const Json& json, const Json* against) {
  std::string html = "<div class=\"wide\"><table id=\"metrics\"><thead><tr><th>Figure</th>";
  std::vector<const Json*> others;
  for (std::size_t h = 0; h < report.hands.size(); ++h) {
    const Json& hand = json["hands"][h];
    html += "<th class=\"number hand-" + std::to_string(h % 2) + "\">" +
            EscapeHtml(report.hands[h].Label()) + "</th>";
    others.push_back(against == nullptr ? nullptr : HandOf(*against, hand["name"], h));
    if (others.back() != nullptr) {
      html += "<th class=\"number\">compared with</th><th class=\"number\">change</th>";
    }
  }
  html += "</tr></thead><tbody>\n";
  for (const MetricDefinition& metric : MetricDefinitions()) {
    html += std::string("<tr><th scope=\"row\"><a href=\"#def-") + metric.key + "\" title=\"" +
            EscapeHtml(Meaning(metric, report.force_limit)) + "\">" + metric.label + "</a></th>";
    for (std::size_t h = 0; h < report.hands.size(); ++h) {
      const Json& value = json["hands"][h][metric.key];
      html += "<td class=\"number\" data-key=\"hands." + std::to_string(h) + "." + metric.key +
              "\">" + Shown(metric, value) + "</td>";
      if (others[h] == nullptr) continue;
      const Json& other = (*others[h])[metric.key];
      html += "<td class=\"number\">" + Shown(metric, other) + "</td><td class=\"number\">" +
              Change(value, other) + "</td>";
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string OrganTable(const SessionReport& report) {
  double longest = 0;
  for (const HandReport& hand : report.hands) {
    for (const ContactMetrics& organ : hand.by_organ) longest = std::max(longest, organ.time);
  }
  if (longest == 0) return "<p>No tissue was touched.</p>\n";
  std::string html =
      "<div class=\"wide\"><table><thead><tr><th>Organ</th><th>Hand</th><th>Contact</th>"
      "<th class=\"number\">s</th><th class=\"number\">contacts</th><th class=\"number\">peak "
      "N</th>"
      "<th class=\"number\">mean N</th><th class=\"number\">s above limit</th>"
      "<th class=\"number\">deepest mm</th></tr></thead><tbody>\n";
  for (std::size_t o = 0; o < report.organs.size(); ++o) {
    for (std::size_t h = 0; h < report.hands.size(); ++h) {
      const ContactMetrics& contact = report.hands[h].by_organ[o];
      if (contact.count == 0) continue;
      html += "<tr><th scope=\"row\">" + EscapeHtml(report.organs[o]) + "</th><td>" +
              EscapeHtml(report.hands[h].Label()) +
              Format(
                  "</td><td class=\"bars\"><span class=\"bar back-%zu\" style=\"width:%.1f%%\">"
                  "</span></td>",
                  h % 2, 100 * contact.time / longest);
      html += Format(
          "<td class=\"number\">%.1f</td><td class=\"number\">%llu</td>"
          "<td class=\"number\">%.2f</td><td class=\"number\">%.2f</td>"
          "<td class=\"number\">%.2f</td><td class=\"number\">%.1f</td></tr>\n",
          contact.time, static_cast<unsigned long long>(contact.count), contact.peak_force,
          contact.mean_force, contact.over_limit, 1000 * contact.deepest_press);
    }
  }
  return html + "</tbody></table></div>\n";
}

std::string Pictures(const SessionFiles& files) {
  if (files.pictures.empty()) return "";
  std::string html = "<div class=\"pictures\">\n";
  for (const SessionPicture& picture : files.pictures) {
    const std::string caption = EscapeHtml(picture.caption);
    html += "<figure><img alt=\"" + caption + "\" src=\"" + picture.data_uri + "\"><figcaption>" +
            caption + "</figcaption></figure>\n";
  }
  return Panel("pictures", "What the laparoscope saw", html + "</div>\n");
}

std::string LatencyTable(const SessionReport& report) {
  std::string html;
  const SkippedTicks& skipped = report.skipped;
  const double periods = static_cast<double>(report.ticks) + skipped.Total();
  html += "<p>" + WithCommas(static_cast<long long>(report.ticks)) + " haptic ticks ran; " +
          Format(
              "%s were skipped (%.3f %%): %u because of late wake-ups, %u because of long "
              "computing, %u because of CPU steal.",
              WithCommas(skipped.Total()).c_str(), 100 * skipped.Total() / periods,
              skipped.late_wake_up, skipped.long_compute, skipped.stalled);
  if (report.stolen > 0) {
    html += Format(" CPU steal: %.2f s.", report.stolen);
  }
  if (report.steps_shed > 0) {
    html += Format(" %s deformation steps had reduced quality for lack of time.",
                   WithCommas(report.steps_shed).c_str());
  }
  html += "</p>\n";
  if (!report.measured) {
    return html +
           "<p class=\"note\">This session ran on the lockstep clock, whose time is virtual: there "
           "are no latencies.</p>\n";
  }
  html +=
      "<div class=\"wide\"><table><thead><tr><th>Duration</th><th class=\"number\">count</th>"
      "<th class=\"number\">median</th><th class=\"number\">p90</th><th class=\"number\">p99</th>"
      "<th class=\"number\">p99.9</th><th class=\"number\">max</th></tr></thead><tbody>\n";
  bool any = false;
  for (const LatencyReport& latency : report.latencies) {
    if (latency.count == 0) continue;
    any = true;
    html += "<tr><th scope=\"row\">" +
            Replaced(Replaced(std::string(latency.name), ".", ": "), "_", " ") +
            "</th><td class=\"number\">" + WithCommas(static_cast<long long>(latency.count)) +
            "</td>";
    for (const Nanoseconds time :
         {latency.p50, latency.p90, latency.p99, latency.p99_9, latency.max}) {
      html += "<td class=\"number\">" +
              Replaced(Duration(static_cast<double>(time) / 1000), " us", " \u00b5s") + "</td>";
    }
    html += "</tr>\n";
  }
  if (!any) return html + "</tbody></table></div><p>The log contains no latencies.</p>\n";
  return html + "</tbody></table></div>\n<div id=\"histograms\"></div>\n";
}

std::string Events(const SessionReport& report) {
  if (report.events.empty()) return "<p>The log contains no events.</p>\n";
  std::string html =
      "<div class=\"wide\"><table><thead><tr><th "
      "class=\"number\">s</th><th>Event</th><th></th></tr>"
      "</thead><tbody>\n";
  for (std::size_t i = 0; i < std::min(report.events.size(), kMaxEventRows); ++i) {
    const SessionEvent& event = report.events[i];
    const char* severity = event.severity == EventSeverity::kError     ? "bad"
                           : event.severity == EventSeverity::kWarning ? "warn"
                                                                       : "info";
    html += Format("<tr class=\"%s\"><td class=\"number\">%.2f</td><td>", severity, event.time) +
            EscapeHtml(event.name) + "</td><td>" + EscapeHtml(event.text) + "</td></tr>\n";
  }
  html += "</tbody></table></div>\n";
  if (report.events.size() > kMaxEventRows) {
    html += "<p class=\"note\">" +
            WithCommas(static_cast<long long>(report.events.size() - kMaxEventRows)) +
            " more are in the log.</p>\n";
  }
  return html;
}

std::string Definitions(double limit) {
  std::string html = "<dl>\n";
  for (const MetricDefinition& metric : MetricDefinitions()) {
    html += std::string("<dt id=\"def-") + metric.key + "\">" + metric.label +
            (*metric.unit != '\0' ? std::string(" (") + metric.unit + ")" : "") + "</dt><dd>" +
            EscapeHtml(Meaning(metric, limit)) +
            (*metric.source != '\0' ? std::string(" <cite>[") + metric.source + "]</cite>" : "") +
            "</dd>\n";
  }
  html +=
      "</dl>\n<p>The trainer sets the force limit (<code>--force-limit</code>). The default is " +
      LimitText(kDefaultForceLimit) +
      ", one standard deviation (0.4\u00a0N) above the largest force of experts (2.6\u00a0N) in a "
      "suturing task; novices reached 4.7\u00a0N [Horeman 2010]. The largest acceptable pull on a "
      "suture was 1.25\u00a0N in porcine fallopian tube and 11.4\u00a0N in fascia [Rodrigues "
      "2012]. "
      "Movements and force rates are measured on 5\u00a0ms means smoothed at 10\u00a0Hz without "
      "delay; forces, contacts and depths on every haptic tick. None of these figures alone "
      "measures skill: compare sessions of the same task.</p>\n<ul>\n";
  for (const MetricSource& source : MetricSources()) {
    html += std::string("<li><b>") + source.key + "</b>: " + EscapeHtml(source.text) + "</li>\n";
  }
  return html + "</ul>\n";
}

std::string Header(const SessionReport& report, const SessionFiles& files, const Json& json) {
  std::string facts = Length(report.duration);
  if (report.paused > 0) facts += " (" + Length(report.paused) + " of it paused)";
  facts += report.hands.empty() ? ", no instrument" : ", ";
  for (std::size_t h = 0; h < report.hands.size(); ++h) {
    facts += (h > 0 ? " and " : "") + EscapeHtml(report.hands[h].Label());
  }
  const std::string start =
      json["start"].is_string()
          ? Replaced(Replaced(json["start"].get<std::string>(), "T", " "), "Z", " UTC")
          : "lockstep clock, no date";
  std::string html = "<header><h1>" + EscapeHtml(report.scene.empty() ? "Session" : report.scene) +
                     "</h1>\n<p class=\"muted\">" + start + " \u00b7 " + facts + " \u00b7 " +
                     EscapeHtml((files.folder.empty() ? files.log : files.folder).string()) +
                     "</p>\n<ul class=\"verdict\">\n";
  for (const Verdict& verdict : Verdicts(report)) {
    constexpr const char* kClasses[] = {"good", "bad", "open"};
    html += std::string("<li class=\"") + kClasses[static_cast<int>(verdict.kind)] + "\">" +
            EscapeHtml(verdict.text) + "</li>\n";
  }
  return html + "</ul></header>\n";
}

std::string Gaps(const SessionReading& reading, const SessionFiles& files) {
  const SessionReport& report = reading.report;
  std::vector<std::string> gaps = report.health.Faults();
  if (files.folder.empty()) {
    gaps.emplace_back(
        "the scene's name and the pictures, which are in a session's folder and not in its log");
  }
  for (const std::string& name : files.missing) gaps.push_back("the folder has no " + name);
  if (report.organs.empty()) gaps.emplace_back("the organs' meshes");
  gaps.insert(gaps.end(), reading.series.organs_missing.begin(),
              reading.series.organs_missing.end());
  if (report.duration - report.active - report.paused > 1e-6) {
    gaps.push_back(Format("%.2f s of ticks that ran but are not in the log; they do not count here",
                          report.duration - report.active - report.paused));
  }
  if (gaps.empty()) return "<p>Nothing.</p>\n";
  std::string html = "<ul>\n";
  for (const std::string& gap : gaps) html += "<li>" + EscapeHtml(gap) + "</li>\n";
  return html + "</ul>\n";
}

}  // namespace

std::string ReportPageText(const SessionReading& reading, const SessionFiles& files,
                           const SessionReport* against) {
  const SessionReport& report = reading.report;
  const Json json = ToJson(report);
  Json other;
  if (against != nullptr) other = ToJson(*against);
  std::string body = Header(report, files, json);
  std::string metrics = MetricsTable(report, json, against == nullptr ? nullptr : &other);
  if (report.both_moving) {
    metrics += Format("<p>Both hands moved at once for %.1f s.</p>\n", *report.both_moving);
  }
  if (against != nullptr) {
    metrics += "<p>Compared with " + EscapeHtml(against->log) + ".</p>\n";
  }
  body += Panel("figures", "Figures", metrics, against == nullptr ? "" : " compared");
  body +=
      Panel("timeline", "Force and depth over time",
            "<noscript><p class=\"note\">The curves and the path need JavaScript; the tables do "
            "not.</p></noscript>\n<div id=\"curves\"></div>\n");
  body += Panel("path", "Path of the tips", "<div id=\"view\"></div>\n");
  body += Pictures(files);
  body += Panel("organs", "Contact by organ", OrganTable(report));
  body += Panel("latency", "Latency", LatencyTable(report));
  body += Panel("events", "Events", Events(report));
  body += Panel("gaps", "What is missing", Gaps(reading, files));
  body += Panel("definitions", "Definitions and sources", Definitions(report.force_limit));

  Json data = PageData(reading);
  data["report"] = json;
  data["report"].erase("events");  // they may be many; the page lists the first
  const std::string text =
      EscapeScript(data.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  const std::string title =
      EscapeHtml((report.scene.empty() ? "Session" : report.scene) + " \u2013 HPDM report");

  // Fills the places of the page in their order. Inserted text is never searched for places.
  std::string_view rest = ReportPage();
  std::string page;
  page.reserve(rest.size() + body.size() + text.size() + title.size());
  for (const auto& [place, with] :
       {std::pair<std::string_view, const std::string&>{"<!-- title -->", title},
        {"<!-- body -->", body},
        {"/*data*/", text}}) {
    const std::size_t at = rest.find(place);
    page += rest.substr(0, at);
    page += with;
    rest.remove_prefix(at + place.size());
  }
  page += rest;
  return page;
}

}  // namespace hpdm
