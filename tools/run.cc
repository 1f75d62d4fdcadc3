#include <signal.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <latch>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <thread>

#include "engine/error.h"
#include "engine/loop_schedule.h"
#include "engine/realtime.h"
#include "engine/session_clock.h"
#include "engine/stolen_time.h"
#include "engine/wake_up_baseline.h"
#include "lcmtypes/device_link.h"
#include "lcmtypes/network.h"
#include "render/egl_context.h"
#include "scenes/obj_writer.h"
#include "tools/commands.h"
#include "tools/film.h"
#include "tools/json_figures.h"
#include "tools/latency_table.h"
#include "tools/lockstep.h"
#include "tools/plot_latency.h"
#include "tools/plot_timeline.h"
#include "tools/python_plot.h"
#include "tools/realtime_threads.h"
#include "tools/run_summary.h"
#include "tools/session.h"
#include "tools/session_folder.h"
#include "tools/trainer_window.h"

namespace hpdm {
namespace {

struct RunOptions {
  std::string scene;
  double seconds = 0;  // 0: until a signal
  std::string out;     // empty: a free name
  std::optional<double> frames_per_second;
  std::string size = "640x480";
  std::string clock = "real";
  FfdPath ffd = FfdPath::kAuto;
  std::vector<std::string> overlays;
  std::vector<std::string> references;
  std::vector<std::string> devices;
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

// SIGINT and SIGTERM ask for a clean end. They are blocked before any thread is started, which
// inherits that, and taken here by the main thread alone.
class StopSignals {
 public:
  StopSignals() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  }
  // True when one came within the time (less than a second).
  bool WaitFor(long nanoseconds) const {
    const timespec wait = {0, nanoseconds};
    return sigtimedwait(&signals_, nullptr, &wait) > 0;
  }

 private:
  sigset_t signals_;
};

constexpr Nanoseconds kBaselineLength = kNanosecondsPerSecond;
// What a window's input waits for at most when nothing is typed, s: held keys act this often.
constexpr double kWindowPeriod = 0.01;

// What the machine grants, and how late it wakes a thread like the haptic one that does nothing.
struct MachineState {
  RealtimeReport process, haptic;
  WakeUpBaseline baseline;

