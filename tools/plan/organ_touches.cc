#include "tools/plan/organ_touches.h"

#include <algorithm>
#include <limits>

#include "engine/base/error.h"
#include "engine/baselines/skin.h"
#include "engine/contact/surface_kernel.h"
#include "engine/mesh/collision.h"
#include "engine/mesh/surface_topology.h"
#include "engine/tissue/support.h"
#include "haptics/device/impulse_engine.h"
#include "tools/session/hand_site.h"
#include "tools/shared/with_scene_path.h"

namespace hpdm {
namespace {

constexpr std::size_t kMinPlaces = 3;
constexpr double kStrays = 0.25;        // share of the organ's size: largest distance from a hand's
                                        // target
constexpr double kMinFacing = 0.5;      // cos 60 degrees, between the normal and the direction to
                                        // the trocar
constexpr double kMinTipRadius = 1e-3;  // m: the smallest tip's kernel, as in a session

/// The reach of an instrument.
struct Reach {
  ImpulseEngineKinematics kinematics;
  HandSite site;
  std::size_t organ = 0;  // the hand's target
};

/// Returns the vertices of one organ that an instrument reaches.
std::vector<Eigen::Index> ReachedVertices(const Reach& reach, const OrganOptions& organ,
                                          const SurfaceMesh& rest, const Points& normals) {
  const Box bounds = AxisAlignedBounds(rest.vertices);
  std::vector<Eigen::Index> reached;
  for (Eigen::Index v = 0; v < rest.vertices.rows(); ++v) {
    const Vector3d p = rest.vertices.row(v);
    const Vector3d way = (reach.kinematics.p_trocar_W() - p).normalized();
    if (normals.row(v).dot(way) < kMinFacing) continue;
    const bool held = std::any_of(
        organ.supports.begin(), organ.supports.end(),
        [&](const SupportOptions& support) { return InRegion(support.region, bounds, p); });
    if (!held && reach.kinematics.Inverse(p, 0, 1).reachable) reached.push_back(v);
  }
  return reached;
}

LoadOptions Press(const OrganOptions& organ, const Vector3d& p_W, const Vector3d& outward,
                  double tip_radius) {
  LoadOptions press;
  press.organ = organ.name;
  press.p_centre_W = p_W;
  press.radius = std::max(tip_radius, kMinTipRadius);
  press.force_W = -outward.normalized();
  return press;
}

/// Returns the vertex farthest from all places, or -1.
Eigen::Index Farthest(const SurfaceMesh& rest, const std::vector<Eigen::Index>& vertices,
                      const std::vector<LoadOptions>& places) {
  Eigen::Index farthest = -1;
  double largest = 0;
  for (const Eigen::Index v : vertices) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const LoadOptions& place : places) {
      nearest = std::min(nearest, (rest.vertices.row(v).transpose() - place.p_centre_W).norm());
    }
    if (nearest > largest) {
      largest = nearest;
      farthest = v;
    }
  }
  return farthest;
}

OrganTouches PressesOf(const Scene& scene, const std::vector<Reach>& reaches, std::size_t organ,
                       const SurfaceMesh& rest) {
  const OrganOptions& options = scene.organs[organ];
  Points normals;
  VertexNormals(rest.vertices, rest.triangles, &normals);
  OrganTouches touches;
  std::vector<Eigen::Index> all;
  double least_tip = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < reaches.size(); ++i) {
    const std::vector<Eigen::Index> reached = ReachedVertices(reaches[i], options, rest, normals);
    if (reached.empty()) continue;
    touches.instruments.push_back(i);
    least_tip = std::min(least_tip, scene.instruments[i].geometry.tip_radius);
    const double tip = scene.instruments[i].geometry.tip_radius;
    const HandSite& site = reaches[i].site;
    if (reaches[i].organ == organ &&
        reaches[i].kinematics.Inverse(site.p_target_W, 0, 1).reachable) {
      touches.patches.push_back(Press(options, site.p_target_W, site.normal_W, tip));
    } else {
      const Eigen::Index v =
          touches.patches.empty() ? reached.front() : Farthest(rest, reached, touches.patches);
      if (v >= 0) {
        touches.patches.push_back(
            Press(options, rest.vertices.row(v), normals.row(v).transpose(), tip));
      }
    }
    const bool goes_here = reaches[i].organ == organ;
    for (const Eigen::Index v : reached) {
      const double way = (rest.vertices.row(v).transpose() - site.p_target_W).norm();
      if (!goes_here || way <= kStrays * site.organ_size) all.push_back(v);
    }
  }
  std::vector<LoadOptions> places = touches.patches;
  while (!all.empty() && places.size() < kMinPlaces) {
    const Eigen::Index v = Farthest(rest, all, places);
    if (v < 0) break;
    places.push_back(Press(options, rest.vertices.row(v), normals.row(v).transpose(), least_tip));
  }
  for (const LoadOptions& place : places) touches.cases.push_back({place});
  return touches;
}

}  // namespace

std::vector<OrganTouches> FindTouches(const Scene& scene, const std::vector<SurfaceMesh>& rests) {
  std::vector<Reach> reaches;
  for (const InstrumentOptions& instrument : scene.instruments) {
    std::size_t organ = 0;
    while (scene.organs[organ].name != instrument.hand.organ) ++organ;
    const Vector3d centre = EnclosedCentre(rests[organ].vertices, rests[organ].triangles);
    const HandSite site =
        WithScenePath(scene, [&] { return SiteOnOrgan(instrument, rests[organ], centre); });
    WithScenePath(scene, [&] {
      reaches.push_back(
          {ImpulseEngineKinematics(instrument.p_trocar_W, site.p_target_W - instrument.p_trocar_W,
                                   instrument.device),
           site, organ});
    });
  }
  std::vector<OrganTouches> all;
  for (std::size_t o = 0; o < scene.organs.size(); ++o) {
    all.emplace_back();
    if (scene.organs[o].model == OrganModelType::kRigid) continue;
    all.back() = PressesOf(scene, reaches, o, rests[o]);
    std::vector<LoadOptions> loads;
    for (const LoadOptions& load : scene.loads) {
      if (load.organ != scene.organs[o].name) continue;
      if (load.pressure) {
        throw InputError(scene.path.string() + ": organ \"" + load.organ +
                         "\" has a pressure load, which no instrument can exert; give it forces or "
                         "displacements");
      }
      loads.push_back(load);
    }
    if (loads.empty()) continue;
    all.back().from_scene = true;
    all.back().cases = {loads};
    all.back().patches = loads;
  }
  return all;
}

}  // namespace hpdm
