#include "tools/report/page/report_page.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

#include "tools/report/metrics/goals.h"
#include "tools/report/metrics/metric_definitions.h"
#include "tools/report/metrics/report_json.h"
#include "tools/report/metrics/verdicts.h"
#include "tools/report/page/figures_table.h"
#include "tools/report/page/html_text.h"
#include "tools/report/page/page_data.h"
#include "tools/shared/json_text.h"
#include "tools/shared/report_text.h"
#include "tools/web/web_pages.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxEventRows = 200;

std::string Panel(const std::string& id, const std::string& heading, const std::string& body,
                  const std::string& further_class = "") {
  return "<section class=\"panel" + further_class + "\" id=\"" + id + "\">\n<h2>" + heading +
         "</h2>\n" + body + "</section>\n";
}

std::string AttachmentTable(const SessionReport& report) {
  std::string html =
      "<div class=\"wide\"><table><thead><tr><th>Attachment of</th>"
      "<th class=\"number\">peak load, N</th><th class=\"number\">largest damage</th>"
      "<th class=\"number\">freed, cm\u00b2</th><th class=\"number\">of it burnt</th>"
      "<th class=\"number\">cut</th><th class=\"number\">torn with, mJ</th>"
      "</tr></thead><tbody>\n";
  for (const AttachmentReport& attachment : report.attachments) {
    html += "<tr><th scope=\"row\">" + EscapeHtml(attachment.name) + "</th>";
    for (const std::string& value :
         {Format("%.2f", attachment.peak_load), Format("%.2f", attachment.largest_damage),
          Format("%.2f", 1e4 * attachment.freed_area), Format("%.2f", 1e4 * attachment.burnt_area),
          Format("%.2f", 1e4 * attachment.cut_area), Format("%.2f", 1e3 * attachment.dissipated)}) {
      html += "<td class=\"number\">" + value + "</td>";
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

// The outcome, the times of the steps, the errors, and how the score is made.
std::string ExercisePanel(const SessionReport& report) {
  const ExerciseOptions& options = report.exercise->options;
  const ExerciseResult& result = report.exercise->result;
  std::string html;
  if (!options.goal.empty()) html += "<p>" + EscapeHtml(options.goal) + "</p>\n";
  const char* outcome = result.passed  ? "All steps were done"
                        : result.ended ? "The time was over"
                                       : "The session ended before the exercise";
  html += Format("<p><b>Score %.1f of 100.</b> %s after %.1f s of %.0f s, with %zu %s.</p>\n",
                 result.score, outcome, result.time, options.time_limit, result.errors.size(),
                 result.errors.size() == 1 ? "error" : "errors");
  if (result.stood > 0) {
    html += Format("<p>The time stood for %.1f s, while no device was read: pauses.</p>\n",
                   result.stood);
  }
  for (const ExerciseRestart& restart : result.restarts) {
    html += "<p>\"" + EscapeHtml(options.steps[ToSize(restart.step)].name) +
            Format("\" began again: %.1f s and %d %s before do not count.</p>\n", restart.discarded,
                   restart.errors, restart.errors == 1 ? "error" : "errors");
  }
  html +=
      "<div class=\"wide\"><table><thead><tr><th>Step</th><th class=\"number\">done after, s</th>"
      "<th class=\"number\">took, s</th></tr></thead><tbody>\n";
  for (std::size_t s = 0; s < options.steps.size(); ++s) {
    const bool done = s < result.step_times.size();
    const double before = s == 0 || !done ? 0 : result.step_times[s - 1];
    html += "<tr><th scope=\"row\">" + EscapeHtml(options.steps[s].name) + "</th>";
    for (const std::string& value :
         {done ? Format("%.1f", result.step_times[s]) : std::string("\u2013"),
          done ? Format("%.1f", result.step_times[s] - before) : std::string("\u2013")}) {
      html += "<td class=\"number\">" + value + "</td>";
    }
    html += "</tr>\n";
  }
  html += "</tbody></table></div>\n";
  if (!result.errors.empty()) {
    html +=
        "<div class=\"wide\"><table><thead><tr><th>Error</th><th class=\"number\">at, s</th>"
        "<th>Instrument</th><th>Organ or duct</th><th class=\"number\">N</th><th>Place, mm</th>"
        "<th class=\"number\">points</th></tr></thead><tbody>\n";
  }
  for (const ExerciseError& error : result.errors) {
    const ExerciseErrorOptions& rule = options.errors[static_cast<std::size_t>(error.rule)];
    const auto name = [](int index, const auto& names, const auto& of) -> std::string {
      const auto at = static_cast<std::size_t>(index);
      return index < 0 || at >= names.size() ? "\u2013" : of(names[at]);
    };
    const std::string faults = FaultText(error.clip, "", false);
    html +=
        "<tr><th scope=\"row\">" + EscapeHtml(rule.name) +
        (faults.empty() ? "" : "<br>" + EscapeHtml(faults)) + "</th>" +
        Format("<td class=\"number\">%.1f</td>", error.time) + "<td>" +
        EscapeHtml(name(error.hand, report.hands,
                        [&](const auto& h) { return h.InstrumentName(error.instrument_index); })) +
        "</td><td>" +
        EscapeHtml(error.duct >= 0
                       ? name(error.duct, options.ducts, [](const auto& d) { return d.name; })
                       : name(error.organ, report.organs, [](const auto& o) { return o; })) +
        "</td>" +
        Format(
            "<td class=\"number\">%.2f</td><td>%.0f, %.0f, %.0f</td>"
            "<td class=\"number\">%g</td></tr>\n",
            error.force, 1e3 * error.place_W.x(), 1e3 * error.place_W.y(), 1e3 * error.place_W.z(),
            -rule.points);
  }
  if (!result.errors.empty()) html += "</tbody></table></div>\n";
  for (const ExerciseBleeding& bleeding : result.bleedings) {
    html += Format("<p>A bleeding that the teacher began at %.1f s lasted %.1f s: %s.</p>\n",
                   bleeding.begin, bleeding.end - bleeding.begin,
                   bleeding.stopped ? "a clip stopped it" : "nothing stopped it");
  }
  return html +
         Format(
             "<p class=\"note\">Steps give up to %g points, the time up to %g: all of them up to "
             "%.0f s, none at %.0f s or with a step left. Errors take theirs off. The score says "
             "how this exercise was done, not how well somebody operates.</p>\n",
             ExerciseEvaluator::kStepPoints, ExerciseEvaluator::kTimePoints, options.target_time,
             options.time_limit);
}

// The domains, each with the figures that it is estimated from.
std::string GoalsPanel(const SessionReport& report) {
  std::string html =
      "<div class=\"wide\"><table id=\"goals-table\" class=\"stacked\"><thead><tr>"
      "<th>Domain, and what it is estimated from</th><th class=\"number\">value</th>"
      "<th class=\"number\">1 at</th><th class=\"number\">5 at</th>"
      "<th class=\"number\">rating, 1 to 5</th></tr></thead><tbody>\n";
  const auto cell = [](const char* label, const std::string& value) {
    return std::string("<td class=\"number\" data-label=\"") + label + "\">" + value + "</td>";
  };
  for (const GoalsDomain& domain : RateGoals(report)) {
    html += std::string("<tr><th scope=\"row\">") + domain.label + "</th><td colspan=\"4\"" +
            (domain.rating ? " class=\"number\"" : "") + " data-key=\"goals." + domain.key + "\">";
    if (!domain.rating) {
      html += "not rated: " + EscapeHtml(domain.why_not) + "</td></tr>\n";
      continue;
    }
    html += Format("<b>%.1f</b></td></tr>\n", *domain.rating);
    for (const GoalsPart& part : domain.parts) {
      const GoalsScale& scale = *part.scale;
      const auto figure = [&scale](double value) {
        return Format("%.3g", scale.scale * value) +
               (*scale.unit == '\0' ? "" : std::string("\u00a0") + scale.unit);
      };
      html += "<tr><td>" + EscapeHtml(scale.label) + "</td>" + cell("value", figure(part.value)) +
              cell("1 at", figure(scale.worst)) + cell("5 at", figure(scale.best)) +
              cell("rating", Format("%.1f", part.rating)) + "</tr>\n";
    }
  }
  return html +
         "</tbody></table></div>\n<p class=\"note\">The domains are those of GOALS, with which an "
         "observer rates an operation from 1 to 5 [Vassiliou 2005]. Here they are estimated from "
         "figures: linear between the values for 1 and for 5; tissue handling is its lowest "
         "figure, efficiency the mean. All these values are guesses of this project, and no study "
         "has compared the estimate with observers. It shows what changed between sessions of one "
         "task; it does "
         "not replace an observer.</p>\n";
}

std::string OrganTable(const SessionReport& report) {
  double longest = 0;
  for (const HandReport& hand : report.hands) {
    for (const ContactMetrics& organ : hand.by_organ) longest = std::max(longest, organ.time);
  }
  if (longest == 0) return "<p>No tissue was touched.</p>\n";
  std::string html =
      "<div class=\"wide\"><table class=\"stacked\"><thead><tr><th>Organ</th><th>Hand</th>"
      "<th>Contact</th><th class=\"number\">s</th><th class=\"number\">contacts</th>"
      "<th class=\"number\">peak N</th><th class=\"number\">mean N</th>"
      "<th class=\"number\">s above limit</th><th class=\"number\">deepest mm</th>"
      "<th class=\"number\">s too deep</th></tr></thead>"
      "<tbody>\n";
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
      const auto cell = [&html](const char* label, const std::string& value) {
        html += std::string("<td class=\"number\" data-label=\"") + label + "\">" + value + "</td>";
      };
      cell("contact, s", Format("%.1f", contact.time));
      cell("contacts", std::to_string(contact.count));
      cell("peak force, N", Format("%.2f", contact.peak_force));
      cell("mean force, N", Format("%.2f", contact.mean_force));
      cell("above the force limit, s", Format("%.2f", contact.over_limit));
      cell("deepest press, mm", Format("%.1f", 1000 * contact.deepest_press));
      cell("deeper than the limit, s", Format("%.2f", contact.over_depth));
      html += "</tr>\n";
    }
  }
  return html + "</tbody></table></div>\n";
}

/// Returns a picture's caption: for a screenshot with its time, if the log has it.
std::string Caption(const SessionPicture& picture, const SessionReport& report) {
  for (const SessionEvent& event : report.events) {
    if (event.name != "render.screenshot" || picture.name != "screenshots/" + event.text) continue;
    return picture.caption + ", at " + LengthText(event.time);
  }
  return picture.caption;
}

std::string Pictures(const SessionFiles& files, const SessionReport& report) {
  if (files.pictures.empty()) return "";
  std::string html = "<div class=\"pictures\">\n";
  for (const SessionPicture& picture : files.pictures) {
    const std::string caption = EscapeHtml(Caption(picture, report));
    html += "<figure><img alt=\"" + caption + "\" src=\"" + picture.data_uri + "\"><figcaption>" +
            caption + "</figcaption></figure>\n";
  }
  return Panel("pictures", "What the laparoscope saw", html + "</div>\n");
}

/// Returns one line: the haptic ticks that ran and were skipped.
std::string TickCounts(const SessionReport& report) {
  const double periods = static_cast<double>(report.ticks) + report.skipped.Total();
  return WithCommas(static_cast<long long>(report.ticks)) + " haptic ticks ran, " +
         Format("%s were skipped (%.3f %%)", WithCommas(report.skipped.Total()).c_str(),
                100 * report.skipped.Total() / std::max(periods, 1.0));
}

std::string LatencyTable(const SessionReport& report) {
  const SkippedTicks& skipped = report.skipped;
  std::string html = Format(
      "<p>Skipped: %u because of late wake-ups, %u because of long computing, %u because of CPU "
      "steal.",
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

std::string Definitions(const SessionReport& report) {
  std::string html = "<dl>\n";
  for (const MetricDefinition& metric : MetricDefinitions()) {
    html += std::string("<dt id=\"def-") + metric.key + "\">" + metric.label +
            (*metric.unit != '\0' ? std::string(" (") + metric.unit + ")" : "") + "</dt><dd>" +
            EscapeHtml(MeaningOf(metric, report)) +
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
      "The trainer sets the depth limit too (<code>--depth-limit</code>, in m). Its default of " +
      DepthLimitText(kDefaultDepthLimit) +
      " is our own. "
      "Movements and force rates are measured on 5\u00a0ms means smoothed at 10\u00a0Hz without "
      "delay; forces, contacts and depths on every haptic tick that has them in the log. None of "
      "these figures alone "
      "measures skill: compare sessions of the same task.</p>\n<ul>\n";
  for (const MetricSource& source : MetricSources()) {
    html += std::string("<li><b>") + source.key + "</b>: " + EscapeHtml(source.text) + "</li>\n";
  }
  return html + "</ul>\n";
}

std::string Header(const SessionReport& report, const SessionFiles& files) {
  std::string facts = LengthText(report.duration);
  if (report.paused > 0) facts += " (" + LengthText(report.paused) + " of it paused)";
  facts += report.hands.empty() ? ", no instrument" : ", ";
  for (std::size_t h = 0; h < report.hands.size(); ++h) {
    facts += (h > 0 ? " and " : "") + EscapeHtml(report.hands[h].Label());
  }
  if (report.left_handed) facts += ", left-handed: their ports exchanged";
  std::string html = "<header><h1>" + EscapeHtml(report.scene.empty() ? "Session" : report.scene) +
                     "</h1>\n<p class=\"muted\">" + StartText(report) + " \u00b7 " + facts +
                     " \u00b7 " +
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
  if (files.screenshots_left_out > 0) {
    gaps.push_back(std::to_string(files.screenshots_left_out) +
                   " of the screenshots, which would make this page too large: see screenshots/");
  }
  for (const std::string& name : files.missing) gaps.push_back("the folder has no " + name);
  if (report.organs.empty()) gaps.emplace_back("the organs' meshes");
  gaps.insert(gaps.end(), reading.series.organs_missing.begin(),
              reading.series.organs_missing.end());
  if (report.output_interval > 1) {
    gaps.push_back(
        Format("most forces: the log has one in %d ticks (--log-rate). Contacts and peaks are "
               "exact; means, impulses, rates, and times above a limit are not",
               report.output_interval));
  }
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
  std::string body = Header(report, files);
  if (report.exercise) {
    body += Panel("exercise", "Exercise: " + EscapeHtml(report.exercise->options.name),
                  ExercisePanel(report));
  }
  body += Panel("goals", "GOALS domains, estimated", GoalsPanel(report));
  std::string metrics =
      against == nullptr ? FiguresTable(report) : ComparedFigures(report, *against);
  if (report.both_moving) {
    metrics += Format("<p>Both hands moved at once for %.1f s.</p>\n", *report.both_moving);
  }
  body += Panel("figures", "Figures", metrics, against == nullptr ? "" : " compared");
  body +=
      Panel("timeline", "Force and depth over time",
            "<noscript><p class=\"note\">The curves and the path need JavaScript; the tables do "
            "not.</p></noscript>\n<div id=\"curves\"></div>\n");
  body += Panel("path", "Path of the tips", "<div id=\"view\"></div>\n");
  body += Pictures(files, report);
  body += Panel("organs", "Contact by organ", OrganTable(report));
  if (!report.attachments.empty()) {
    body += Panel("attachments", "Attachments", AttachmentTable(report));
  }
  body += Panel("latency", "Latency",
                "<details><summary>" + TickCounts(report) + "</summary>\n" + LatencyTable(report) +
                    "</details>\n");
  body += Panel("events", "Events", Events(report));
  body += Panel("gaps", "What is missing", Gaps(reading, files));
  body += Panel("definitions", "Definitions and sources", Definitions(report));

  Json data = PageData(reading);
  data["report"] = json;
  data["report"].erase("events");  // they may be many; the page lists the first
  const std::string text =
      EscapeScript(data.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  const std::string title =
      EscapeHtml((report.scene.empty() ? "Session" : report.scene) + " \u2013 HPDM report");

  // Fills the page's placeholders in their order. Inserted text is never searched for placeholders.
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
