#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/replay/log_replay.h"
#include "tools/replay/realtime_replay.h"
#include "tools/replay/replay_film.h"
#include "tools/replay/replay_report.h"
#include "tools/replay/replay_view.h"
#include "tools/replay/replay_window.h"
#include "tools/session/device_choice.h"
#include "tools/session/lockstep.h"
#include "tools/session/picture_options.h"
#include "tools/session/session_path.h"
#include "tools/session/session_scene.h"
#include "tools/shared/json_text.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct ReplayOptions {
  std::string log;
  std::string scene;  // empty: beside the log
  std::string clock = "logged";
  double tolerance = 1e-9;
  bool json = false;
  std::string film;  // empty: none
  bool window = false;
  double frames_per_second = 30;
  ReplayViewOptions view;
  bool view_given = false;  // an option of the view is on the command line

  bool Shows() const { return window || !film.empty(); }
};

constexpr int kInterrupted = 130;  // exit code, as of a program that SIGINT ends

Scene SceneOf(const ReplayOptions& options, const std::string& log) {
  if (!options.scene.empty()) return LoadScene(options.scene);
  const fs::path beside = SceneBeside(log);
  std::error_code ignored;
  if (!fs::exists(beside, ignored)) {
    throw InputError(log + ": no scene.toml beside it; give the log's scene with --scene SCENE");
  }
  try {
    return LoadRecordedScene(beside);
  } catch (const InputError& error) {
    throw InputError(std::string(error.what()) + "; or give the log's own scene with --scene");
  }
}

void Print(const ReplayOptions& options, const Json& report, const std::string& text) {
  std::cout << (options.json ? JsonText(report) + "\n" : text);
}

// Plays a trace on the lockstep clock, without log and pictures.
Json PlayInLockstep(const std::string& trace, std::uint64_t ticks, Session* session) {
  HapticLoop haptics(session->HapticInstruments(), session->haptic_period_ns(),
                     {session->tool_states, session->patches, session->samples});
  DeformationLoop deformation(
      session->organs(), session->DeformationTools(),
      {session->tool_states, session->patches, *session->render_scenes, *session->telemetry_scenes},
      nullptr, 0, session->scene().attachments, session->scene().ducts);
  Lockstep clock(session->scene().timing, &haptics, &deformation);
  SessionStatistics statistics(session->haptic_period_ns());
  std::uint64_t steps = 0;
  session->EnableForces(true);
  while (clock.tick() < ticks) {
    steps += clock.StepIfDue();
    clock.Tick();
    HapticSample sample;
    session->samples.Pop(&sample);
    statistics.Add(sample);
  }
  return {{"trace", trace},      {"scene", session->scene().path.string()},
          {"clock", "lockstep"}, {"ticks", ticks},
          {"steps", steps},      {"tools", FeltToJson(*session, statistics.Summary())}};
}

// Plays a recorded motion (haptics/device/trace_file.h) on a scene.
void ReplayTrace(const ReplayOptions& options) {
  if (options.scene.empty()) {
    throw InputError(options.log + ": a motion needs a scene; add --scene SCENE");
  }
  const Scene scene = LoadScene(options.scene);
  Session session(scene, ChooseDevices({"trace:" + options.log}, scene.instruments));
  for (const std::string& remark : session.remarks())
    std::cerr << "hpdm: note: " << OneLine(remark) << "\n";
  const auto ticks =
      static_cast<std::uint64_t>(session.trace_length() / session.haptic_period_ns()) + 1;
  if (options.clock == "real") {
    const Json report =
        RealtimeReplayReport(options.log, session, PlayInRealTime(ticks, &session), false);
    return Print(options, report, RealtimeText(report));
  }
  const Json report = PlayInLockstep(options.log, ticks, &session);
  Print(options, report,
        Format("%ld ticks and %ld deformation steps in lockstep\n", report["ticks"].get<long>(),
               report["steps"].get<long>()) +
            ToolLines(report));
}

// Replays the log and compares, while the window shows it or the film takes it. Returns the number
// of the film's frames.
std::uint64_t ReplayAndShow(const ReplayOptions& options, const LoggedSession& log,
                            const std::optional<StopSignals>& signals,
                            const std::optional<FilmFolder>& folder, Session* session,
                            LogReplay* replay) {
  RequireSameScene(log, *session);
  if (options.window) {
    ReplayWindow window(options.view, *signals, session);
    *replay = ReplayLog(log, options.tolerance, session, &window);
    if (!replay->stopped) window.StayOpen();
    if (window.screenshots() > 0) {
      std::cerr << "hpdm: " << window.screenshots() << " screenshots in "
                << window.screenshot_folder().string() << "\n";
    }
  } else if (folder) {
    const Nanoseconds end = log.steps().empty() ? 0 : log.steps().back().sample.step.time_ns;
    ReplayFilm film(options.view, *folder, options.frames_per_second, end, *signals, session);
    *replay = ReplayLog(log, options.tolerance, session, &film);
    if (replay->stopped) {
      std::cerr << "hpdm: " << options.film << ": not made: interrupted\n";
      throw CheckFailed{kInterrupted};
    }
    return film.Finish();
  } else {
    *replay = ReplayLog(log, options.tolerance, session);
  }
  return 0;
}

