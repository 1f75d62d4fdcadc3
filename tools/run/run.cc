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
  std::string out;     // empty: a free name
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
  // Of the pictures in frames/; in a window the user says when.
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
    throw InputError("--size " + options.size + ": cannot be drawn; give " +
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

void OpenWindow(const RunOptions& options, const RenderOptions& render, Session* session,
                std::optional<TrainerWindow>* window) {
  ViewSettings view;
  view.scope = session->scene().laparoscope;
  view.overlays = kOverlayText | render.overlays;
  view.has_reference = !options.references.empty();
  view.recording = options.frames_per_second.value_or(0) > 0;
  window->emplace(
      render.width, render.height, "HPDM: " + session->scene().name, view,
      session->TrainerInstruments(),
      TrainerWindow::Edges{session->view_settings, session->control, session->hand_targets});
}

TelemetryOptions TelemetryOptionsOf(const RunOptions& options, const MachineState& machine,
                                    const SessionFolder& folder, Session* session) {
  TelemetryOptions telemetry;
  telemetry.live = options.live;
  telemetry.forces_linked = session->HasExternalDevice();
  telemetry.timeline_path = folder.File("timeline.csv");
  telemetry.haptic_period = session->haptic_period_ns();
  telemetry.health = &session->health;
  // At once: the session may go on for long.
  telemetry.tell = [](const std::string& failure) { std::cerr << "hpdm: note: " + failure + "\n"; };
  if (!options.Lockstep()) {  // nothing measured is logged there
    telemetry.frames = &session->frames;
    telemetry.events = {&session->render_events, &session->link_events};
    telemetry.baseline = machine.baseline.wake_late;
    telemetry.stolen_time = StolenTime;
    telemetry.epoch_us = WallTimeUs();
  }
  return telemetry;
}

void WritePicture(const Image& image, const SessionFolder& folder, const std::string& name) {
  if (image.width > 0) WritePng(folder.File(name), image);
}

void CheckLockstep(const RunOptions& options, const std::vector<DeviceChoice>& devices) {
  if (options.window) {
    throw InputError("--clock lockstep: a window's user lives in real time; use --clock real");
  }
  bool ends = options.seconds > 0 || !devices.empty();
  for (const DeviceChoice& device : devices) {
    if (device.type == DeviceChoice::Type::kLcm) {
      throw InputError("--clock lockstep: an external driver lives in real time; use --clock real");
    }
    ends &= options.seconds > 0 || device.type == DeviceChoice::Type::kTrace;
  }
  if (!ends) throw InputError("--clock lockstep: its length is missing; add --seconds N");
}

// Writes what is known when the session is over, the summary first: a disk that fills up must not
// cost it. The first failure goes to `write_error`, which may hold one already.
void KeepResults(const RunOptions& options, const nlohmann::ordered_json& summary,
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
    if (!missing.empty()) std::cerr << "hpdm: note: " + name + ": " + missing + "\n";
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

// The traces that the command line chose.
std::vector<std::string> TracesOf(const std::vector<DeviceChoice>& devices) {
  std::vector<std::string> traces;
  for (const DeviceChoice& device : devices) {
    const bool known = std::find(traces.begin(), traces.end(), device.trace) != traces.end();
    if (device.type == DeviceChoice::Type::kTrace && !known) traces.push_back(device.trace);
  }
  return traces;
}

void Run(const RunOptions& options, const std::vector<std::string>& command_line) {
  if (options.window && (options.headless || !options.pictures)) {
    throw InputError(std::string("--window: contradicts ") +
                     (options.headless ? "--headless" : "--no-pictures") + "; leave one out");
  }
  if (options.film && (!options.pictures || options.FramesPerSecond() == 0)) {
    throw InputError(std::string("--film: contradicts ") +
                     (options.pictures ? "--fps 0" : "--no-pictures") + "; leave one out");
  }
  SizeOf(options);
  if (options.live) NetworkUrl();  // refuses what is no address, before anything is made
  const StopSignals signals;       // before any thread
  // A file that may not grow and a reader of our output that has gone are failed writes, which are
  // reported; they must not end the session.
  for (const int failed_write : {SIGXFSZ, SIGPIPE}) std::signal(failed_write, SIG_IGN);
  Scene scene = LoadScene(options.scene);
  std::vector<DeviceChoice> devices =
      ChooseDevices(options.devices, scene.instruments, options.window);
  if (options.Lockstep()) CheckLockstep(options, devices);
  ControlScript exchanges = ParseExchanges(options.exchanges, scene.instruments);
  Session session(std::move(scene), std::move(devices));
  const double seconds = options.seconds > 0 ? options.seconds : ToSeconds(session.trace_length());
  if (options.references.empty() &&
      std::count(options.overlays.begin(), options.overlays.end(), "error") > 0) {
    throw InputError(
        "--overlay error: has nothing to compare with; add --reference FILE, such as `hpdm solve "
        "--out` writes");
  }
  for (const std::string& reference : options.references) session.LoadReference(reference);
  RenderOptions render_options = RenderOptionsOf(options, session);
  // A machine that cannot draw says so before the session.
  std::optional<TrainerWindow> window;
  RenderContextFactory make_context = HeadlessContext;
  if (options.window) {
    OpenWindow(options, render_options, &session, &window);
    make_context = [&window] { return window->MakeContext(); };
  } else if (options.pictures) {
    EglContext();
  }
  const MachineState machine =
      ProbeRealtime(options.Lockstep(), options.require_realtime, session.haptic_period_ns());
  const SessionClock clock;
  std::optional<DeviceLink> link;
  if (session.HasExternalDevice()) {
    link.emplace(NetworkUrl(), clock,
                 DeviceLink::Edges{session.external_readings, session.external_forces,
                                   &session.link_events});
  }
  SessionFolder folder(
      options.out.empty() ? SessionFolder::FreeName() : std::filesystem::path(options.out),
      session.scene(), TracesOf(session.device_choices()));
  for (const std::string& remark : session.remarks())
    std::cerr << "hpdm: note: " << OneLine(remark) << "\n";
  if (options.pictures && options.FramesPerSecond() > 0) {
    render_options.frame_folder = folder.File("frames");
    render_options.frame_fps = options.FramesPerSecond();
  }
  render_options.screenshot_folder = folder.File("screenshots");

  std::function<Nanoseconds()> stopwatch;
  if (!options.Lockstep()) stopwatch = [&clock] { return clock.Now(); };
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
      {*session.render_scenes, options.Lockstep() ? nullptr : &session.frames,
       window ? &session.view_settings : nullptr, &session.health,
       options.Lockstep() ? nullptr : &session.render_events},
      stopwatch ? stopwatch : [] { return Nanoseconds{0}; }, make_context);
  TelemetryLoop telemetry(&session.samples, &session.steps, session.telemetry_scenes.get(),
                          folder.File(kSessionLogName),
                          TelemetryOptionsOf(options, machine, folder, &session), session.Info());
  const std::uint64_t end_tick =
      seconds > 0
          ? static_cast<std::uint64_t>(std::llround(seconds * session.scene().timing.haptic_hz))
          : std::numeric_limits<std::uint64_t>::max();
  const Loops loops{session,          haptics,
                    deformation,      render,
                    telemetry,        link ? &*link : nullptr,
                    signals,          end_tick,
                    options.pictures, window ? &*window : nullptr,
                    &exchanges};
  const RunRecord record =
      options.Lockstep() ? RunInLockstep(loops) : RunOnRealClock(loops, machine, clock);
  window.reset();  // what follows takes a while, and the pointer is the user's

  const TelemetrySummary telemetry_summary = telemetry.Summary();
  const nlohmann::ordered_json summary =
      RunSummary(session, record, telemetry_summary, options.pictures ? &render : nullptr,
                 command_line, folder);
  std::string write_error = telemetry_summary.log.Explain();
  if (write_error.empty()) write_error = telemetry_summary.timeline_failure;
  if (write_error.empty()) write_error = render.file_failure();
  if (folder.Finish()) {
    KeepResults(options, summary, telemetry_summary, render, folder, &write_error);
  } else if (write_error.empty()) {
    write_error = "the folder was deleted";
  }
  if (options.json) {
    std::cout << JsonText(summary) << "\n";
  } else {
    std::cout << ReadableSummary(summary) << "session folder: " << folder.path().string() << " ("
              << (options.pictures ? "deepest.png, " : "") << "timeline.png, "
              << (options.Lockstep() ? "" : "latency.png, ") << "summary.json, session.lcmlog)\n";
  }
  if (!write_error.empty())
    throw InputError(folder.path().string() + ": incomplete: " + write_error);
}

}  // namespace

