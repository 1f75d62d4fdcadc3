#include <algorithm>
#include <cmath>
#include <csignal>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "engine/base/error.h"
#include "engine/threads/stolen_time.h"
#include "lcmtypes/live/network.h"
#include "lcmtypes/live/wall_time.h"
#include "render/camera/laparoscope.h"
#include "render/gl/egl_context.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/plots/plot_latency.h"
#include "tools/plots/plot_timeline.h"
#include "tools/plots/python_plot.h"
#include "tools/run/film.h"
#include "tools/run/latency_table.h"
#include "tools/session/session_folder.h"
#include "tools/session/session_path.h"
#include "tools/session/session_threads.h"
#include "tools/shared/json_text.h"
#include "tools/shared/number_text.h"

namespace hpdm {
namespace {

struct RunOptions {
  std::string scene;
  double seconds = 0;  // 0: until a signal
  std::string out;     // empty: the first free name
  std::optional<double> frames_per_second;
  std::string size = "640x480";
  std::string clock = "real";
  std::string ffd = "auto";
  std::vector<std::string> overlays;
  std::vector<std::string> references;
  std::vector<std::string> devices;
  std::vector<std::string> exchanges;
  bool film = false;
  bool pictures = true;
  bool headless = false;
  bool window = false;
  bool live = false;
  bool require_realtime = false;
  bool json = false;