void CheckOptions(const ReplayOptions& options) {
  if (!options.Shows()) {
    if (!options.view_given) return;
    throw InputError("--view, --size and --overlay need --film FILE or --window");
  }
  if (fs::path(options.log).extension() == ".csv") {
    throw InputError(options.log + ": a recorded motion is not shown; give a session");
  }
  if (options.clock == "real") throw InputError("--film and --window need --clock logged");
  ParsePictureSize(options.view.size);
}

void ReplaySession(const ReplayOptions& options) {
  std::optional<StopSignals> signals;  // before any thread
  std::optional<FilmFolder> folder;
  if (options.Shows()) signals.emplace();
  if (!options.film.empty()) folder.emplace(options.film);
  const LoggedSession log(LogPathOf(options.log));
  Scene scene = SceneOf(options, log.path());
  // The session's own devices are not used: the log has their samples.
  std::vector<DeviceChoice> devices(scene.instruments.size());
  Session session(std::move(scene), std::move(devices));
  if (options.clock == "real") {
    const Json report =
        RealtimeReplayReport(log.path(), session, ReplayInRealTime(log, &session), true);
    return Print(options, report, RealtimeText(report));
  }
  LogReplay replay;
  const std::uint64_t frames = ReplayAndShow(options, log, signals, folder, &session, &replay);
  if (replay.ticks_compared == 0) {
    const std::string why =
        replay.ended_early.empty() ? "no tick has an output that can be read" : replay.ended_early;
    throw InputError(log.path() + ": nothing to compare (" + why +
                     "); give a log of this version that contains the session's beginning");
  }
  Json report = LogReplayReport(log, session, replay);
  std::string text = ReplayText(log, replay, report);
  if (!options.film.empty()) {
    report["film"] = {
        {"path", options.film}, {"frames", frames}, {"fps", options.frames_per_second}};
    text += "film: " + options.film +
            Format(" (%.1f s)\n", static_cast<double>(frames) / options.frames_per_second);
  }
  Print(options, report, text);
  if (replay.comparison.first_beyond()) throw CheckFailed();
}

void Replay(const ReplayOptions& options) {
  CheckOptions(options);
  fs::path(options.log).extension() == ".csv" ? ReplayTrace(options) : ReplaySession(options);
}

// Returns the options that need --film or --window.
std::vector<Option> AddViewOptions(Command replay, ReplayOptions* options) {
  const Option window = replay.AddFlag("--window", options->window,
                                       "Show the session in a window; the keys of the view are "
                                       "those of `hpdm run --window` (F1 lists them), Esc ends");
  Option film = replay.AddOption("--film", options->film,
                                 "Make a film of the session: an MP4 file, which ffmpeg encodes");
  film.Excludes(window);
  replay.AddOption("--fps", options->frames_per_second, "Pictures per second of the film")
      .From(1.0, 240.0)
      .ShowDefault()
      .Needs(film);
  return {
      replay
          .AddOption("--view", options->view.view,
                     "Where it is seen from: laparoscope (the scene's), front, behind, left, "
                     "right, below, above (-y, +y, -x, +x, -z, +z), or X,Y,Z,X,Y,Z: position and "
                     "target in m")
          .ShowDefault(),
      replay.AddOption("--size", options->view.size, "Picture size, WIDTHxHEIGHT").ShowDefault(),
      replay
          .AddOption("--overlay", options->view.overlays,
                     "Overlays, separated by commas: force (0 to 2 N), contacts, lattice, text")
          .SplitAt(',')
          .OneOf({"force", "contacts", "lattice", "text"}),
  };
}

}  // namespace

void AddReplayCommand(Command app) {
  auto options = std::make_shared<ReplayOptions>();
  Command replay =
      app.AddCommand("replay", "Recompute a session and compare, or play a recorded motion");
  replay
      .AddOption("log", options->log,
                 "Session folder, its session.lcmlog, or a recorded motion (CSV)")
      .Required();
  replay.AddOption("--scene", options->scene, "Scene file [for a log: scene.toml beside it]");
  replay
      .AddOption("--tolerance", options->tolerance,
                 "Largest difference allowed, relative to the field's largest value in the log; 0: "
                 "equal bit for bit")
      .From(0.0, 1.0)
      .ShowDefault();
  replay
      .AddOption("--clock", options->clock,
                 "logged: repeat every tick, step and patch of the log; real: run in real time and "
                 "report latencies")
      .OneOf({"logged", "real"})
      .ShowDefault();
  replay.AddFlag("--json", options->json, "Print the report as JSON");
  const std::vector<Option> of_view = AddViewOptions(replay, options.get());
  replay.OnRun([options, of_view] {
    options->view_given =
        std::any_of(of_view.begin(), of_view.end(), [](const Option& one) { return one.Given(); });
    Replay(*options);
  });
}

}  // namespace hpdm
