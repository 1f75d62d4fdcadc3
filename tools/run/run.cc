#include <algorithm>
#include <cmath>
#include <csignal>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "engine/base/error.h"
#include "engine/checkpoints.h"
#include "engine/threads/stolen_time.h"
#include "lcmtypes/live/network.h"
#include "lcmtypes/live/wall_time.h"
#include "render/gl/egl_context.h"
#include "scenes/loader/scene_edit.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/run/log_space.h"
#include "tools/run/run_options.h"
#include "tools/run/run_results.h"
#include "tools/run/set_up_interrupt.h"
#include "tools/run/set_up_progress.h"
#include "tools/session/burn_tone.h"
#include "tools/session/picture_options.h"
#include "tools/session/session_folder.h"
#include "tools/session/session_path.h"
#include "tools/session/session_threads.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

const std::map<std::string, FfdPath> kFfdPaths = {
    {"auto", FfdPath::kAuto}, {"cpu", FfdPath::kCpu}, {"shader", FfdPath::kShader}};

std::vector<OrganVisual> OrganVisualsOf(const RunOptions& options, const Session& session) {
  std::vector<OrganVisual> visuals = session.OrganVisuals();
  for (OrganVisual& visual : visuals) visual.ffd = kFfdPaths.at(options.ffd);
  return visuals;
}

void LoadReferences(const RunOptions& options, Session* session) {
  for (const std::string& reference : options.references) session->LoadReference(reference);
}

