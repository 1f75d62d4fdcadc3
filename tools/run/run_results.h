#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "lcmtypes/telemetry/telemetry_loop.h"
#include "render/render_loop.h"
#include "tools/run/run_options.h"
#include "tools/session/session_folder.h"

namespace hpdm {

/// Prints a note, which is no error, on stderr.
void Note(const std::string& note);

/// Writes the results of a finished session into its folder (summary, tables, pictures, plots) and
/// prints them: five lines, --verbose or --json. `program`: how hpdm was called. Throws InputError
/// if the folder is incomplete. Main thread, loops ended.
void FinishRun(const RunOptions& options, const std::string& program,
               const nlohmann::ordered_json& summary, const TelemetrySummary& telemetry_summary,
               const RenderLoop& render, SessionFolder* folder);

}  // namespace hpdm
