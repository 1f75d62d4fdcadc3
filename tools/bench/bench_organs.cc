#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/AABB.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <utility>

#include "engine/mesh/collision.h"
#include "tools/bench/bench_results.h"
#include "tools/haptics/scene_press.h"
#include "tools/session/lockstep.h"
#include "tools/session/session.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using FclModel = fcl::BVHModel<fcl::AABB<double>>;

const fs::path kAbdomen = "scenes/abdomen_on_springs.toml";
// The scenes whose steps are timed. In the second one the liver breathes onto the stomach.
const std::array<fs::path, 2> kTimedScenes = {kAbdomen, "scenes/liver_on_stomach.toml"};
constexpr double kReach = 0.002;  // m: OrganPair's margin at rest

std::vector<Vector3d> VerticesOf(const SurfaceMesh& mesh) {
  std::vector<Vector3d> vertices;
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    vertices.emplace_back(mesh.vertices.row(v));
  return vertices;
}

std::shared_ptr<FclModel> FclModelOf(const SurfaceMesh& mesh) {
  std::vector<fcl::Triangle> triangles;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    triangles.emplace_back(mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2));
  }
  auto model = std::make_shared<FclModel>();
  model->beginModel();
  model->addSubModel(VerticesOf(mesh), triangles);
  model->endModel();
  return model;
}

// Two organs as they are drawn.
struct TwoOrgans {
  std::string name;
  SurfaceMesh first, second;
};

// The pairs of the scene's contacts at rest and as they are most pressed on each other.
std::vector<TwoOrgans> PairsOfScene() {
  std::vector<TwoOrgans> pairs;
  double most = -1;
  std::size_t rest_count = 0;
  const auto seen = [&](OrganBench* bench) {
    for (const bool at_rest : {true, false}) {
      double force = 0;
      for (int o = 0; o < bench->organs(); ++o) force += bench->PairForce(o).norm();
      if (at_rest ? rest_count > 0 : force <= most) continue;
      if (!at_rest) {
        most = force;
        pairs.resize(rest_count);
      }
      for (int a = 0; a < bench->organs(); ++a) {
        for (const OrganContactOptions& contact : bench->model(a).options().contacts) {
          for (int b = 0; b < bench->organs(); ++b) {
            if (bench->model(b).options().name != contact.with) continue;
            pairs.push_back({bench->model(a).options().name + ", " + contact.with +
                                 (at_rest ? ", at rest" : ", pressed"),
                             bench->Drawn(a), bench->Drawn(b)});
          }
        }
      }
      if (at_rest) rest_count = pairs.size();
    }
  };
  const ScenePress press{.name = {},
                         .organ = "liver",
                         .place_W = Vector3d(0.115, 0.01, 0.028),
                         .direction_W = Vector3d(0.2, 0, -1)};
  PressInScene(kAbdomen, press, 0.02, seen);
  return pairs;
}

PairSearchResults TimeSearch(const TwoOrgans& pair, const RepeatOptions& repeats) {
  PairSearchResults row;
  row.pair = pair.name;
  row.first_triangles = static_cast<int>(pair.first.triangles.rows());
  row.second_triangles = static_cast<int>(pair.second.triangles.rows());
  SurfaceTree first(pair.first.vertices, pair.first.triangles),
      second(pair.second.vertices, pair.second.triangles);
  const auto fcl_first = FclModelOf(pair.first), fcl_second = FclModelOf(pair.second);
  const fcl::Transform3d here = fcl::Transform3d::Identity();
  const std::vector<Vector3d> vertices = VerticesOf(pair.first);
  const auto search = [&](double reach) {
    row.found = 0;
    first.VisitNear(second, Vector3d::Zero(), reach, [&](int) { ++row.found; });
  };
  const auto collide = [&] {
    fcl::CollisionRequestd request(1 << 20, false);
    fcl::CollisionResultd result;
    row.fcl_found = static_cast<int>(
        fcl::collide(fcl_first.get(), here, fcl_second.get(), here, request, result));
  };
  const auto distance = [&] {
    fcl::DistanceRequestd request;
    fcl::DistanceResultd result;
    fcl::distance(fcl_first.get(), here, fcl_second.get(), here, request, result);
  };
  const auto refit = [&] {
    fcl_first->beginReplaceModel();
    fcl_first->replaceSubModel(vertices);
    fcl_first->endReplaceModel(true, true);
  };
  const auto times = TimeInTurn({[&] { search(kReach); }, collide, distance,
                                 [&] { first.Refit(pair.first.vertices); }, refit},
                                repeats);
  row.own = Summary(times[0]);
  row.fcl_collide = Summary(times[1]);
  row.fcl_distance = Summary(times[2]);
  row.own_refit = Summary(times[3]);
  row.fcl_refit = Summary(times[4]);
  return row;
}

// The session of the scene's own hands in lockstep; each step's CPU time.
StepTimes TimeSteps(const fs::path& scene, int seconds) {
  const auto session = std::make_unique<Session>(LoadScene(scene));
  const auto cpu_time = [] { return static_cast<Nanoseconds>(1e6 * ThreadMilliseconds()); };
  DeformationLoop deformation(
      session->organs(), session->DeformationTools(),
      {session->tool_states, session->patches, *session->render_scenes, *session->telemetry_scenes},
      cpu_time);
  HapticLoop haptics(session->HapticInstruments(), session->haptic_period_ns(),
                     {session->tool_states, session->patches, session->samples});
  Lockstep clock(session->scene().timing, &haptics, &deformation);
  ForcesOn forces(session.get());
  StepTimes times{.scene = scene.filename()};
  const auto end = static_cast<std::uint64_t>(seconds * session->scene().timing.haptic_hz);
  while (clock.tick() < end) {
    if (clock.StepIfDue()) {
      times.all.Add(deformation.record().compute_ns);
      int pair_rows = 0;
      for (int o = 0; o < static_cast<int>(session->organs().size()); ++o) {
        const ContactConstraints& contacts = deformation.organ(o).contacts;
        pair_rows = std::max(pair_rows, contacts.size() - contacts.tool_rows());
      }
      if (pair_rows > 0) times.touching.Add(deformation.record().compute_ns);
      times.most_contacts = std::max(times.most_contacts, pair_rows);
    }
    clock.Tick();
    HapticSample sample;
    while (session->samples.Pop(&sample)) {
    }
  }
  return times;
}

}  // namespace

std::optional<OrganResults> TimeOrgans(bool quick) {
  if (!fs::exists(kAbdomen)) return std::nullopt;
  OrganResults results;
  for (const TwoOrgans& pair : PairsOfScene()) {
    results.searches.push_back(
        TimeSearch(pair, quick ? RepeatOptions{3, 50, 100} : RepeatOptions{5, 1000, 1000}));
  }
  for (const fs::path& scene : kTimedScenes) {
    results.steps.push_back(TimeSteps(scene, quick ? 3 : 12));
  }
  return results;
}

}  // namespace hpdm
