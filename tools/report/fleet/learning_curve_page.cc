#include "tools/report/fleet/learning_curve_page.h"

#include <algorithm>
#include <cmath>

#include "tools/report/page/html_text.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

// The colours of tools/web/src/page.css.
constexpr const char* kHead = R"(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Learning curves - HPDM</title>
<style>
:root { color-scheme: light dark; font: 15px/1.45 system-ui, sans-serif; --ground: #f4f5f7; --panel: #fff;
  --text: #1b2026; --muted: #5a6570; --line: #d5dae0; --value: #0068a8; --fit: #c2500a; }
@media (prefers-color-scheme: dark) { :root { --ground: #14171b; --panel: #1d2228; --text: #e8ebee;
  --muted: #9aa5b1; --line: #363e47; --value: #5cb8f0; --fit: #f39a4a; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1200px; padding: 0.75rem 1rem 2rem; background: var(--ground); color: var(--text); }
h1 { font-size: 1.5rem; }
section { background: var(--panel); border: 1px solid var(--line); border-radius: 8px; padding: 0.7rem 0.8rem; margin-bottom: 0.8rem; }
h2 { font-size: 1.1rem; margin: 0 0 0.4rem; overflow-wrap: anywhere; }
h3 { font-size: 0.9rem; margin: 0; }
.charts { display: grid; gap: 0.8rem; grid-template-columns: repeat(auto-fill, minmax(min(100%, 320px), 1fr)); }
svg { width: 100%; height: auto; display: block; }
svg text { fill: var(--muted); font-size: 11px; }
.axis { stroke: var(--line); } .way { stroke: var(--value); fill: none; stroke-width: 1.5; }
circle { fill: var(--value); } .fit { stroke: var(--fit); fill: none; stroke-width: 2; stroke-dasharray: 6 4; }
.wide { overflow-x: auto; } table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin-top: 0.8rem; }
th { text-align: left; color: var(--muted); } td, th { padding: 0.12rem 0.6rem 0.12rem 0; vertical-align: bottom; }
td.number, th.number { text-align: right; } .note { color: var(--muted); font-style: italic; }
</style>
</head>
<body>
<h1>Learning curves</h1>
)";

constexpr double kWidth = 360, kHeight = 170, kLeft = 44, kRight = 10, kTop = 10, kBottom = 26;

/// Returns the smallest 1, 2 or 5 times a power of ten that is at least `value`.
double RoundUp(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (step * power >= value * (1 - 1e-9)) return step * power;
  }
  return 10 * power;
}

std::string Chart(const LearningSeries& series) {
  const auto count = static_cast<double>(series.values.size());
  double most = 0;
  for (const auto& value : series.values) most = std::max(most, value.value_or(0));
  const bool rating = series.unit == "1 to 5";
  const double low = rating ? 1 : 0, high = rating ? 5 : most > 0 ? RoundUp(most) : 1;
  const auto x = [&](double n) { return kLeft + (n - 0.5) / count * (kWidth - kLeft - kRight); };
  const auto y = [&](double value) {
    return kHeight - kBottom -
           std::clamp((value - low) / (high - low), 0.0, 1.0) * (kHeight - kTop - kBottom);
  };
  std::string svg =
      Format("<svg viewBox=\"0 0 %g %g\" role=\"img\" aria-label=\"", kWidth, kHeight) +
      series.label + " over the sessions\">\n";
  for (const double value : {low, (low + high) / 2, high}) {
    svg += Format("<line class=\"axis\" x1=\"%g\" x2=\"%g\" y1=\"%.1f\" y2=\"%.1f\"/>", kLeft,
                  kWidth - kRight, y(value), y(value)) +
           Format("<text x=\"%g\" y=\"%.1f\" text-anchor=\"end\">%.3g</text>\n", kLeft - 5,
                  y(value) + 4, value);
  }
  svg += Format("<text x=\"%.1f\" y=\"%g\" text-anchor=\"middle\">1</text>", x(1), kHeight - 10);
  if (count > 1) {
    svg += Format("<text x=\"%.1f\" y=\"%g\" text-anchor=\"middle\">%g</text>", x(count),
                  kHeight - 10, count);
  }
  svg += Format("<text x=\"%.1f\" y=\"%g\" text-anchor=\"middle\">session</text>\n",
                (kLeft + kWidth - kRight) / 2, kHeight - 4);
  std::string way, dots;
  for (std::size_t i = 0; i < series.values.size(); ++i) {
    if (!series.values[i]) continue;
    const double at = x(static_cast<double>(i + 1)), value = *series.values[i];
    way += Format("%.1f,%.1f ", at, y(value));
    dots += Format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.5\" data-value=\"%.6g\"/>", at, y(value),
                   value);
  }
  svg += "<polyline class=\"way\" points=\"" + way + "\"/>\n" + dots + "\n";
  if (series.fit) {
    std::string points;
    for (int i = 0; i <= 60; ++i) {
      const double n = 1 + (count - 1) * i / 60;
      points += Format("%.1f,%.1f ", x(n), y(series.fit->plateau - series.fit->drop / n));
    }
    svg += "<polyline class=\"fit\" points=\"" + points + "\"/>\n";
  }
  return svg + "</svg>\n";
}

