#include "render/instrument/drawn_pose.h"

#include <gtest/gtest.h>

#include "haptics/device/impulse_engine.h"
#include "tests/support/felt_bench.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

constexpr double kRadius = 0.0025;  // m
const Vector3d kRadii(0.1, 0.07, 0.05);
const Vector3d kHole(0.05, -0.02, 0.2);

OrganOptions Organ(OrganModelType model) {
  OrganOptions options;
  options.name = "organ";
  options.model = model;
  if (model == OrganModelType::kRigid) return options;
  options.energy.type = EnergyType::kStrain;
  options.lattice.local.functions = 0;
  options.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}});
  return options;
}

ToolPose Through(const Vector3d& p_W) {
  const ImpulseEngineKinematics kinematics(kHole, -Vector3d::UnitZ(), DeviceProfile{});
  ToolPose tool;
  tool.X_WT = kinematics.Forward(kinematics.Inverse(p_W, 0.3, 1).joints);
  tool.p_trocar_W = kHole;
  return tool;
}

// Presses an ellipsoid obliquely, 4 mm below its top, and returns the tool and its contact.
SolvedContact Press(OrganModelType model, const ToolPose& tool) {
  ToolOptions options;
  options.geometries[0].tip_radius = kRadius;
  FeltBench bench(Organ(model), Ellipsoid(kRadii, 3), options);
  for (double z = 0.004; z > 0; z -= 0.0005) {
    ToolPose above = tool;
    above.X_WT.translation().z() += z;
    bench.Step(above);
    bench.Tick(above);
  }
  for (int i = 0; i < 3; ++i) {
    bench.Step(tool);
    bench.Tick(tool);
  }
  return bench.Patch();
}

TEST(DrawnPose, TipThatPressesARigidOrganStandsOnItsSurfaceWithTheShaftInTheTrocar) {
  const ToolPose tool = Through({0.01, 0.005, kRadii.z() + kRadius - 0.004});
  const SolvedContact contact = Press(OrganModelType::kRigid, tool);
  ASSERT_TRUE(contact.rigid);
  const Isometry3d X_WT = DrawnPose(tool, contact, kRadius);
  // Independent of the contact: the distance of the centre from the mesh is the tip's radius, but
  // for the facets, which lie up to 0.3 mm below the smooth surface on which the contact slides.
  const SurfaceMesh mesh = Ellipsoid(kRadii, 3);
  const SurfaceTree tree(mesh.vertices, mesh.triangles);
  const auto gap = [&](const Vector3d& p_W) { return tree.Closest(p_W, 0.1).distance; };
  EXPECT_NEAR(gap(X_WT.translation()), kRadius, 3e-4);
  EXPECT_LT(tool.X_WT.translation().z(), kRadii.z()) << "the tip itself is inside";
  EXPECT_GT(X_WT.translation().z(), kRadii.z() + 0.5 * kRadius);
  const Vector3d to_trocar = (kHole - X_WT.translation()).normalized();
  EXPECT_LT((X_WT.linear().col(2) - to_trocar).norm(), 1e-12);
  EXPECT_NEAR((X_WT.linear() * X_WT.linear().transpose() - Matrix3d::Identity()).norm(), 0, 1e-12);
}

TEST(DrawnPose, EveryOtherToolIsDrawnWhereItIs) {
  const ToolPose deep = Through({0.01, 0.005, kRadii.z() + kRadius - 0.004});
  const SolvedContact soft = Press(OrganModelType::kHpdm, deep);
  EXPECT_GT(soft.force_on_tissue_W.norm(), 0);
  EXPECT_EQ(DrawnPose(deep, soft, kRadius).matrix(), deep.X_WT.matrix());
  const ToolPose above = Through({0.01, 0.005, kRadii.z() + kRadius + 0.002});
  const SolvedContact free = Press(OrganModelType::kRigid, above);
  EXPECT_EQ(DrawnPose(above, free, kRadius).matrix(), above.X_WT.matrix());
}

}  // namespace
}  // namespace hpdm
