#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/checkpoints.h"
#include "engine/deformation_loop.h"

namespace hpdm {

/// Organs, tools and the contacts between the organs, stepped 30 times a second without threads and
/// devices: Add() the organs, Start(), then Step().
class OrganBench {
 public:
  static constexpr Nanoseconds kPeriod = kNanosecondsPerSecond / 30;

  /// Adds an organ. `friction`: of a contact with the organ that was added before; none: no contact
  /// but those of `options`.
  void Add(OrganOptions options, SurfaceMesh rest, std::optional<double> friction = std::nullopt) {
    if (friction) options.contacts.push_back({organs_.back().options().name, *friction});
    organs_.emplace_back(options, std::move(rest));
  }
  /// Joins two of the organs.
  void Attach(const AttachmentOptions& attachment) { attachments_.push_back(attachment); }
  /// Joins two of the organs, or one and the world, by a duct.
  void Join(const DuctOptions& duct) { ducts_.push_back(duct); }
  /// `tools`: empty: one of the default kind.
  void Start(std::vector<ToolOptions> tools = {}) {
    if (tools.empty()) tools.resize(1);
    const int count = static_cast<int>(tools.size());
    render = std::make_unique<TripleBuffer<SceneSnapshot>>(SizedSnapshot(organs_, count, true));
    telemetry_ =
        std::make_unique<TripleBuffer<SceneSnapshot>>(SizedSnapshot(organs_, count, false));
    loop_ = std::make_unique<DeformationLoop>(organs_, tools, Edges(), nullptr, 0, attachments_,
                                              ducts_);
  }
  /// Keeps the states in which an exercise Reaches() its steps. After Start().
  void KeepSteps(std::size_t steps) {
    checkpoints_ = std::make_unique<Checkpoints>(steps);
    loop_->Attach(Edges());
    checkpoints_->MakeRoom(*loop_);
  }
  /// The exercise has reached this step, after so many restarts.
  void Reach(int step, int restarts = 0) {
    checkpoints_->progress().Back() = {.step = step, .restarts = restarts};
    checkpoints_->progress().Publish();
  }
  /// Asks for a restart in the next step.
  void Restart(int step) { restart_ = {restart_.count + 1, step}; }

  /// The tool whose shaft lies along z above the tip's centre `p`, m.
  static ToolPose Above(const Vector3d& p) {
    ToolPose tool;
    tool.X_WT.translation() = p;
    tool.p_trocar_W = p + Vector3d(0, 0, 0.3);
    return tool;
  }
  static ToolPose Away() { return Above(Vector3d(5, 5, 5)); }

  /// For the next step, as in a replay.
  void ApplyRecorded(const StepSample& recorded) { loop_->ApplyRecorded(recorded); }

  using ContactPoints = std::array<TickContactPoint, kToolPlaces>;

  void Step(std::span<const ToolPose> tools) { Step(StateOf(tools)); }
  void Step(const ToolPose& tool = Away()) { Step(std::span(&tool, 1)); }
  /// Takes the contacts of the haptic tick over.
  void Step(const ToolPose& tool, const ContactPoints& contact_points) {
    ToolState state = StateOf(std::span(&tool, 1));
    state.contact_points[0] = contact_points;
    Step(state);
  }
  /// Sets the time of the next step, at which the organs' supports are where their motion has them.
  void StayAt(double seconds) { now_ = static_cast<Nanoseconds>(seconds * kNanosecondsPerSecond); }
  double seconds() const { return ToSeconds(now_); }

  /// Returns the sum of the forces on organ `o` by other organs, N.
  Vector3d PairForce(int o) const {
    Vector3d sum = Vector3d::Zero();
    const ContactConstraints& contacts = loop_->organ(o).contacts;
    for (int i = contacts.tool_rows(); i < contacts.size(); ++i) sum += contacts[i].force_W;
    return sum;
  }
  /// Returns the sum of the tools' forces on it, N.
  Vector3d ToolForce(int o) const {
    Vector3d sum = Vector3d::Zero();
    const ContactConstraints& contacts = loop_->organ(o).contacts;
    for (int i = 0; i < contacts.tool_rows(); ++i) sum += contacts[i].force_W;
    return sum;
  }
  /// Returns the surface as it is drawn, in the world, m.
  SurfaceMesh Drawn(int o) {
    render->Update();
    const OrganSnapshot& shape = render->Front().organs[static_cast<std::size_t>(o)];
    SurfaceMesh mesh = model(o).rest();
    mesh.vertices = shape.vertices.cast<double>();
    mesh.vertices.rowwise() += shape.offset_W.transpose();
    return mesh;
  }
  int organs() const { return static_cast<int>(organs_.size()); }
  const OrganModel& model(int o) const { return organs_[static_cast<std::size_t>(o)]; }
  const OrganState& organ(int o) const { return loop_->organ(o); }
  const StepRecord& record() const { return loop_->record(); }
  const DeformationLoop& loop() const { return *loop_; }

  TripleBuffer<ContactPatch> patch;
  std::unique_ptr<TripleBuffer<SceneSnapshot>> render;

 private:
  DeformationEdges Edges() {
    return {tools_, patch, *render, *telemetry_, nullptr, checkpoints_.get()};
  }
  ToolState StateOf(std::span<const ToolPose> tools) {
    ToolState state;
    state.tick = ++tick_;
    state.time_ns = now_;
    state.tool_count = static_cast<int>(tools.size());
    state.restart = restart_;
    std::copy(tools.begin(), tools.end(), state.tools.begin());
    return state;
  }
  void Step(const ToolState& state) {
    loop_->Step(state, now_);
    patch.Update();
    now_ += kPeriod;
  }

  std::vector<OrganModel> organs_;
  std::vector<AttachmentOptions> attachments_;
  std::vector<DuctOptions> ducts_;
  TripleBuffer<ToolState> tools_;
  std::unique_ptr<TripleBuffer<SceneSnapshot>> telemetry_;
  std::unique_ptr<Checkpoints> checkpoints_;
  RestartRequest restart_;
  std::unique_ptr<DeformationLoop> loop_;
  std::uint64_t tick_ = 0;
  Nanoseconds now_ = 0;
};

}  // namespace hpdm