  // The first refusal, or empty.
  std::string Refusal() const {
    return process.Complete() ? haptic.FirstRefusal() : process.FirstRefusal();
  }
};

// Asks for what a session would and wakes at its haptic rate for a second (not in virtual time),
// before anything else of it runs or a device displays a force. Throws MachineError where something
// was refused and required.
MachineState TryMachine(const RunOptions& options, Nanoseconds period_ns) {
  MachineState machine;
  if (options.Lockstep() && !options.require_realtime) return machine;
  machine.process = RequestRealtime(ProcessRealtime());
  std::jthread([&] {
    machine.haptic = RequestRealtime(HapticRealtime());
    if (options.Lockstep() || (options.require_realtime && !machine.Refusal().empty())) return;
    RealLoopClock clock{SessionClock()};
    const auto ticks = static_cast<std::uint64_t>(kBaselineLength / period_ns);
    machine.baseline = MeasureWakeUps({period_ns, period_ns, ticks}, {}, clock);
  }).join();
  if (options.require_realtime && !machine.Refusal().empty()) {
    throw MachineError("--require-rt: " + machine.Refusal() +
                       "; run as root or raise the rtprio and memlock limits");
  }
  return machine;
}

// The loops of one session and what they need to run.
struct Loops {
  Session& session;
  HapticLoop& haptics;
  DeformationLoop& deformation;
  RenderLoop& render;
  TelemetryLoop& telemetry;
  DeviceLink* link;  // null without external devices
  const StopSignals& signals;
  std::uint64_t end_tick;
  bool pictures;          // false: the render loop never starts
  TrainerWindow* window;  // null without one
};

// The real clock, one thread a loop:
//
//     device -> haptic (1 kHz) --ToolState--> deformation (30 Hz) --SceneSnapshot--> render
//        ^        |  ^------ContactPatch--------'      '---SceneSnapshot--> telemetry -> log, LCM
//        '-effort-'  '---HapticSample queue, every tick-------------------^  ^  ^
//                                   StepSample queue, every step ---------'  |
//                      FrameRecord, LoopEvent queues of render ---------------'--SessionHealth-->
//                      render
//
// With a window the main thread takes its input, where the window library wants it:
//
//     window --HandTarget, SessionControl--> haptic;   window --ViewSettings--> render
//
// External devices have a link of two threads: HPDM_DEVICE --> device, HapticSample --> HPDM_FORCE.
//
// The two loops with a deadline start together, once each has asked for its real-time state. The
// haptic thread ends the session at its last tick; the telemetry ends after the loops, and the
// links last, so that they drain everything.
RunRecord RunOnRealClock(const Loops& loops, const MachineState& machine,
                         const SessionClock& clock) {
  RunRecord record;
  record.baseline = machine.baseline;
  RealtimeReport haptic, deformation;
  loops.session.EnableForces(true);
  std::latch start(2);
  std::stop_source over;

  std::jthread receive_thread, send_thread;
  if (loops.link != nullptr) {
    RealtimeOptions realtime;
    realtime.fifo_priority = DeviceLink::kPriority;
    receive_thread = std::jthread([&, realtime](std::stop_token stop) {
      RequestRealtime(realtime);
      loops.link->Receive(stop);
    });
    send_thread = std::jthread([&, realtime](std::stop_token stop) {
      RequestRealtime(realtime);
      loops.link->Send(stop);
    });
  }
  std::jthread telemetry_thread([&](std::stop_token stop) { loops.telemetry.Run(stop); });
  std::jthread render_thread;
  if (loops.pictures) {
    render_thread = std::jthread([&](std::stop_token stop) {
      loops.render.Run(stop);
      // At once: the session may go on for long.
      const std::string& failure = loops.render.failure();
      if (!failure.empty()) std::cerr << "hpdm: note: " + failure + "\n";
    });
  }
  std::jthread deformation_thread([&](std::stop_token stop) {
    deformation = RequestRealtime(DeformationRealtime());
    start.arrive_and_wait();
    RealLoopClock loop_clock(clock);
    const int hz = loops.session.scene().timing.deformation_hz;
    record.deformation = RunOnSchedule(
        {.start_ns = clock.Now(), .period_ns = kNanosecondsPerSecond / hz}, stop, loop_clock,
        [&](std::uint64_t, Nanoseconds due, const TickTiming& timing) {
          loops.deformation.Step(loops.deformation.NewestTools(), due, timing.wake_late_ns);
        });
  });
  std::jthread haptic_thread([&](std::stop_token stop) {
    haptic = RequestRealtime(HapticRealtime());
    start.arrive_and_wait();
    RealLoopClock loop_clock(clock);
    record.haptic = loops.haptics.RunRealClock(stop, loop_clock, clock.Now(), loops.end_tick);
    over.request_stop();
  });

  while (!over.stop_requested() && !record.interrupted) {
    if (loops.window != nullptr && !loops.window->lost()) {
      loops.window->Pump(kWindowPeriod);
      record.interrupted = loops.window->ended() || loops.signals.WaitFor(0);
    } else {
      record.interrupted = loops.signals.WaitFor(20'000'000);
    }
  }
  for (std::jthread* thread : {&haptic_thread, &deformation_thread, &render_thread,
                               &telemetry_thread, &receive_thread, &send_thread}) {
    if (!thread->joinable()) continue;
    thread->request_stop();
    thread->join();
  }
  if (loops.link != nullptr) record.link = loops.link->Summary();
  loops.session.EnableForces(false);
  record.realtime = {
      {"process", machine.process}, {"haptic", haptic}, {"deformation", deformation}};
  return record;
}

// The lockstep clock: one thread, virtual time.
RunRecord RunInLockstep(const Loops& loops) {
  RunRecord record;
  record.lockstep = true;
  const TimingOptions& timing = loops.session.scene().timing;
  Lockstep clock(timing, &loops.haptics, &loops.deformation);
  loops.session.EnableForces(true);
  while (clock.tick() < loops.end_tick && !record.interrupted) {
    // The queue holds two seconds of samples, and steps may be rarer.
    if (clock.tick() % static_cast<std::uint64_t>(timing.haptic_hz) == 0) loops.telemetry.Drain();
    if (clock.StepIfDue()) {
      ++record.deformation.ticks;
      if (loops.pictures) loops.render.Frame();
      loops.telemetry.Drain();
      record.interrupted = loops.signals.WaitFor(0);
    }
    clock.Tick();
    ++record.haptic.ticks;
  }
  loops.session.EnableForces(false);
  loops.telemetry.Finish();
  loops.render.EndOnThisThread();
  return record;
}

const std::map<std::string, std::uint32_t> kOverlays = {{"force", kOverlayForce},
                                                        {"contacts", kOverlayContacts},
                                                        {"lattice", kOverlayLattice},
                                                        {"error", kOverlayError},
                                                        {"text", kOverlayText}};
const std::map<std::string, FfdPath> kFfdPaths = {
    {"auto", FfdPath::kAuto}, {"cpu", FfdPath::kCpu}, {"shader", FfdPath::kShader}};

std::vector<OrganView> OrganViewsOf(const RunOptions& options, const Session& session) {
  std::vector<OrganView> views = session.OrganViews();
  for (OrganView& view : views) view.ffd = options.ffd;
  return views;
}

RenderOptions RenderOptionsOf(const RunOptions& options, const Session& session) {
  RenderOptions render;
  char end;
  if (std::sscanf(options.size.c_str(), "%dx%d%c", &render.width, &render.height, &end) != 2) {
    throw InputError("--size " + options.size + ": is not WIDTHxHEIGHT, such as 640x480");
  }
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
  view.overlays = render.overlays | kOverlayText;
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
  if (!options.Lockstep()) {  // nothing measured is logged there
    telemetry.frames = &session->frames;
    telemetry.events = &session->render_events;
    telemetry.baseline = machine.baseline.wake_late;
    telemetry.stolen_time = StolenTime;
    telemetry.epoch_us = std::chrono::duration_cast<std::chrono::microseconds>(
                             std::chrono::system_clock::now().time_since_epoch())
                             .count();
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

void Run(const RunOptions& options) {
  if (options.window && (options.headless || !options.pictures)) {
    throw InputError(std::string("--window: contradicts ") +
                     (options.headless ? "--headless" : "--no-pictures") + "; leave one out");
  }
  const StopSignals signals;  // before any thread
  Scene scene = LoadScene(options.scene);
  std::vector<DeviceChoice> devices =
      ChooseDevices(options.devices, scene.instruments, options.window);
  if (options.Lockstep()) CheckLockstep(options, devices);
  Session session(std::move(scene), std::move(devices));
  const double seconds = options.seconds > 0 ? options.seconds : ToSeconds(session.trace_length());
  if (options.references.empty() &&
      std::count(options.overlays.begin(), options.overlays.end(), "error") > 0) {
    throw InputError(
        "--overlay error: has nothing to compare with; add --reference FILE, such as `hpdm solve "
        "--out` writes");
  }
  for (const std::string& reference : options.references) session.LoadReference(reference);
  for (const std::string& remark : session.remarks()) std::cerr << "hpdm: note: " << remark << "\n";
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
  const MachineState machine = TryMachine(options, session.haptic_period_ns());
  const SessionClock clock;
  std::optional<DeviceLink> link;
  if (session.HasExternalDevice()) {
    link.emplace(NetworkUrl(), clock,
                 DeviceLink::Edges{session.external_readings, session.external_forces});
  }
  const SessionFolder folder(
      options.out.empty() ? SessionFolder::FreeName() : std::filesystem::path(options.out),
      session.scene());
  if (options.pictures && options.FramesPerSecond() > 0) {
    render_options.frame_folder = folder.File("frames");
    render_options.frame_fps = options.FramesPerSecond();
  }
  render_options.screenshot_folder = folder.File("screenshots");

  std::function<Nanoseconds()> stopwatch;
  if (!options.Lockstep()) stopwatch = [&clock] { return clock.Now(); };
  HapticLoop haptics(session.HapticInstruments(), session.haptic_period_ns(),
                     {session.tool_states, session.patches, session.samples,
                      session.HasExternalDevice() ? &session.external_forces : nullptr});
  DeformationLoop deformation(session.organs(), session.DeformationTools(),
                              {session.tool_states, session.patches, *session.render_scenes,
                               *session.telemetry_scenes, &session.steps},
                              stopwatch);
  RenderLoop render(
      OrganViewsOf(options, session), session.InstrumentViews(), session.scene().laparoscope,
      render_options,
      {*session.render_scenes, options.Lockstep() ? nullptr : &session.frames,
       window ? &session.view_settings : nullptr, &session.health,
       options.Lockstep() ? nullptr : &session.render_events},
      stopwatch ? stopwatch : [] { return Nanoseconds{0}; }, make_context);
  TelemetryLoop telemetry(&session.samples, &session.steps, session.telemetry_scenes.get(),
                          folder.File("session.lcmlog"),
                          TelemetryOptionsOf(options, machine, folder, &session), session.Info());
  const std::uint64_t end_tick =
      seconds > 0
          ? static_cast<std::uint64_t>(std::llround(seconds * session.scene().timing.haptic_hz))
          : std::numeric_limits<std::uint64_t>::max();
  const Loops loops{session,          haptics,
                    deformation,      render,
                    telemetry,        link ? &*link : nullptr,
                    signals,          end_tick,
                    options.pictures, window ? &*window : nullptr};
  const RunRecord record =
      options.Lockstep() ? RunInLockstep(loops) : RunOnRealClock(loops, machine, clock);

  // A disk that fills up must not cost the summary: it is told after it.
  std::string not_kept = telemetry.Summary().log.Explain();
  const auto keep = [&not_kept](const auto& write) {
    try {
      write();
    } catch (const InputError& error) {
      if (not_kept.empty()) not_kept = error.what();
    }
  };
  keep([&] { WritePicture(render.deepest_image(), folder, "deepest.png"); });
  keep([&] { WritePicture(render.image(), folder, "last.png"); });
  const auto plot = [&folder](const char* script, const char* table, const char* picture) {
    const std::string missing = RunPlotScript(script, {folder.File(table), folder.File(picture)});
    if (!missing.empty()) std::cerr << "hpdm: note: " << picture << ": " << missing << "\n";
  };
  if (options.film && render.frames_written() > 0) {
    const std::string missing =
        MakeFilm(render_options.frame_folder, options.FramesPerSecond(), folder.File("film.mp4"));
    if (!missing.empty()) std::cerr << "hpdm: note: film.mp4: " << missing << "\n";
  }
  plot(kPlotTimelineScript, "timeline.csv", "timeline.png");
  if (!options.Lockstep()) {
    keep([&] {
      WriteTextFile(folder.File("latency.csv"),
                    LatencyTable(telemetry.Summary().session.latencies));
    });
    plot(kPlotLatencyScript, "latency.csv", "latency.png");
  }
  const nlohmann::ordered_json summary =
      RunSummary(session, record, telemetry.Summary(), options.pictures ? &render : nullptr);
  keep([&] { WriteTextFile(folder.File("summary.json"), JsonText(summary) + "\n"); });
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

void AddRunCommand(CLI::App& app) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* run = app.add_subcommand("run", "Run a session of a scene");
  run->add_option("scene", options->scene, "Scene file (TOML; see scenes/README.md)")->required();
  run->add_option(
         "--seconds", options->seconds,
         "Length; without it, until SIGINT or SIGTERM, Esc in the window, or the end of the "
         "traces")
      ->check(CLI::Range(0.001, 1e6));
  run->add_option("--out", options->out, "Session folder to make [out/session_N]");
  run->add_flag("--headless", options->headless, "Draw without a window (the default)");
  run->add_flag("--window", options->window,
                "Draw in a window; the mouse moves the instruments (F1 lists the keys)");
  run->add_option("--fps", options->frames_per_second,
                  "Pictures a second kept in frames/; 0 keeps none [2; in a window those that r "
                  "asks for, 30]")
      ->check(CLI::Range(0.0, 240.0));
  run->add_flag(
      "--film", options->film,
      "Make film.mp4 of the pictures in frames/, with ffmpeg; take --fps 30 for a smooth one");
  run->add_flag("!--no-pictures", options->pictures, "Draw nothing");
  run->add_option("--size", options->size, "Picture, WIDTHxHEIGHT")->capture_default_str();
  run->add_option("--overlay", options->overlays,
                  "Drawn over the picture, separated by commas: force, contacts, lattice, error "
                  "(see --reference), text")
      ->delimiter(',')
      ->check(CLI::IsMember({"force", "contacts", "lattice", "error", "text"}));
  run->add_option("--reference", options->references,
                  "Surface displacements that --overlay error compares an organ with: FILE as "
                  "`hpdm solve --out` writes it, or ORGAN=FILE; repeatable");
  run->add_option("--ffd", options->ffd,
                  "Who deforms the organs in the picture: cpu, shader, or auto: the shader, unless "
                  "the renderer is software or a lattice has more than 350 control points")
      ->transform(CLI::CheckedTransformer(kFfdPaths))
      ->default_str("auto");
  run->add_option("--clock", options->clock, "real, or lockstep: one thread, virtual time")
      ->check(CLI::IsMember({"real", "lockstep"}))
      ->capture_default_str();
  run->add_option("--device", options->devices,
                  "What moves the instruments: sim, trace:FILE (CSV), lcm (an external driver) or "
                  "mouse; NAME=... for one of them; repeatable [the scene's trace, or sim, in a "
                  "window mouse]");
  run->add_flag("--live", options->live,
                "Publish over LCM too (LCM_DEFAULT_URL, or this machine's multicast)");
  run->add_flag("--require-rt", options->require_realtime,
                "Exit with 3 when the system refuses real-time scheduling or memory locking");
  run->add_flag("--json", options->json, "Print the summary as JSON");
  run->callback([options] { Run(*options); });
}

}  // namespace hpdm
