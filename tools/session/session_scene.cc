#include "tools/session/session_scene.h"

#include <optional>

#include "engine/base/error.h"
#include "scenes/loader/scene_files.h"
#include "scenes/loader/toml_document.h"
#include "tools/session/session_path.h"

namespace hpdm {
namespace {

// s, after the last touch: the iterations of a finite strain that has to be brought back by load
// steps take up to a second.
constexpr double kSettled = 1;
// Relaxation times in which a creep of centimetres fades to less than a nanometre: e^-18.
constexpr double kCreeps = 18;

// s; empty: with a motion of its own, or relaxed as far as sweeps get.
std::optional<double> SettlesIn(const OrganOptions& organ) {
  if (organ.model != OrganModelType::kHpdm) return std::nullopt;
  if (organ.energy.solver == SolverType::kGaussSeidel) return std::nullopt;
  const double settled = organ.energy.strain != StrainMeasure::kSmall ? kSettled : 0;
  return settled + kCreeps * organ.material.relaxation_time;
}

}  // namespace

std::filesystem::path SceneBeside(const std::filesystem::path& log) {
  return log.parent_path() / "scene.toml";
}

Scene LoadRecordedScene(const std::filesystem::path& path) {
  const std::filesystem::path folder = path.parent_path();
  if (LeadsOutside(folder, path.filename())) {
    throw InputError(path.string() + ": is a link out of the session folder, which alone is read");
  }
  Scene scene = LoadScene(path);
  for (const SceneFile& file : scene.files) {
    if (LiesInside(folder, file.path)) continue;
    throw InputError(path.string() + ": " + Quoted(file.name) +
                     " lies outside of the session folder, which alone is read");
  }
  return scene;
}

SessionLimits LimitsOf(const Scene& scene) {
  SessionLimits limits;
  for (const InstrumentOptions& instrument : scene.instruments) {
    const DeviceProfile& device = instrument.device;
    limits.tools.push_back(
        {.max_force = device.max_force, .slew = device.max_force_rate / scene.timing.haptic_hz});
  }
  for (const OrganOptions& organ : scene.organs) {
    limits.settles.push_back(SettlesIn(organ));
    const OrganMotion& motion = organ.motion;
    limits.still = limits.still && (motion.frequency == 0 || motion.displacement_W.isZero(0));
  }
  return limits;
}

}  // namespace hpdm
