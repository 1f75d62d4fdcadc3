#include "tools/haptics/scene_press.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "engine/base/error.h"
#include "engine/mesh/collision.h"
#include "haptics/contact/tip_contacts.h"
#include "scenes/loader/scene.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kTickPeriod = kNanosecondsPerSecond / 1000;
constexpr int kTicksAStep = 33;
constexpr double kFrom = 0.005;  // m, above the organ
constexpr int kHold = 500;       // ticks

// Lets the organ touch the soft ones before it.
void AddPairs(const OrganBench& bench, OrganOptions* organ) {
  const auto names = [](const OrganOptions& options, const std::string& other) {
    return std::any_of(options.contacts.begin(), options.contacts.end(),
                       [&](const OrganContactOptions& contact) { return contact.with == other; });
  };
  for (int o = 0; o < bench.organs(); ++o) {
    const OrganOptions& other = bench.model(o).options();
    if (other.model == OrganModelType::kRigid || names(other, organ->name) ||
        names(*organ, other.name)) {
      continue;
    }
    organ->contacts.push_back({other.name, 0.05});
  }
}

// Adds the scene's organs; returns the index of the pressed one.
int AddOrgans(const std::filesystem::path& path, const ScenePress& press, OrganBench* bench) {
  int pressed = -1;
  for (OrganOptions organ : LoadScene(path).organs) {
    if (organ.name == press.organ) pressed = bench->organs();
    if (press.all_pairs && organ.model != OrganModelType::kRigid) AddPairs(*bench, &organ);
    std::vector<std::string> repairs;
    bench->Add(organ, LoadPosedMesh(organ, &repairs));
  }
  if (pressed < 0) throw InputError(path.string() + ": has no organ \"" + press.organ + "\"");
  return pressed;
}

// A hand's ticks and the steps that they hand over to, as in a session in lockstep: a step that begins
// at a tick is seen 33 ticks later.
class PressingHand {
 public:
  PressingHand(const ScenePress& press, OrganBench* bench) : press_(press), bench_(bench) {}

  // True if a step ended.
  bool Tick(const ToolPose& tool) {
    const bool begins = time_ns_ % (kTicksAStep * kTickPeriod) == 0;
    const bool ended = begins && begun_.has_value();
    if (ended) {
      bench_->StayAt(ToSeconds(begun_->time_ns));
      bench_->Step(begun_->tool, begun_->contact_points);
      contacts_.SetPatches(bench_->patch.Front().tools[0]);
    }
    contacts_.Locate({.time_ns = time_ns_,
                      .X_WT = tool.X_WT,
                      .tip_radius = press_.tip_radius,
                      .friction = press_.friction});
    TipContacts::Solve(&contacts_);
    if (begins) begun_ = Begun{time_ns_, tool, contacts_.contact_points()};
    time_ns_ += kTickPeriod;
    return ended;
  }
  const Vector3d& reaction_W() const { return contacts_.result().reaction_W; }

 private:
  const ScenePress& press_;
  OrganBench* bench_;
  TipContacts contacts_;
  struct Begun {
    Nanoseconds time_ns = 0;
    ToolPose tool;
    OrganBench::ContactPoints contact_points;
  };
  std::optional<Begun> begun_;
  Nanoseconds time_ns_ = 0;
};

// The guide of a press's tip.
struct GuideLine {
  Vector3d top_W;   // m, on the surface
  Vector3d into_W;  // unit

  GuideLine(const ScenePress& press, const SurfaceMesh& rest) {
    const SurfacePoint at = SurfaceTree(rest.vertices, rest.triangles).Closest(press.place_W, 1).at;
    top_W = at.Position(rest.vertices, rest.triangles);
    into_W = press.direction_W.isZero(0)
                 ? Vector3d(-TwiceAreaNormal(rest.vertices, rest.triangles, at.triangle))
                 : press.direction_W;
    into_W.normalize();
  }
  // The tip with its lowest point `depth` (m) below the surface. The trocar lies in the tip: no shaft.
  ToolPose At(double depth, double tip_radius) const {
    ToolPose tool;
    tool.X_WT.linear() =
        Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), -into_W).toRotationMatrix();
    tool.X_WT.translation() = top_W + (depth - tip_radius) * into_W;
    tool.p_trocar_W = tool.X_WT.translation() - tip_radius * into_W;
    return tool;
  }
};

}  // namespace

ScenePressResult PressInScene(const std::filesystem::path& path, const ScenePress& press,
                              double depth, const std::function<void(OrganBench*)>& seen) {
  OrganBench bench;
  const int pressed = AddOrgans(path, press, &bench);
  ToolOptions tool;
  tool.geometries[0].tip_radius = press.tip_radius;
  bench.Start({tool});
  const GuideLine guide(press, bench.model(pressed).rest());
  PressingHand hand(press, &bench);

  ScenePressResult result;
  PenetrationMeter meter;
  Vector3d last_W = Vector3d::Zero();
  const auto tick = [&](double to) {
    const bool stepped = hand.Tick(guide.At(to, press.tip_radius));
    result.felt = std::max(result.felt, hand.reaction_W().norm());
    result.largest_jump = std::max(result.largest_jump, (hand.reaction_W() - last_W).norm());
    last_W = hand.reaction_W();
    if (!stepped) return;
    meter.Measure(&bench);
    result.dropped = result.dropped || (bench.record().flags & kStepContactsDropped) != 0;
    for (int o = 0; o < bench.organs(); ++o) {
      result.pair_force = std::max(result.pair_force, bench.PairForce(o).norm());
    }
    if (seen) seen(&bench);
  };
  const double way = press.speed * ToSeconds(kTickPeriod);
  double to = -kFrom;
  for (; to < depth; to += way) tick(to);
  for (int i = 0; i < kHold; ++i) tick(depth);
  for (to = depth; to > -kFrom; to -= way) tick(to);
  result.penetration = meter.result();
  return result;
}

}  // namespace hpdm
