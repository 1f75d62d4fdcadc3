#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/deformation_loop.h"
#include "tests/support/shapes.h"
#include "tools/shared/one_organ.h"

namespace hpdm {

/// An ellipsoid of 0.1 x 0.07 x 0.05 m half-axes held in its lower part.
inline OrganOptions PressedEllipsoidOptions() {
  OrganOptions options;
  options.name = "ellipsoid";
  options.energy.type = EnergyType::kMetric;
  SupportOptions bottom;
  bottom.region = BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)};
  options.supports.push_back(bottom);
  return options;
}

/// Two tools on the ellipsoid, stepped without threads.
class DeformationLoopTest : public testing::Test {
 protected:
  explicit DeformationLoopTest(const OrganOptions& options = PressedEllipsoidOptions())
      : models_(OneOrgan(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3))) {}

  // The shaft lies along z, the tip's centre at p.
  static ToolPose ToolAt(const Vector3d& p, double jaw = 1) {
    ToolPose tool;
    tool.X_WT.translation() = p;
    tool.p_trocar_W = p + Vector3d(0, 0, 0.2);
    tool.jaw = jaw;
    return tool;
  }
  void Step(const ToolPose& first, const ToolPose& second = ToolAt(Vector3d(1, 1, 1))) {
    ToolState tools;
    tools.tick = ++tick_;
    tools.tool_count = 2;
    tools.tools = {first, second};
    loop_->Step(tools, 0);
    patch_.Update();
    render_.Update();
  }
  void Start(const ToolOptions& tool = {}) {
    loop_ =
        std::make_unique<DeformationLoop>(models_, std::vector<ToolOptions>{tool, tool},
                                          DeformationEdges{tools_, patch_, render_, telemetry_});
  }
  double Gap(const Vector3d& p) const {  // of the deformed surface from the tip's surface
    const SurfaceTree tree(loop_->organ(0).vertices, models_[0].rest().triangles);
    return tree.Closest(p, 1).distance - kDefaultToolRadius;
  }

  std::vector<OrganModel> models_;
  TripleBuffer<ToolState> tools_;
  TripleBuffer<ContactPatch> patch_;
  TripleBuffer<SceneSnapshot> render_{SizedSnapshot(models_, 2, true)};
  TripleBuffer<SceneSnapshot> telemetry_{SizedSnapshot(models_, 2, false)};
  std::unique_ptr<DeformationLoop> loop_;
  std::uint64_t tick_ = 0;
};

}  // namespace hpdm
