#pragma once

#include <string>

#include "tools/report/metrics/metric_definitions.h"
#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// Returns the figures of a session as HTML: one table with a column for each hand.
std::string FiguresTable(const SessionReport& report);

/// Returns the figures beside those of another session as HTML: the names of both, warnings where
/// they are not of the same task, and a table for each hand. A difference is in the figure's own
/// unit, with "better" or "worse" if the sessions had the same scene and instruments.
std::string ComparedFigures(const SessionReport& report, const SessionReport& against);

/// Returns what a figure means, with the session's limits. Plain, not HTML.
std::string MeaningOf(const MetricDefinition& metric, const SessionReport& report);

/// Formats a length: "2:05 min", "12.3 s".
std::string LengthText(double seconds);

/// Formats a session's start: "2026-01-31 12:00:00 UTC", or that it has none.
std::string StartText(const SessionReport& report);

}  // namespace hpdm
