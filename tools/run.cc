#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "engine/error.h"
#include "engine/stolen_time.h"
#include "lcmtypes/network.h"
#include "lcmtypes/wall_time.h"
#include "render/egl_context.h"
#include "render/laparoscope.h"
#include "scenes/obj_writer.h"
#include "tools/commands.h"
#include "tools/film.h"
#include "tools/json_figures.h"
#include "tools/latency_table.h"
#include "tools/number_option.h"
#include "tools/plot_latency.h"
#include "tools/plot_timeline.h"
#include "tools/python_plot.h"
#include "tools/session_folder.h"
#include "tools/session_path.h"
#include "tools/session_threads.h"

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

std::vector<OrganView> OrganViewsOf(const RunOptions& options, const Session& session) {
  std::vector<OrganView> views = session.OrganViews();
  for (OrganView& view : views) view.ffd = kFfdPaths.at(options.ffd);
  return views;
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
// cost it. The first failure goes to `not_kept`, which may hold one already.
void KeepResults(const RunOptions& options, const nlohmann::ordered_json& summary,
                 const TelemetrySummary& told, const RenderLoop& render,
                 const SessionFolder& folder, std::string* not_kept) {
  const auto keep = [not_kept](const auto& write) {
    try {
      write();
    } catch (const InputError& error) {
      if (not_kept->empty()) *not_kept = error.what();
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
    keep([&] { WriteTextFile(folder.File("latency.csv"), LatencyTable(told.session.latencies)); });
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
  // told; they must not end the session.
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
      TryMachine(options.Lockstep(), options.require_realtime, session.haptic_period_ns());
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
      OrganViewsOf(options, session), session.InstrumentViews(), session.scene().laparoscope,
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

  const TelemetrySummary told = telemetry.Summary();
  const nlohmann::ordered_json summary =
      RunSummary(session, record, told, options.pictures ? &render : nullptr, command_line, folder);
  std::string not_kept = told.log.Explain();
  if (not_kept.empty()) not_kept = told.timeline_failure;
  if (not_kept.empty()) not_kept = render.file_failure();
  if (folder.Finish()) {
    KeepResults(options, summary, told, render, folder, &not_kept);
  } else if (not_kept.empty()) {
    not_kept = "the folder was deleted";
  }
  if (options.json) {
    std::cout << JsonText(summary) << "\n";
  } else {
    std::cout << ReadableSummary(summary) << "session folder: " << folder.path().string() << " ("
              << (options.pictures ? "deepest.png, " : "") << "timeline.png, "
              << (options.Lockstep() ? "" : "latency.png, ") << "summary.json, session.lcmlog)\n";
  }
  if (!not_kept.empty()) throw InputError(folder.path().string() + ": incomplete: " + not_kept);
}

}  // namespace

void AddRunCommand(CLI::App& app, std::vector<std::string> command_line) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* run = app.add_subcommand("run", "Run a session of a scene");
  run->add_option("scene", options->scene, "Scene file (TOML; see scenes/README.md)")->required();
  run->add_option(
         "--seconds", options->seconds,
         "Length; without it, until SIGINT, SIGTERM or SIGHUP, Esc in the window, or the end of "
         "the traces")
      ->check(NumberFrom(0.001, 1e6));
  run->add_option("--out", options->out, "Session folder to make [out/session_N]");
  run->add_flag("--headless", options->headless, "Draw without a window (the default)");
  run->add_flag("--window", options->window,
                "Draw in a window; the mouse moves the instruments (F1 lists the keys)");
  run->add_option("--fps", options->frames_per_second,
                  "Pictures a second kept in frames/; 0 keeps none [2; in a window those that r "
                  "asks for, 30]")
      ->check(NumberFrom(0.0, 240.0));
  run->add_flag(
      "--film", options->film,
      "Make film.mp4 of the pictures in frames/, with ffmpeg; take --fps 30 for a smooth one");
  run->add_flag("!--no-pictures", options->pictures, "Draw nothing");
  run->add_option("--size", options->size, "Picture, WIDTHxHEIGHT")->capture_default_str();
  run->add_option(
         "--overlay", options->overlays,
         "Drawn over the picture, separated by commas: force (0 to 2 N), contacts, lattice, error "
         "(see --reference), text")
      ->delimiter(',')
      ->check(CLI::IsMember({"force", "contacts", "lattice", "error", "text"}));
  run->add_option("--reference", options->references,
                  "Surface displacements that --overlay error compares an organ with: FILE as "
                  "`hpdm solve --out` writes it, or ORGAN=FILE; repeatable");
  run->add_option("--ffd", options->ffd,
                  "Who deforms the organs in the picture: cpu, shader, or auto: the shader, unless "
                  "the renderer is software or a lattice has more than 350 control points")
      ->check(CLI::IsMember({"auto", "cpu", "shader"}))
      ->capture_default_str();
  run->add_option("--clock", options->clock, "real, or lockstep: one thread, virtual time")
      ->check(CLI::IsMember({"real", "lockstep"}))
      ->capture_default_str();
  run->add_option("--device", options->devices,
                  "What moves the instruments: sim, trace:FILE (CSV), lcm (an external driver) or "
                  "mouse; NAME=... for one of them; repeatable [the scene's trace, or sim, in a "
                  "window mouse]");
  run->add_option("--exchange", options->exchanges,
                  "NAME=OTHER@SECONDS: the hand that began with NAME takes OTHER (see "
                  "instrument.exchange in scenes/README.md) as soon as its tip is free; repeatable")
      ->excludes("--window");
  run->add_flag("--live", options->live,
                "Publish over LCM too (LCM_DEFAULT_URL, or this machine's multicast)");
  run->add_flag("--require-rt", options->require_realtime,
                "Exit with 3 when the system refuses real-time scheduling or memory locking");
  run->add_flag("--json", options->json, "Print the summary as JSON");
  run->callback([options, command_line = std::move(command_line)] { Run(*options, command_line); });
}

}  // namespace hpdm
