#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "engine/base/error.h"
#include "render/gl/egl_context.h"
#include "render/render_loop.h"

namespace hpdm {

/// Returns an ellipsoid of 0.2 x 0.14 x 0.09 m about the origin with 2 n^2 triangles.
inline SurfaceMesh Ellipsoid(int n) {
  SurfaceMesh mesh;
  mesh.vertices.resize(n * n + 2, 3);
  mesh.triangles.resize(2 * n * n, 3);
  const auto at = [n](int ring, int s) { return ring * n + s % n; };
  int t = 0;
  for (int r = 0; r < n; ++r) {
    for (int s = 0; s < n; ++s) {
      const double a = 2 * std::numbers::pi * s / n, b = std::numbers::pi * (r + 1) / (n + 1);
      mesh.vertices.row(at(r, s)) << 0.1 * std::cos(a) * std::sin(b),
          0.07 * std::sin(a) * std::sin(b), 0.045 * std::cos(b);
      if (r + 1 == n) continue;
      mesh.triangles.row(t++) << at(r, s), at(r + 1, s), at(r + 1, s + 1);
      mesh.triangles.row(t++) << at(r, s), at(r + 1, s + 1), at(r, s + 1);
    }
  }
  mesh.vertices.row(n * n) << 0, 0, 0.045;
  mesh.vertices.row(n * n + 1) << 0, 0, -0.045;
  for (int s = 0; s < n; ++s) {
    mesh.triangles.row(t++) << n * n, at(0, s), at(0, s + 1);
    mesh.triangles.row(t++) << n * n + 1, at(n - 1, s + 1), at(n - 1, s);
  }
  return mesh;
}

/// Draws an organ and an instrument off screen; skips tests without OpenGL.
class RenderLoopTest : public testing::Test {
 protected:
  void SetUp() override {
    try {
      EglContext probe;
    } catch (const MachineError& error) {
      GTEST_SKIP() << error.what();
    }
    scope_.p_scope_W = Vector3d(-0.04, -0.12, 0.18);
    scope_.p_target_W = Vector3d(0, 0, 0.045);
    options_.width = 320;
    options_.height = 240;
    rest_snapshot_.organs.resize(1);
    rest_snapshot_.organs[0].vertices = rest_.vertices.cast<float>();
    rest_snapshot_.tool_count = 1;
    // The instrument hovers over the organ, off the line of sight to its middle.
    rest_snapshot_.tools[0].X_WT = ToolAt(Vector3d(0.03, 0, 0.065));
  }

  static Isometry3d ToolAt(const Vector3d& p_tip_W) {
    Isometry3d X_WT = Isometry3d::Identity();
    X_WT.linear() = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), Vector3d(1, 0.4, 1))
                        .toRotationMatrix();
    X_WT.translation() = p_tip_W;
    return X_WT;
  }

  /// The rest snapshot with a dent of `depth` (m), 30 mm wide, in the top of the organ.
  SceneSnapshot Dented(double depth) const {
    SceneSnapshot snapshot = rest_snapshot_;
    for (int v = 0; v < rest_.vertices.rows(); ++v) {
      const double d = (rest_.vertices.row(v) - Eigen::RowVector3d(0, 0, 0.045)).norm() / 0.03;
      if (d < 1) {
        snapshot.organs[0].vertices(v, 2) -=
            static_cast<float>(depth * std::pow(std::cos(std::numbers::pi / 2 * d), 2));
      }
    }
    return snapshot;
  }

  std::unique_ptr<RenderLoop> MakeLoop() {
    buffer_ = std::make_unique<TripleBuffer<SceneSnapshot>>(rest_snapshot_);
    number_ = 0;
    return std::make_unique<RenderLoop>(
        std::vector<OrganVisual>{{&rest_}}, std::vector<InstrumentVisual>{instrument_}, scope_,
        options_, RenderLoop::Edges{*buffer_, nullptr, settings_.get()},
        [this] { return clock_ns_; });
  }

  void Publish(const SceneSnapshot& snapshot) {
    SceneSnapshot& back = buffer_->Back();
    back = snapshot;
    back.step.number = ++number_;
    for (OrganSnapshot& organ : back.organs) organ.version = number_;
    buffer_->Publish();
  }

  /// The picture of one snapshot.
  Image Picture(const SceneSnapshot& snapshot) {
    const auto loop = MakeLoop();
    Publish(snapshot);
    EXPECT_TRUE(loop->Frame()) << loop->failure();
    return loop->image();
  }

  const SurfaceMesh rest_ = Ellipsoid(26);
  InstrumentVisual instrument_;  // a capsule
  LaparoscopeOptions scope_;
  RenderOptions options_;
  SceneSnapshot rest_snapshot_;
  std::unique_ptr<TripleBuffer<SceneSnapshot>> buffer_;
  std::unique_ptr<TripleBuffer<ViewSettings>> settings_;  // null without a window
  std::uint64_t number_ = 0;
  Nanoseconds clock_ns_ = 0;
};

}  // namespace hpdm
