#pragma once

#include <array>
#include <vector>

#include "engine/deformation_loop.h"
#include "tools/bench/bench_model.h"

namespace hpdm {

/// A session's deformation loop, without devices or threads, under instruments that press the first
/// organ from the front. The other organs stand beside it in a row, `kApart` from one to the next,
/// and nothing touches them.
class BenchScene {
 public:
  static constexpr double kApart = 0.5;  // m

  BenchScene(const std::vector<BenchOrgan>& organs, int instruments);
  BenchScene(const BenchScene&) = delete;  // the loop keeps references to members
  BenchScene& operator=(const BenchScene&) = delete;

  /// Makes one step and poses the visible meshes. The tips press 6 mm deep in one step and 5 mm in
  /// the next.
  void Step();
  /// Makes one step with all instruments far away.
  void StepAway();

  /// True if every tip presses and nothing else does.
  bool AllPress() const;
  int polygons() const;   ///< Sum over the instruments.
  int triangles() const;  ///< Sum over the organs.

 private:
  SurfaceMesh probe_;
  std::vector<OrganModel> organs_;
  TripleBuffer<ToolState> tool_states_;
  TripleBuffer<ContactPatch> patches_;
  TripleBuffer<SceneSnapshot> render_, telemetry_;
  DeformationLoop loop_;
  ToolState tools_;
  std::array<Vector3d, kMaxInstruments> entry_;
  std::vector<Points> posed_;
  Nanoseconds now_ns_ = 0;
  bool deep_ = false;
};

}  // namespace hpdm
