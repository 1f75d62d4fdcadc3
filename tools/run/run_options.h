#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/base/handling_limits.h"
#include "tools/command_line.h"
#include "tools/session/device_choice.h"

namespace hpdm {

/// The options of `hpdm run`.
struct RunOptions {
  std::string scene;
  double seconds = 0;  ///< 0: until a signal
  std::string out;     ///< Empty: the first free name
  std::optional<double> frames_per_second;
  std::string size = "640x480";
  std::string clock = "real";
  std::string ffd = "auto";
  std::vector<std::string> overlays;
  std::vector<std::string> references;
  std::vector<std::string> devices;
  std::vector<std::string> exchanges;
  std::vector<std::string> pedals;
  std::vector<std::string> restarts;
  HandlingLimits limits;
  std::optional<double> log_rate;  ///< Outputs in the log, Hz; empty: every tick's
  std::string palette = "standard";
  bool left_handed = false;
  bool film = false;
  bool pictures = true;
  bool sound = true;
  bool headless = false;
  bool window = false;
  bool live = false;
  bool teacher = false;
  bool require_realtime = false;
  bool json = false;
  bool verbose = false;

  bool Lockstep() const { return clock == "lockstep"; }
  /// True if the options ask for something that nobody needs to watch, or that a window excludes.
  bool Unattended() const {
    return headless || !pictures || film || json || Lockstep() || !exchanges.empty() ||
           !pedals.empty() || !restarts.empty();
  }
  /// Rate of the pictures kept in frames/. In a window the user starts the recording.
  double FramesPerSecond() const { return frames_per_second.value_or(window ? 30 : 2); }
};

/// Adds the options to the command `run`, bound to `options`.
void AddRunOptions(Command run, RunOptions* options);

/// Refuses options that contradict each other, before anything is built. Throws InputError.
void CheckOptions(const RunOptions& options);
/// The same for the lockstep clock and the devices. Throws InputError.
void CheckLockstep(const RunOptions& options, const std::vector<DeviceChoice>& devices);

/// Returns TelemetryOptions::output_interval. Throws InputError if the haptic loop is slower than
/// --log-rate.
int OutputInterval(const RunOptions& options, int haptic_hz);

/// Decides whether the session has a window: with --window, or with a display unless
/// options.Unattended(). Returns one line for the user if only the lack of a display decided, else
/// an empty string. Throws MachineError if --window was given and no display can be reached. Main
/// thread.
std::string ChooseWindow(RunOptions* options);

}  // namespace hpdm