  bool Lockstep() const { return clock == "lockstep"; }
  // Rate of the pictures kept in frames/. In a window the user starts the recording.
  double FramesPerSecond() const { return frames_per_second.value_or(window ? 30 : 2); }
};

const std::map<std::string, std::uint32_t> kOverlays = {{"force", kOverlayForce},
                                                        {"contacts", kOverlayContacts},
                                                        {"lattice", kOverlayLattice},
                                                        {"error", kOverlayError},
                                                        {"text", kOverlayText}};
const std::map<std::string, FfdPath> kFfdPaths = {
    {"auto", FfdPath::kAuto}, {"cpu", FfdPath::kCpu}, {"shader", FfdPath::kShader}};

std::vector<OrganVisual> OrganVisualsOf(const RunOptions& options, const Session& session) {
  std::vector<OrganVisual> visuals = session.OrganVisuals();
  for (OrganVisual& visual : visuals) visual.ffd = kFfdPaths.at(options.ffd);
  return visuals;
}

struct PictureSize {
  int width = 0, height = 0;
};

PictureSize SizeOf(const RunOptions& options) {
  PictureSize size;
  const std::size_t cross = std::min(options.size.find('x'), options.size.size());
  const std::string_view text = options.size;
  if (!ReadNumber(text.substr(0, cross), &size.width) ||
      !ReadNumber(text.substr(std::min(cross + 1, text.size())), &size.height)) {
    throw InputError("--size " + options.size + ": is not WIDTHxHEIGHT; give 640x480, for example");
  }
  for (const int side : {size.width, size.height}) {
    if (side >= Laparoscope::kMinSide && side <= Laparoscope::kMaxSide) continue;
    throw InputError("--size " + options.size + ": is out of range; give " +
                     std::to_string(Laparoscope::kMinSide) + " to " +
                     std::to_string(Laparoscope::kMaxSide) + " pixels on a side");
  }
  return size;
}

RenderOptions RenderOptionsOf(const RunOptions& options, const Session& session) {
  RenderOptions render;
  const PictureSize size = SizeOf(options);
  render.width = size.width;
  render.height = size.height;
  render.max_hz = session.scene().timing.render_hz;
  render.names = session.Names();
  render.background = session.Background();
  for (const std::string& name : options.overlays) render.overlays |= kOverlays.at(name);
  return render;
}

// Refuses options that contradict each other, before anything is built.
void CheckOptions(const RunOptions& options) {
  if (options.window && (options.headless || !options.pictures)) {
    throw InputError(std::string("--window cannot be combined with ") +
                     (options.headless ? "--headless" : "--no-pictures") + "; leave one out");
  }
  if (options.film && (!options.pictures || options.FramesPerSecond() == 0)) {
    throw InputError(std::string("--film cannot be combined with ") +
                     (options.pictures ? "--fps 0" : "--no-pictures") + "; leave one out");
  }
  SizeOf(options);
  if (options.live) NetworkUrl();
}

void CheckLockstep(const RunOptions& options, const std::vector<DeviceChoice>& devices) {
  if (options.window) throw InputError("--window needs --clock real");
  bool ends = options.seconds > 0 || !devices.empty();
  for (const DeviceChoice& device : devices) {
    if (device.type == DeviceChoice::Type::kLcm) {
      throw InputError("--device lcm needs --clock real");
    }
    ends &= options.seconds > 0 || device.type == DeviceChoice::Type::kTrace;
  }
  if (!ends) throw InputError("--clock lockstep needs a length; add --seconds N");
}

void LoadReferences(const RunOptions& options, Session* session) {
  if (options.references.empty() &&
      std::count(options.overlays.begin(), options.overlays.end(), "error") > 0) {
    throw InputError(
        "--overlay error: no reference to compare with; add --reference FILE, such as `hpdm solve "
        "--out` writes");
  }
  for (const std::string& reference : options.references) session->LoadReference(reference);
}

// Opens the window, or checks that this machine can draw without one, so that a machine that cannot
// draw fails before the session starts. Returns what makes the render thread's context.
RenderContextFactory OpenDisplay(const RunOptions& options, const RenderOptions& render,
                                 Session* session, std::optional<TrainerWindow>* window) {
  if (!options.window) {
    if (options.pictures) EglContext();
    return HeadlessContext;
  }
  ViewSettings view;
  view.scope = session->scene().laparoscope;
  view.overlays = kOverlayText | render.overlays;
  view.has_reference = !options.references.empty();
  view.recording = options.frames_per_second.value_or(0) > 0;
  window->emplace(
      render.width, render.height, "HPDM: " + session->scene().name, view,
      session->TrainerInstruments(),
      TrainerWindow::Edges{session->view_settings, session->control, session->hand_targets});
  return [window] { return (*window)->MakeContext(); };
}

// Returns the traces that the command line chose, each once.
std::vector<std::string> TracesOf(const std::vector<DeviceChoice>& devices) {
  std::vector<std::string> traces;
  for (const DeviceChoice& device : devices) {
    const bool known = std::find(traces.begin(), traces.end(), device.trace) != traces.end();
    if (device.type == DeviceChoice::Type::kTrace && !known) traces.push_back(device.trace);
  }
  return traces;
}

SessionFolder MakeFolder(const RunOptions& options, const Session& session) {
  return SessionFolder(
      options.out.empty() ? SessionFolder::FreeName() : std::filesystem::path(options.out),
      session.scene(), TracesOf(session.device_choices()));
}

void SetPictureFolders(const RunOptions& options, const SessionFolder& folder,
                       RenderOptions* render) {
  if (options.pictures && options.FramesPerSecond() > 0) {
    render->frame_folder = folder.File("frames");
    render->frame_fps = options.FramesPerSecond();
  }
  render->screenshot_folder = folder.File("screenshots");
}

TelemetryOptions TelemetryOptionsOf(const RunOptions& options, const MachineState& machine,
                                    const SessionFolder& folder, Session* session) {
  TelemetryOptions telemetry;
  telemetry.live = options.live;
  telemetry.forces_linked = session->HasExternalDevice();
  telemetry.timeline_path = folder.File("timeline.csv");
  telemetry.haptic_period = session->haptic_period_ns();
  telemetry.health = &session->health;
  // Printed at once: the session may last long after a failure.
  telemetry.tell = [](const std::string& failure) { std::cerr << "hpdm: note: " + failure + "\n"; };
  if (!options.Lockstep()) {  // the lockstep clock logs no measured times
    telemetry.frames = &session->frames;
    telemetry.events = {&session->render_events, &session->link_events};
    telemetry.baseline = machine.baseline.wake_late;
    telemetry.stolen_time = StolenTime;
    telemetry.epoch_us = WallTimeUs();
  }
  return telemetry;
}

std::uint64_t EndTick(const RunOptions& options, const Session& session) {
  const double seconds = options.seconds > 0 ? options.seconds : ToSeconds(session.trace_length());
  if (seconds <= 0) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(std::llround(seconds * session.scene().timing.haptic_hz));
}

void Note(const std::string& note) { std::cerr << "hpdm: note: " + note + "\n"; }

void WritePicture(const Image& image, const SessionFolder& folder, const std::string& name) {
  if (image.width > 0) WritePng(folder.File(name), image);
}

// Writes the results of a finished session. The summary comes first, so that a disk that fills up
// does not cost it. The first failure goes to `write_error`, which may hold one already.
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

// Writes and prints the results. Throws InputError if the folder is incomplete.
void Finish(const RunOptions& options, const nlohmann::ordered_json& summary,
            const TelemetrySummary& telemetry_summary, const RenderLoop& render,
            SessionFolder* folder) {
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
    std::cout << ReadableSummary(summary) << "session folder: " << folder->path().string() << " ("
              << (options.pictures ? "deepest.png, " : "") << "timeline.png, "
              << (options.Lockstep() ? "" : "latency.png, ") << "summary.json, session.lcmlog)\n";
  }
  if (write_error.empty()) return;
  throw InputError(folder->path().string() + ": incomplete: " + write_error);
}

// Builds the session and its loops and wires them. session_threads.h shows the edges and threads.
void Run(const RunOptions& options, const std::vector<std::string>& command_line) {
  CheckOptions(options);
  const StopSignals signals;  // before any thread
  // A write beyond the file size limit or to a closed pipe is reported and does not end the session.
  for (const int failed_write : {SIGXFSZ, SIGPIPE}) std::signal(failed_write, SIG_IGN);
  Scene scene = LoadScene(options.scene);
  std::vector<DeviceChoice> devices =
      ChooseDevices(options.devices, scene.instruments, options.window);
  if (options.Lockstep()) CheckLockstep(options, devices);
  ControlScript exchanges = ParseExchanges(options.exchanges, scene.instruments);
  Session session(std::move(scene), std::move(devices));
  LoadReferences(options, &session);

  RenderOptions render_options = RenderOptionsOf(options, session);
  std::optional<TrainerWindow> window;
  const auto make_context = OpenDisplay(options, render_options, &session, &window);
  const MachineState machine =
      ProbeRealtime(options.Lockstep(), options.require_realtime, session.haptic_period_ns());
  const SessionClock clock;
  std::optional<DeviceLink> link;
  if (session.HasExternalDevice()) link.emplace(NetworkUrl(), clock, session.LinkEdges());
  SessionFolder folder = MakeFolder(options, session);
  for (const std::string& remark : session.remarks()) Note(OneLine(remark));
  SetPictureFolders(options, folder, &render_options);
  const bool measured = !options.Lockstep();
  std::function<Nanoseconds()> stopwatch;
  if (measured) stopwatch = [&clock] { return clock.Now(); };

  HapticLoop haptics(
      session.HapticInstruments(), session.haptic_period_ns(),
      {session.tool_states, session.patches, session.samples,
       session.HasExternalDevice() ? &session.external_forces : nullptr, &session.control});
  DeformationLoop deformation(session.organs(), session.DeformationTools(),
                              {session.tool_states, session.patches, *session.render_scenes,
                               *session.telemetry_scenes, &session.steps},
                              stopwatch, session.scene().timing.StepBudget());
  RenderLoop render(
      OrganVisualsOf(options, session), session.InstrumentVisuals(), session.scene().laparoscope,
      render_options,
      {*session.render_scenes, measured ? &session.frames : nullptr,
       window ? &session.view_settings : nullptr, &session.health,
       measured ? &session.render_events : nullptr},
      measured ? stopwatch : [] { return Nanoseconds{0}; }, make_context);
  TelemetryLoop telemetry(&session.samples, &session.steps, session.telemetry_scenes.get(),
                          folder.File(kSessionLogName),
                          TelemetryOptionsOf(options, machine, folder, &session), session.Info());
  const Loops loops{session,          haptics,
                    deformation,      render,
                    telemetry,        link ? &*link : nullptr,
                    signals,          EndTick(options, session),
                    options.pictures, window ? &*window : nullptr,
                    &exchanges};
  const RunRecord record = measured ? RunOnRealClock(loops, machine, clock) : RunInLockstep(loops);
  window.reset();  // gives the pointer back before the results are written, which takes a while

  const TelemetrySummary results = telemetry.Summary();
  Finish(options,
         RunSummary(session, record, results, options.pictures ? &render : nullptr, command_line,
                    folder),
         results, render, &folder);
}

}  // namespace

