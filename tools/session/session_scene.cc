#include "tools/session/session_scene.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/quoted_token.h"
#include "engine/mesh/mesh_edges.h"
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

bool Breathes(const OrganOptions& organ) {
  return organ.motion.frequency != 0 && !organ.motion.displacement_W.isZero(0);
}

// True if the organ moves without tools: it breathes, or is free.
bool Moves(const OrganOptions& organ) { return organ.free || Breathes(organ); }

// Returns for each organ the first of the organs that it touches by [[contact]], directly or through
// others; itself if there is none before it.
std::vector<std::size_t> FirstPushing(const std::vector<OrganOptions>& organs) {
  DisjointSets sets(static_cast<int>(organs.size()));
  for (std::size_t a = 0; a < organs.size(); ++a) {
    for (const OrganContactOptions& contact : organs[a].contacts) {
      const auto other = std::find_if(organs.begin(), organs.end(), [&](const OrganOptions& organ) {
        return organ.name == contact.with;
      });
      sets.Merge(static_cast<int>(a), static_cast<int>(other - organs.begin()));
    }
  }
  std::vector<std::size_t> first;
  for (int o = 0; o < static_cast<int>(organs.size()); ++o) first.push_back(ToSize(sets.Find(o)));
  return first;
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

bool OrgansAreStill(const Scene& scene) {
  return std::none_of(scene.organs.begin(), scene.organs.end(), Breathes);
}

SessionLimits LimitsOf(const Scene& scene) {
  SessionLimits limits;
  for (const InstrumentOptions& instrument : scene.instruments) {
    const DeviceProfile& device = instrument.device;
    limits.tools.push_back(
        {.max_force = device.max_force, .slew = device.max_force_rate / scene.timing.haptic_hz});
  }
  limits.still = OrgansAreStill(scene);
  limits.pushing = FirstPushing(scene.organs);
  std::vector<bool> carried(scene.organs.size());  // by the first organ: one of them moves
  for (std::size_t o = 0; o < scene.organs.size(); ++o) {
    if (Moves(scene.organs[o])) carried[limits.pushing[o]] = true;
  }
  for (std::size_t o = 0; o < scene.organs.size(); ++o) {
    const OrganOptions& organ = scene.organs[o];
    const std::size_t first = limits.pushing[o];
    const bool pushes = std::count(limits.pushing.begin(), limits.pushing.end(), first) > 1;
    // A torn attachment or a cut duct leaves its organs elsewhere, a free organ stays where it is laid, and an
    // organ that moves pushes others.
    const bool returns = !organ.free && !IsAttached(scene.attachments, organ.name) &&
                         !HoldsDuct(scene.ducts, organ.name) && !(pushes && carried[first]);
    limits.settles.push_back(returns ? SettlesIn(organ) : std::nullopt);
  }
  return limits;
}

}  // namespace hpdm
