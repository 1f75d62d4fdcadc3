#include "tools/session/session_scene.h"

#include <algorithm>
#include <optional>

#include "engine/base/error.h"
#include "engine/base/quoted_token.h"
#include "scenes/loader/scene_files.h"
#include "tools/session/session_path.h"

namespace hpdm {
namespace {

// s after the last touch: in finite strain, load steps may take up to a second to bring the organ
// back.
constexpr double kSettled = 1;
// Number of relaxation times in which a creep of centimetres fades below a nanometre: e^-18.
constexpr double kCreeps = 18;

// Returns the time after which an untouched organ is at rest, s; nothing if it moves by itself or
// its sweeps do not converge.
std::optional<double> SettlesIn(const OrganOptions& organ) {
  if (organ.model != OrganModelType::kHpdm) return std::nullopt;
  if (organ.energy.solver == SolverType::kGaussSeidel) return std::nullopt;
  const double settled = organ.energy.strain != StrainMeasure::kSmall ? kSettled : 0;
  const PronySeries& prony = organ.material.prony;
  double slowest = 0;  // s: a branch without force returns in tau / (1 - sum g) or less
  for (int k = 0; k < prony.count; ++k) {
    slowest = std::max(slowest, prony.terms[static_cast<std::size_t>(k)].time);
  }
  return settled + kCreeps * slowest * prony.InstantaneousFactor();
}

}  // namespace

std::filesystem::path SceneBeside(const std::filesystem::path& log) {
  return log.parent_path() / "scene.toml";
}

Scene LoadRecordedScene(const std::filesystem::path& path) {
  const std::filesystem::path folder = path.parent_path();
  if (LeadsOutside(folder, path.filename())) {
    throw InputError(path.string() +
                     ": is a link out of the session folder; copy the file into the folder");
  }
  Scene scene = LoadScene(path);
  for (const SceneFile& file : scene.files) {
    if (LiesInside(folder, file.path)) continue;
    throw InputError(path.string() + ": " + Quoted(file.name) +
                     " is outside the session folder; copy the file into the folder");
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
    // A torn attachment leaves its organs elsewhere.
    const bool attached = IsAttached(scene.attachments, organ.name);
    limits.settles.push_back(attached ? std::nullopt : SettlesIn(organ));
    const OrganMotion& motion = organ.motion;
    limits.still = limits.still && (motion.frequency == 0 || motion.displacement_W.isZero(0));
  }
  return limits;
}

}  // namespace hpdm
