#include "tools/run/run_results.h"

#include <iostream>

#include "engine/base/error.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "tools/plots/plot_latency.h"
#include "tools/plots/plot_timeline.h"
#include "tools/plots/python_plot.h"
#include "tools/run/film.h"
#include "tools/run/latency_table.h"
#include "tools/session/run_summary.h"
#include "tools/shared/json_text.h"

namespace hpdm {

void Note(const std::string& note) { std::cerr << "hpdm: note: " + note + "\n"; }

namespace {

void WritePicture(const Image& image, const SessionFolder& folder, const std::string& name) {
  if (image.width > 0) WritePng(folder.File(name), image);
}

// Writes the results of a finished session. The summary comes first, in case the disk fills up.
// Stores the first failure in `write_error` unless that holds one already.
void WriteResults(const RunOptions& options, const nlohmann::ordered_json& summary,
                  const TelemetrySummary& telemetry_summary, const RenderLoop& render,
                  const SessionFolder& folder, std::string* write_error) {
  const auto keep = [write_error](const auto& write) {
    try {
      write();
    } catch (const InputError& error) {
      if (write_error->empty()) *write_error = error.what();
    }
  };
  const auto note = [](const std::string& name, const std::string& missing) {
    if (!missing.empty()) Note(name + ": " + missing);
  };
  const auto plot = [&](const char* script, const char* table, const char* picture) {
    note(picture, RunPlotScript(script, {folder.File(table), folder.File(picture)}));
  };
  keep([&] { WriteTextFile(folder.File("summary.json"), JsonText(summary) + "\n"); });
  if (!options.Lockstep()) {
    keep([&] {
      WriteTextFile(folder.File("latency.csv"), LatencyTable(telemetry_summary.session.latencies));
    });
  }
  keep([&] { WritePicture(render.deepest_image(), folder, "deepest.png"); });
  keep([&] { WritePicture(render.image(), folder, "last.png"); });
  if (options.film) {
    note("film.mp4",
         render.frames_written() == 0
             ? "not made: no frames were kept"
             : MakeFilm(folder.File("frames"), options.FramesPerSecond(), folder.File("film.mp4")));
  }
  plot(kPlotTimelineScript, "timeline.csv", "timeline.png");
  if (!options.Lockstep()) plot(kPlotLatencyScript, "latency.csv", "latency.png");
}

}  // namespace

void FinishRun(const RunOptions& options, const std::string& program,
               const nlohmann::ordered_json& summary, const TelemetrySummary& telemetry_summary,
               const RenderLoop& render, SessionFolder* folder) {
  std::string write_error = telemetry_summary.log.Explain();
  if (write_error.empty()) write_error = telemetry_summary.timeline_failure;
  if (write_error.empty()) write_error = render.file_failure();
  if (folder->Finish()) {
    WriteResults(options, summary, telemetry_summary, render, *folder, &write_error);
  } else if (write_error.empty()) {
    write_error = "the folder was deleted";
  }
  if (options.json) {
    std::cout << JsonText(summary) << "\n";
  } else {
    if (options.verbose) std::cout << VerboseSummary(summary) << "\n";
    std::cout << BriefSummary(summary, folder->path().string(), program, options.limits);
  }
  if (write_error.empty()) return;
  throw InputError(folder->path().string() + ": incomplete: " + write_error);
}

}  // namespace hpdm