void AddRunCommand(Command app, std::vector<std::string> command_line) {
  auto options = std::make_shared<RunOptions>();
  Command run = app.AddCommand("run", "Run a session of a scene");
  run.AddOption("scene", options->scene, "Scene file (TOML; see scenes/README.md)").Required();
  run.AddOption(
         "--seconds", options->seconds,
         "Length in s [until SIGINT, SIGTERM or SIGHUP, Esc in the window, or the end of the "
         "traces]")
      .From(0.001, 1e6);
  run.AddOption("--out", options->out, "Session folder to create [out/session_N]");
  run.AddFlag("--headless", options->headless, "Draw without a window (the default)");
  run.AddFlag("--window", options->window,
              "Draw in a window; the mouse moves the instruments (F1 lists the keys)");
  run.AddOption("--fps", options->frames_per_second,
                "Pictures per second kept in frames/; 0 keeps none [2; in a window 30, while r "
                "records]")
      .From(0.0, 240.0);
  run.AddFlag(
      "--film", options->film,
      "Make film.mp4 from the pictures in frames/ with ffmpeg; use --fps 30 for a smooth film");
  run.AddFlag("!--no-pictures", options->pictures, "Draw nothing");
  run.AddOption("--size", options->size, "Picture size, WIDTHxHEIGHT").ShowDefault();
  run.AddOption("--overlay", options->overlays,
                "Overlays, separated by commas: force (0 to 2 N), contacts, lattice, error (see "
                "--reference), text")
      .SplitAt(',')
      .OneOf({"force", "contacts", "lattice", "error", "text"});
  run.AddOption("--reference", options->references,
                "Surface displacements that --overlay error compares an organ with: FILE as "
                "`hpdm solve --out` writes it, or ORGAN=FILE; repeatable");
  run.AddOption(
         "--ffd", options->ffd,
         "Processor that deforms the organs in the picture: cpu, shader, or auto: the shader, "
         "unless the renderer is software or a lattice has more than 350 control points")
      .OneOf({"auto", "cpu", "shader"})
      .ShowDefault();
  run.AddOption("--clock", options->clock, "real, or lockstep: one thread, virtual time")
      .OneOf({"real", "lockstep"})
      .ShowDefault();
  run.AddOption(
      "--device", options->devices,
      "Device of the instruments: sim, trace:FILE (CSV), lcm (an external driver) or mouse; "
      "NAME=... for one instrument; repeatable [the scene's trace, or else sim, in a "
      "window mouse]");
  run.AddOption(
         "--exchange", options->exchanges,
         "NAME=OTHER@SECONDS: at that time the hand that began with NAME takes OTHER, as soon "
         "as its tip is free (instrument.exchange in scenes/README.md); repeatable")
      .Excludes("--window");
  run.AddFlag("--live", options->live,
              "Also publish over LCM (LCM_DEFAULT_URL, or this machine's multicast)");
  run.AddFlag("--require-rt", options->require_realtime,
              "Exit with 3 if the system refuses real-time scheduling or memory locking");
  run.AddFlag("--json", options->json, "Print the summary as JSON");
  run.OnRun([options, command_line = std::move(command_line)] { Run(*options, command_line); });
}

}  // namespace hpdm