void AddRunCommand(Command app, std::vector<std::string> command_line) {
  auto options = std::make_shared<RunOptions>();
  Command run = app.AddCommand("run", "Run a session of a scene");
  run.AddOption("scene", options->scene, "Scene file (TOML; see scenes/README.md)").Required();
  run.AddOption(
         "--seconds", options->seconds,
         "Length; without it, until SIGINT, SIGTERM or SIGHUP, Esc in the window, or the end of "
         "the traces")
      .From(0.001, 1e6);
  run.AddOption("--out", options->out, "Session folder to make [out/session_N]");
  run.AddFlag("--headless", options->headless, "Draw without a window (the default)");
  run.AddFlag("--window", options->window,
              "Draw in a window; the mouse moves the instruments (F1 lists the keys)");
  run.AddOption("--fps", options->frames_per_second,
                "Pictures a second kept in frames/; 0 keeps none [2; in a window those that r "
                "asks for, 30]")
      .From(0.0, 240.0);
  run.AddFlag(
      "--film", options->film,
      "Make film.mp4 of the pictures in frames/, with ffmpeg; take --fps 30 for a smooth one");
  run.AddFlag("!--no-pictures", options->pictures, "Draw nothing");
  run.AddOption("--size", options->size, "Picture, WIDTHxHEIGHT").ShowDefault();
  run.AddOption(
         "--overlay", options->overlays,
         "Drawn over the picture, separated by commas: force (0 to 2 N), contacts, lattice, error "
         "(see --reference), text")
      .SplitAt(',')
      .OneOf({"force", "contacts", "lattice", "error", "text"});
  run.AddOption("--reference", options->references,
                "Surface displacements that --overlay error compares an organ with: FILE as "
                "`hpdm solve --out` writes it, or ORGAN=FILE; repeatable");
  run.AddOption("--ffd", options->ffd,
                "Who deforms the organs in the picture: cpu, shader, or auto: the shader, unless "
                "the renderer is software or a lattice has more than 350 control points")
      .OneOf({"auto", "cpu", "shader"})
      .ShowDefault();
  run.AddOption("--clock", options->clock, "real, or lockstep: one thread, virtual time")
      .OneOf({"real", "lockstep"})
      .ShowDefault();
  run.AddOption("--device", options->devices,
                "What moves the instruments: sim, trace:FILE (CSV), lcm (an external driver) or "
                "mouse; NAME=... for one of them; repeatable [the scene's trace, or sim, in a "
                "window mouse]");
  run.AddOption("--exchange", options->exchanges,
                "NAME=OTHER@SECONDS: the hand that began with NAME takes OTHER (see "
                "instrument.exchange in scenes/README.md) as soon as its tip is free; repeatable")
      .Excludes("--window");
  run.AddFlag("--live", options->live,
              "Publish over LCM too (LCM_DEFAULT_URL, or this machine's multicast)");
  run.AddFlag("--require-rt", options->require_realtime,
              "Exit with 3 when the system refuses real-time scheduling or memory locking");
  run.AddFlag("--json", options->json, "Print the summary as JSON");
  run.OnRun([options, command_line = std::move(command_line)] { Run(*options, command_line); });
}

}  // namespace hpdm
