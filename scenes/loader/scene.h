#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/attachment/attachment_options.h"
#include "engine/base/types.h"
#include "engine/duct/duct_options.h"
#include "engine/exercise/exercise_options.h"
#include "engine/organ_options.h"
#include "engine/snapshots.h"
#include "haptics/device/instrument_options.h"
#include "render/camera/laparoscope_options.h"
#include "scenes/loader/scene_files.h"

namespace hpdm {

/// Rates of the loops. Whole numbers, so that the lockstep clock's steps fall on exact ticks.
struct TimingOptions {
  int haptic_hz = 1000;
  int deformation_hz = 30;
  int render_hz = 30;
  int patch_delay_ticks = 34;  ///< Lockstep: ticks from a step's start until its patch is visible.
                               ///< Default: one step, ceil(haptic_hz / deformation_hz).
  double step_budget = 0.8;    ///< Real clock: share of the step's period beyond which the loop
                               ///< sheds load; 0 never sheds.

  Nanoseconds StepBudget() const {
    return static_cast<Nanoseconds>(step_budget * kNanosecondsPerSecond / deformation_hz);
  }
};

/// The validated contents of a scene file, in SI units and the world frame. scenes/README.md
/// documents the file format.
struct Scene {
  std::filesystem::path path;    ///< As given to LoadScene.
  std::string source_text;       ///< The file's text as read, so that a session can keep a copy.
  std::vector<SceneFile> files;  ///< Every file named below, each once.
  bool recorded = false;         ///< The file has [[file]] tables; every hash has been verified.

  std::string name;        ///< Default: the file's name without its extension.
  std::string background;  ///< Path of a picture, or empty.
  /// The first two instruments have exchanged their ports: trocar, its friction, and device.
  bool left_handed = false;
  TimingOptions timing;
  std::vector<OrganOptions> organs;  ///< 1 to kMaxOrgans, names unique.
  std::vector<AttachmentOptions> attachments;
  std::vector<DuctOptions> ducts;              ///< Names unique.
  std::vector<InstrumentOptions> instruments;  ///< 0 to kMaxInstruments, names unique.
  std::vector<LoadOptions> loads;
  std::optional<ExerciseOptions> exercise;
  LaparoscopeOptions laparoscope;
};

/// Reads and validates a scene file. File names in it are relative to the scene's folder. The
/// returned paths exist; like `path` they are absolute or relative to the working folder.
///
/// Throws InputError at the first fault: one line, `FILE:LINE:COLUMN: key.path: problem (value);
/// remedy`. Refuses unknown keys and unsupported values. Set-up only: allocates and reads files.
Scene LoadScene(const std::filesystem::path& path);

}  // namespace hpdm
