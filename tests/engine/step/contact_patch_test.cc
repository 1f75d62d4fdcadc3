// The patch that a step leaves for the haptic loop.

#include "tests/support/deformation_loop_fixture.h"

namespace hpdm {
namespace {

using ContactPatchTest = DeformationLoopTest;

TEST_F(ContactPatchTest, PatchIsBoundedAndConsistent) {
  ToolOptions paper;
  paper.reaction = ReactionType::kPaper;
  Start(paper);
  Step(ToolAt(Vector3d(0.02, 0.01, 0.05)));
  const ToolPatch& patch = patch_.Front().tools[0].main();
  EXPECT_GT(patch.triangle_count, 10);
  EXPECT_LE(patch.triangle_count, ToolPatch::kMaxTriangles);
  EXPECT_LE(patch.point_count, ToolPatch::kMaxPoints);
  for (int t = 0; t < patch.triangle_count; ++t) {
    for (int corner : patch.triangles[t]) ASSERT_LT(corner, patch.point_count);
  }
  for (int p = 0; p < patch.point_count; ++p) {
    const ReactionNode& node = patch.nodes[p];
    EXPECT_GE(node.neighbour_count, 5);
    for (int i = 0; i < node.neighbour_count; ++i) {
      EXPECT_DOUBLE_EQ(node.neighbours[i].edge.norm(), node.neighbours[i].rest_length);
    }
  }
}

// Small strain without other loads: a released press returns to the rest surface.
TEST_F(ContactPatchTest, TheReleasedPatchIsTheRestSurface) {
  Start();
  for (double z = 0.055; z > 0.04; z -= 0.002) Step(ToolAt(Vector3d(0.02, 0.01, z)));
  const ToolPatch& patch = patch_.Front().tools[0].main();
  ASSERT_LT(patch.force_on_tissue_W.z(), -0.1);
  const SurfaceMesh& rest = models_[0].rest();
  // The contact's point lies on the curved surface over the triangles (curved_surface.h): on the
  // ellipsoid, whose facets lie up to 0.4 mm below it.
  EXPECT_NEAR(patch.p_original_W.cwiseQuotient(Vector3d(0.1, 0.07, 0.05)).norm(), 1, 1e-3);
  for (int t = 0; t < patch.triangle_count; ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vector3d vertex = rest.vertices.row(rest.triangles(patch.mesh_triangles[t], k));
      const PatchPoint& point = patch.points[patch.triangles[t][k]];
      EXPECT_LT((point.p_original_W - vertex).norm(), 1e-8);
    }
  }
}

TEST_F(ContactPatchTest, TheComplianceTakesTheReleasedPointToTheContact) {
  Start();
  for (double z = 0.055; z > 0.04; z -= 0.002) Step(ToolAt(Vector3d(0.02, 0.01, z)));
  const ToolPatch& patch = patch_.Front().tools[0].main();
  const Vector3d moved = patch.compliance_W * patch.force_on_tissue_W;
  EXPECT_LT((patch.p_original_W + moved - patch.contact_W).norm(), 1e-9);
  EXPECT_GT(moved.norm(), 0.005);
}

}  // namespace
}  // namespace hpdm
