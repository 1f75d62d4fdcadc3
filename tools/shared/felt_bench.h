#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "engine/deformation_loop.h"
#include "haptics/contact/tip_contacts.h"
#include "tools/shared/one_organ.h"

namespace hpdm {

/// Deformation loop and tip contacts of two tools or more, without threads or devices: the felt force
/// of given poses. A call gives the poses of all tools, or of the first two.
class FeltBench {
 public:
  explicit FeltBench(std::vector<OrganModel> models, const ToolOptions& tool = {},
                     std::size_t tools = 2)
      : models_(std::move(models)),
        tool_(tool),
        render_(SizedSnapshot(models_, static_cast<int>(tools), true)),
        telemetry_(SizedSnapshot(models_, static_cast<int>(tools), false)),
        loop_(models_, std::vector(tools, tool), {tools_, patch_, render_, telemetry_}),
        contacts_(tools) {}
  FeltBench(const OrganOptions& options, const SurfaceMesh& rest, const ToolOptions& tool = {},
            std::size_t tools = 2)
      : FeltBench(OneOrgan(options, rest), tool, tools) {}

  double friction = 0;
  bool feels_shaft = false;

  static ToolPose At(const Vector3d& p, double jaw = 1) {
    ToolPose tool;
    tool.X_WT.translation() = p;
    tool.p_trocar_W = p + Vector3d(0, 0, 0.3);
    tool.jaw = jaw;
    return tool;
  }
  static ToolPose Away() { return At(Vector3d(1, 1, 1)); }

  // A step, and its patch in the hand's contacts.
  void Step(const ToolPose& a, const ToolPose& c = Away()) { Step(std::array{a, c}); }
  void Step(std::span<const ToolPose> poses) {
    time_ns_ += 33'000'000;
    Step(State(poses));
  }
  // One tick's forces on the hands.
  void Tick(const ToolPose& a, const ToolPose& c = Away()) { Tick(std::array{a, c}); }
  void Tick(std::span<const ToolPose> poses) {
    std::vector<TipContacts*> all;
    for (std::size_t t = 0; t < poses.size(); ++t) all.push_back(&contacts_[t]);
    TipContacts::StandOnMoved(all);
    for (std::size_t t = 0; t < poses.size(); ++t) contacts_[t].Locate(Motion(poses[t]));
    TipContacts::Solve(all);
  }
  // The same for other contacts of one tool.
  void TickOf(TipContacts* contacts, const ToolPose& tool) const {
    contacts->Locate(Motion(tool));
    TipContacts::Solve(contacts);
  }
  // The next tick of a session in lockstep: a step begins every 33 ticks and is seen 33 later.
  void SessionTick(const ToolPose& a, const ToolPose& c = Away()) {
    time_ns_ += 1'000'000;
    const bool begins = tick_++ % 33 == 0;
    if (begins && tick_ > 1) Step(begun_);
    Tick(a, c);
    if (begins) begun_ = State(std::array{a, c});
  }
  // Runs ticks until the last patch's force has faded in and the contacts are stationary.
  void Settle(const ToolPose& a, const ToolPose& c = Away()) { Settle(std::array{a, c}); }
  void Settle(std::span<const ToolPose> poses) {
    for (int i = 0; i < 250; ++i) Tick(poses);
  }
  Vector3d Hand(int t = 0) const { return contacts_[t].result().reaction_W; }
  const HapticForce& Felt(int t = 0) const { return contacts_[t].result(); }
  const TipContacts& Contacts(int t = 0) const { return contacts_[t]; }
  TickContactPoint ContactPoint(int t = 0) const { return contacts_[t].contact_points()[0]; }
  const ToolPatch& Patch(int t = 0) { return patch_.Front().tools[t].main(); }
  const ToolPatches& Patches(int t = 0) { return patch_.Front().tools[t]; }
  const OrganModel& model() const { return models_[0]; }
  const DeformationLoop& loop() const { return loop_; }

  // Returns the point where the vertical line through (x, y) meets the rest surface from above, m.
  Vector3d Top(double x, double y) const {
    const SurfaceTree tree(models_[0].rest().vertices, models_[0].rest().triangles);
    const SurfaceHit hit = tree.FirstEntry(Vector3d(x, y, 1), Vector3d(x, y, -1));
    return hit.at.Position(models_[0].rest().vertices, models_[0].rest().triangles);
  }
  // Presses against `normal` down to `depth` in steps of a millimetre; the tool's last pose.
  ToolPose PressTo(const Vector3d& top, double depth, const Vector3d& normal = Vector3d::UnitZ()) {
    ToolPose tool;
    for (double z = -0.004; z < depth + 1e-9; z += 0.001) {
      tool = At(top - (z - kDefaultToolRadius) * normal);
      Step(tool);
      Tick(tool);
    }
    Settle(tool);
    Step(tool);
    Settle(tool);
    return tool;
  }

 private:
  TipPose Motion(const ToolPose& tool) const {
    const ToolGeometry& geometry = tool_.geometries[0];
    return TipPose{.time_ns = time_ns_,
                   .X_WT = tool.X_WT,
                   .jaw = tool.jaw,
                   .tip_radius = geometry.tip_radius,
                   .friction = friction,
                   .shaft_radius = feels_shaft ? geometry.shaft_radius : 0,
                   .from_trocar = (tool.p_trocar_W - tool.X_WT.translation()).norm(),
                   .tip_part = geometry.JawsLength()};
  }
  ToolState State(std::span<const ToolPose> poses) const {
    ToolState state;
    state.time_ns = time_ns_;
    state.tool_count = static_cast<int>(poses.size());
    for (std::size_t t = 0; t < poses.size(); ++t) {
      state.tools[t] = poses[t];
      state.contact_points[t] = contacts_[t].contact_points();
    }
    return state;
  }
  void Step(const ToolState& state) {
    loop_.Step(state, state.time_ns);
    patch_.Update();
    for (std::size_t t = 0; t < contacts_.size(); ++t) {
      contacts_[t].SetPatches(patch_.Front().tools[t]);
    }
  }

  std::vector<OrganModel> models_;
  ToolOptions tool_;
  TripleBuffer<ToolState> tools_;
  TripleBuffer<ContactPatch> patch_;
  TripleBuffer<SceneSnapshot> render_, telemetry_;
  DeformationLoop loop_;
  std::vector<TipContacts> contacts_;
  Nanoseconds time_ns_ = 0;
  std::uint64_t tick_ = 0;
  ToolState begun_;
};

}  // namespace hpdm
