#pragma once

#include <array>
#include <vector>

#include "engine/deformation_loop.h"
#include "tools/bench/bench_model.h"

namespace hpdm {

/// A session's deformation loop under instruments that press the first organ in front, without
/// devices or threads. The others, which nothing touches, stand beside it in a row, `kApart` from
/// one to the next.
class BenchScene {
 public:
  static constexpr double kApart = 0.5;  // m

  BenchScene(const std::vector<BenchOrgan>& organs, int instruments);
  BenchScene(const BenchScene&) = delete;  // the loop refers to the rest
  BenchScene& operator=(const BenchScene&) = delete;

  /// A step with the tips 6 and 5 mm deep in turn, their meshes posed as an eye sees them.
  void Step();
  /// A step with all instruments far away.
  void StepAway();

  /// Whether every tip presses, and it alone.
  bool AllPress() const;
  int polygons() const;   ///< Of all instruments.
  int triangles() const;  ///< Of all organs.

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
