#include "tools/run/run_options.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "lcmtypes/live/network.h"
#include "render/window/window.h"
#include "tools/session/picture_options.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

// Adds the options of what is drawn.
void AddPictureOptions(Command run, RunOptions* options) {
  run.AddOption("--fps", options->frames_per_second,
                "Pictures per second kept in frames/; 0 keeps none [2; in a window 30, while r "
                "records]")
      .From(0.0, 240.0);
  run.AddFlag(
      "--film", options->film,
      "Make film.mp4 from the pictures in frames/ with ffmpeg; use --fps 30 for a smooth film");
  run.AddFlag("!--no-pictures", options->pictures, "Draw nothing");
  run.AddFlag("!--no-sound", options->sound, "Make no tone while a hook burns in a window");
  run.AddOption("--size", options->size, "Picture size, WIDTHxHEIGHT").ShowDefault();
  run.AddOption("--overlay", options->overlays,
                "Overlays, separated by commas: force (0 to 2 N), contacts, lattice, error (see "
                "--reference), text")
      .SplitAt(',')
      .OneOf(OverlayNames());
  run.AddOption(
         "--palette", options->palette,
         "Colours of texts and bars in the picture: standard, or colour-blind: those of Okabe "
         "and Ito, with \"! \" before alarms")
      .OneOf({"standard", "colour-blind"})
      .ShowDefault();
  run.AddOption("--reference", options->references,
                "Surface displacements that --overlay error compares an organ with: FILE as "
                "`hpdm solve --out` writes it, or ORGAN=FILE; repeatable");
  run.AddOption(
         "--ffd", options->ffd,
         "Processor that deforms the organs in the picture: cpu, shader, or auto: the shader, "
         "unless the renderer is software or a lattice has more than 350 control points")
      .OneOf({"auto", "cpu", "shader"})
      .ShowDefault();
}

}  // namespace

void CheckOptions(const RunOptions& options) {
  if (options.window && (options.headless || !options.pictures)) {
    throw InputError(std::string("--window cannot be combined with ") +
                     (options.headless ? "--headless" : "--no-pictures") + "; leave one out");
  }
  if (options.film && (!options.pictures || options.FramesPerSecond() == 0)) {
    throw InputError(std::string("--film cannot be combined with ") +
                     (options.pictures ? "--fps 0" : "--no-pictures") + "; leave one out");
  }
  if (options.references.empty() &&
      std::count(options.overlays.begin(), options.overlays.end(), "error") > 0) {
    throw InputError(
        "--overlay error: no reference to compare with; add --reference FILE, such as `hpdm solve "
        "--out` writes");
  }
  ParsePictureSize(options.size);
  if (options.live || options.teacher) NetworkUrl();
}

void CheckLockstep(const RunOptions& options, const std::vector<DeviceChoice>& devices) {
  if (options.window) throw InputError("--window needs --clock real");
  if (options.teacher) throw InputError("--teacher needs --clock real");
  bool ends = options.seconds > 0 || !devices.empty();
  for (const DeviceChoice& device : devices) {
    if (device.type == DeviceChoice::Type::kLcm) {
      throw InputError("--device lcm needs --clock real");
    }
    ends &= options.seconds > 0 || device.type == DeviceChoice::Type::kTrace;
  }
  if (!ends) throw InputError("--clock lockstep needs a length; add --seconds N");
}

int OutputInterval(const RunOptions& options, int haptic_hz) {
  if (!options.log_rate) return 1;
  if (*options.log_rate > haptic_hz) {
    const std::string most = std::to_string(haptic_hz);
    throw InputError(Format("--log-rate %g: the haptic loop runs at %s Hz; give 1 to %s",
                            *options.log_rate, most.c_str(), most.c_str()));
  }
  return static_cast<int>(std::lround(haptic_hz / *options.log_rate));
}

std::string ChooseWindow(RunOptions* options) {
  if (options->window) Window::RequireDisplay();
  if (options->window || options->Unattended()) return {};
  try {
    Window::RequireDisplay();
    options->window = true;
    return {};
  } catch (const MachineError&) {
    return "no display: the session runs without a window";
  }
}

void AddRunOptions(Command run, RunOptions* options) {
  run.AddOption("scene", options->scene, "Scene file (TOML; see scenes/README.md)").Required();
  run.AddOption("--seconds", options->seconds,
                "Length in s [until Ctrl-C, SIGTERM or SIGHUP, Esc in the window, or the end of "
                "the traces]")
      .From(0.001, 1e6);
  run.AddOption("--out", options->out, "Session folder to create [out/session_N]");
  run.AddFlag("--headless", options->headless,
              "Draw without a window (the default without a display)");
  run.AddFlag(
      "--window", options->window,
      "Draw in a window; the mouse moves the instruments (F1 lists the keys) [with a display, "
      "unless --headless, --no-pictures, --film, --json, --exchange, --pedal, --restart or --clock "
      "lockstep]");
  AddPictureOptions(run, options);
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
  run.AddOption("--pedal", options->pedals,
                "NAME@FROM-TO: the pedal of the hand that began with NAME is pressed between these "
                "times, s; repeatable")
      .Excludes("--window");
  run.AddOption(
         "--restart", options->restarts,
         "STEP@SECONDS: at that time the exercise returns to the beginning of its step of this "
         "number, from 1, if it has begun; repeatable")
      .Excludes("--window");
  run.AddFlag("--left-handed", options->left_handed,
              "The first two instruments exchange their ports (scene.left_handed in "
              "scenes/README.md); the session's scene and log keep it");
  run.AddOption("--force-limit", options->limits.force, "Force with an alarm on the screen, N")
      .From(1e-6, 1e6)
      .ShowDefault();
  run.AddOption("--depth-limit", options->limits.depth,
                "Depth of a press with an alarm on the screen, m")
      .From(1e-6, 10)
      .ShowDefault();
  run.AddOption("--log-rate", options->log_rate,
                "Forces and shapes in the log, Hz; besides each change of contact and new peak. "
                "Inputs are always complete, so that the log can be replayed [every tick]")
      .From(1.0, 1e6);
  run.AddFlag("--live", options->live,
              "Also publish over LCM (LCM_DEFAULT_URL, or this machine's multicast)");
  run.AddFlag(
      "--teacher", options->teacher,
      "Also listen to a teacher on the same network: `hpdm teach` pauses, points, lets tissue "
      "bleed and restarts a step; messages are not authenticated");
  run.AddFlag("--require-rt", options->require_realtime,
              "Exit with 3 if the system refuses real-time scheduling or memory locking");
  Option json = run.AddFlag("--json", options->json, "Print the summary as JSON, and no progress");
  run.AddFlag("--verbose", options->verbose,
              "Print rates, latencies and the real-time state too; summary.json has them always")
      .Excludes(json);
}

}  // namespace hpdm