// Opens the window, if there is one. Returns the factory of the render thread's context.
RenderContextFactory OpenDisplay(const RunOptions& options, const RenderOptions& render,
                                 Session* session, std::optional<TrainerWindow>* window) {
  if (!options.window) return HeadlessContext;
  ViewSettings view;
  view.scope = session->scene().laparoscope;
  view.overlays = kOverlayText | render.overlays;
  view.has_reference = !options.references.empty();
  view.has_exercise = session->ExerciseSteps() > 0;
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

double SecondsOf(const RunOptions& options, const Session& session) {
  return options.seconds > 0 ? options.seconds : ToSeconds(session.trace_length());
}

// Says what is known about the session before it runs: remarks, and a disk that is too small.
void NoteRemarks(const RunOptions& options, const Session& session, const SessionFolder& folder) {
  for (const std::string& remark : session.remarks()) Note(OneLine(remark));
  const Scene& scene = session.scene();
  std::error_code error;
  const std::uintmax_t available = std::filesystem::space(folder.path(), error).available;
  const std::string remark =
      error ? ""
            : LogSpaceRemark(LogBytesPerSecond(scene.instruments.size(), scene.timing.haptic_hz,
                                               OutputInterval(options, scene.timing.haptic_hz)),
                             SecondsOf(options, session), available);
  if (!remark.empty()) Note(remark);
}

// Says that the session runs now, and how it ends.
void SayRunning(const RunOptions& options, const Session& session, const SessionFolder& folder) {
  if (options.json) return;
  std::string line = "hpdm: running";
  if (const double seconds = SecondsOf(options, session); seconds > 0) {
    line += Format(" for %.3g s", seconds);
  }
  line += ", folder " + OneLine(folder.path().string()) + ", Ctrl-C ";
  if (options.window) line += "or Esc ";
  std::cerr << line + "ends\n";
}

std::filesystem::path OutOf(const RunOptions& options) {
  return options.out.empty() ? SessionFolder::FreeName() : std::filesystem::path(options.out);
}

SessionFolder MakeFolder(const RunOptions& options, const Session& session) {
  return SessionFolder(OutOf(options), session.scene(), TracesOf(session.device_choices()));
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
                                    const SessionFolder& folder, Checkpoints* checkpoints,
                                    Session* session) {
  TelemetryOptions telemetry;
  telemetry.progress = &checkpoints->progress();
  telemetry.live = options.live;
  telemetry.forces_linked = session->HasExternalDevice();
  telemetry.timeline_path = folder.File("timeline.csv");
  telemetry.haptic_period = session->haptic_period_ns();
  telemetry.output_interval = OutputInterval(options, session->scene().timing.haptic_hz);
  telemetry.health = &session->health;
  // Prints immediately, since the session may continue for long after a failure.
  telemetry.tell = [](const std::string& failure) { std::cerr << "hpdm: note: " + failure + "\n"; };
  if (!options.Lockstep()) {  // the lockstep clock logs no measured times
    telemetry.frames = &session->frames;
    telemetry.events = {&session->render_events, &session->link_events, &session->teacher_events};
    telemetry.baseline = machine.baseline.wake_late;
    telemetry.stolen_time = StolenTime;
    telemetry.epoch_us = WallTimeUs();
  }
  return telemetry;
}

std::uint64_t EndTick(const RunOptions& options, const Session& session) {
  const double seconds = SecondsOf(options, session);
  if (seconds <= 0) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(std::llround(seconds * session.scene().timing.haptic_hz));
}

// Reads what the session needs and refuses what cannot work, before the slow set-up.
struct Prepared {
  Scene scene;
  std::vector<DeviceChoice> devices;
  ControlScript controls;
};

Prepared Prepare(RunOptions* options) {
  CheckOptions(*options);
  SessionFolder::RefuseExisting(OutOf(*options));
  Prepared prepared;
  prepared.scene = LoadScene(options->scene);
  if (options->left_handed) {
    if (prepared.scene.instruments.size() < 2) {
      throw InputError(
          "--left-handed: " + OneLine(options->scene) +
          " has fewer than two instruments, which would exchange their ports; leave it "
          "out");
    }
    prepared.scene = ParseScene(LeftHandedScene(prepared.scene), options->scene);
  }
  OutputInterval(*options, prepared.scene.timing.haptic_hz);
  const std::string no_window = ChooseWindow(options);
  prepared.devices = ChooseDevices(options->devices, prepared.scene.instruments, options->window);
  if (options->Lockstep()) CheckLockstep(*options, prepared.devices);
  prepared.controls =
      ParseControls({options->exchanges, options->pedals, options->restarts}, prepared.scene);
  if (options->pictures && !options->window) EglContext();  // a machine that cannot draw
  if (!no_window.empty()) std::cerr << "hpdm: " + no_window + "\n";
  return prepared;
}

// Returns the link to the external drivers; null without one.
std::unique_ptr<DeviceLink> OpenLink(const SessionClock& clock, Session* session) {
  if (!session->HasExternalDevice()) return nullptr;
  return std::make_unique<DeviceLink>(NetworkUrl(), clock, session->LinkEdges());
}

// Returns the clock of the loops' measurements; none in lockstep.
std::function<Nanoseconds()> StopwatchOf(bool measured, const SessionClock& clock) {
  if (!measured) return {};
  return [&clock] { return clock.Now(); };
}

RenderLoop::Edges RenderEdges(const RunOptions& options, Session* session) {
  const bool measured = !options.Lockstep();
  return {*session->render_scenes,
          measured ? &session->frames : nullptr,
          options.window ? &session->view_settings : nullptr,
          &session->health,
          measured ? &session->render_events : nullptr,
          options.teacher ? &session->picture_marks : nullptr};
}

// A write beyond the file size limit or to a closed pipe is reported and does not end the session.
void IgnoreFailedWrites() {
  for (const int failed_write : {SIGXFSZ, SIGPIPE}) std::signal(failed_write, SIG_IGN);
}

// Deletes the session's folder unless the session begins: a set-up that fails leaves nothing that
// would refuse the next one.
class FolderUntilBegun {
 public:
  explicit FolderUntilBegun(SessionFolder* folder) : folder_(folder) {}
  ~FolderUntilBegun() {
    if (folder_ != nullptr) folder_->Discard();
  }
  FolderUntilBegun(const FolderUntilBegun&) = delete;
  FolderUntilBegun& operator=(const FolderUntilBegun&) = delete;
  void Begin() { folder_ = nullptr; }

 private:
  SessionFolder* folder_;
};

// Ends the program as SetUpInterrupt does if the user ended the session before its first tick.
void DiscardUnlessBegun(const RunRecord& record, SessionFolder* folder) {
  if (!record.ended_by_user || record.haptic.ticks > 0) return;
  folder->Discard();
  std::cerr << SetUpInterrupt::kText;
  throw CheckFailed{SetUpInterrupt::kExitCode};
}

// Builds the session and its loops and wires them. session_threads.h shows the edges and threads.
void Run(RunOptions options, const std::vector<std::string>& command_line) {
  const StopSignals signals;  // before any thread
  IgnoreFailedWrites();
  std::optional<SetUpInterrupt> interrupt(signals);
  auto [scene, devices, controls] = Prepare(&options);
  RefuseCuts(scene);
  SetUpProgress progress(options.json);
  Session session(std::move(scene), std::move(devices),
                  [&progress](const std::string& what) { progress.Say(what); });
  LoadReferences(options, &session);

  RenderOptions render_options = RenderOptionsOf(options.size, options.overlays, session);
  render_options.limits = options.limits;
  render_options.palette =
      options.palette == "colour-blind" ? Palette::kColourBlind : Palette::kStandard;
  std::optional<TrainerWindow> window;
  const auto make_context = OpenDisplay(options, render_options, &session, &window);
  if (!options.Lockstep()) progress.Say("the clock: an empty loop runs for a second");
  const MachineState machine =
      ProbeRealtime(options.Lockstep(), options.require_realtime, session.haptic_period_ns());
  const SessionClock clock;
  const std::unique_ptr<DeviceLink> link = OpenLink(clock, &session);
  std::optional<TeacherLink> teacher_link;
  TeacherDesk teacher(session.TeacherEdges());
  if (options.teacher) teacher_link.emplace(NetworkUrl(), &session.teacher_requests);
  progress.Clear();
  interrupt.reset();  // a later signal ends the loops
  SessionFolder folder = MakeFolder(options, session);
  FolderUntilBegun unbegun(&folder);
  NoteRemarks(options, session, folder);
  SetPictureFolders(options, folder, &render_options);
  const bool measured = !options.Lockstep();
  const std::function<Nanoseconds()> stopwatch = StopwatchOf(measured, clock);

  HapticLoop haptics(
      session.HapticInstruments(), session.haptic_period_ns(),
      {session.tool_states, session.patches, session.samples,
       session.HasExternalDevice() ? &session.external_forces : nullptr, &session.control});
  Checkpoints checkpoints(session.ExerciseSteps());
  DeformationLoop deformation(session.organs(), session.DeformationTools(),
                              {session.tool_states, session.patches, *session.render_scenes,
                               *session.telemetry_scenes, &session.steps, &checkpoints},
                              stopwatch, session.scene().timing.StepBudget(),
                              session.scene().attachments, session.scene().ducts);
  checkpoints.MakeRoom(deformation);
  RenderLoop render(
      OrganVisualsOf(options, session), session.InstrumentVisuals(), session.scene().laparoscope,
      render_options, RenderEdges(options, &session),
      measured ? stopwatch : [] { return Nanoseconds{0}; }, make_context);
  TelemetryLoop telemetry(&session.samples, &session.steps, session.telemetry_scenes.get(),
                          folder.File(kSessionLogName),
                          TelemetryOptionsOf(options, machine, folder, &checkpoints, &session),
                          session.Info());
  std::optional<BurnTone> tone;
  if (window && options.sound) tone.emplace();
  if (tone && options.verbose && !tone->failure().empty()) Note(tone->failure());
  const Loops loops{session,
                    haptics,
                    deformation,
                    render,
                    telemetry,
                    link.get(),
                    signals,
                    EndTick(options, session),
                    options.pictures,
                    window ? &*window : nullptr,
                    &controls,
                    options.teacher ? &teacher : nullptr,
                    tone ? &*tone : nullptr};
  unbegun.Begin();
  SayRunning(options, session, folder);
  const RunRecord record = measured ? RunOnRealClock(loops, machine, clock) : RunInLockstep(loops);
  window.reset();  // gives the pointer back before the results are written, which takes a while

  DiscardUnlessBegun(record, &folder);
  for (const std::string& control : controls.Left()) {
    Note(control + " did not happen: the session ended before");
  }
  const TelemetrySummary results = telemetry.Summary();
  FinishRun(options, command_line.front(),
            RunSummary(session, record, results, options.pictures ? &render : nullptr, command_line,
                       folder),
            results, render, &folder);
}

}  // namespace

void AddRunCommand(Command app, std::vector<std::string> command_line) {
  auto options = std::make_shared<RunOptions>();
  Command run = app.AddCommand("run", "Run a session of a scene");
  AddRunOptions(run, options.get());
  run.OnRun([options, command_line = std::move(command_line)] { Run(*options, command_line); });
}

}  // namespace hpdm