std::string FitText(const LearningFit& fit) {
  if (!fit.sessions_to_90) return "<p class=\"note\">No rise to a plateau.</p>\n";
  return Format("<p>Plateau %.3g, 90 %% of it from session %.0f on (R\u00b2 %.2f).</p>\n",
                fit.plateau, std::max(1.0, std::ceil(*fit.sessions_to_90)), fit.explained);
}

std::string Heading(const LearningSeries& series) {
  return EscapeHtml(series.label) + (series.unit.empty() ? "" : ", " + EscapeHtml(series.unit));
}

std::string Section(const LearningCurve& curve) {
  std::string html = "<section>\n<h2>" + EscapeHtml(curve.task) +
                     Format(": %zu session%s</h2>\n<div class=\"charts\">\n", curve.names.size(),
                            curve.names.size() == 1 ? "" : "s");
  for (const LearningSeries& series : curve.series) {
    html += "<div data-series=\"" + series.key + "\"><h3>" + Heading(series) + "</h3>\n" +
            Chart(series) + (series.fit ? FitText(*series.fit) : "") + "</div>\n";
  }
  html +=
      "</div>\n<div class=\"wide\"><table><thead><tr><th></th><th>Session</th><th>Start, UTC</th>";
  for (const LearningSeries& series : curve.series) {
    html += "<th class=\"number\">" + Heading(series) + "</th>";
  }
  html += "</tr></thead><tbody>\n";
  for (std::size_t i = 0; i < curve.names.size(); ++i) {
    html += Format("<tr><td class=\"number\">%zu</td><td>", i + 1) + EscapeHtml(curve.names[i]) +
            "</td><td>" + EscapeHtml(Replaced(Replaced(curve.starts[i], "T", " "), "Z", "")) +
            "</td>";
    for (const LearningSeries& series : curve.series) {
      html += "<td class=\"number\">" +
              (series.values[i] ? Format("%.3g", *series.values[i]) : "\u2013") + "</td>";
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n</section>\n";
}

}  // namespace

std::string LearningCurvePage(std::span<const LearningCurve> curves) {
  std::string html = kHead;
  if (curves.empty()) html += "<p>No session with a report and a scene's name was found.</p>\n";
  for (const LearningCurve& curve : curves) html += Section(curve);
  return html +
         Format(
             "<p class=\"note\">With %zu sessions or more, figures that rise with learning have "
             "the fit "
             "plateau \u2212 b / session, dashed: the learning plateau, and the number of "
             "sessions to 90 %% of it (",
             kFewestForFit) +
         "L. S. Feldman, J. Cao, A. Andalib, S. Fraser, G. M. Fried: A method to characterize the "
         "learning "
         "curve for performance of a fundamental laparoscopic simulator task. Surgery 146 (2009), "
         "381-386). "
         "Sessions without a clock stand in the order in which their logs were written. The GOALS "
         "domains "
         "are estimates, whose thresholds are guesses "
         "(tools/report/README.md).</p>\n</body>\n</html>\n";
}

}  // namespace hpdm
