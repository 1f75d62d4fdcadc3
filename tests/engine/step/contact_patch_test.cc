// The patch that a step leaves for the haptic loop.

#include <memory>

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

// Copies of a session copy its patches.
TEST_F(ContactPatchTest, ACopyOfAPatchHasWhatIsInUse) {
  for (const ReactionType reaction : {ReactionType::kPaper, ReactionType::kLattice}) {
    ToolOptions options;
    options.reaction = reaction;
    Start(options);
    Step(ToolAt(Vector3d(0.02, 0.01, 0.05)));
    const ToolPatch& patch = patch_.Front().tools[0].main();
    ASSERT_GT(patch.point_count, 10);
    EXPECT_EQ(patch.node_count, reaction == ReactionType::kPaper ? patch.point_count : 0);
    const auto copy = std::make_unique<ToolPatch>(patch);
    ASSERT_EQ(copy->point_count, patch.point_count);
    ASSERT_EQ(copy->triangle_count, patch.triangle_count);
    ASSERT_EQ(copy->node_count, patch.node_count);
    for (int i = 0; i < patch.point_count; ++i) {
      EXPECT_EQ(copy->points[i].p_original_W, patch.points[i].p_original_W);
      EXPECT_EQ(copy->points[i].compliance_W, patch.points[i].compliance_W);
    }
    for (int i = 0; i < patch.node_count; ++i) {
      EXPECT_EQ(copy->nodes[i].k1, patch.nodes[i].k1);
      ASSERT_EQ(copy->nodes[i].neighbour_count, patch.nodes[i].neighbour_count);
      EXPECT_EQ(copy->nodes[i].neighbours[0].edge, patch.nodes[i].neighbours[0].edge);
    }
    SurfaceFoot foot, foot_of_copy;
    const Vector3d above = patch.points[0].p_original_W + 0.001 * patch.points[0].normal_W;
    ASSERT_TRUE(patch.packed.FindFoot(above, 0.01, &foot));
    ASSERT_TRUE(copy->packed.FindFoot(above, 0.01, &foot_of_copy));
    EXPECT_EQ(foot_of_copy.mesh_triangle, foot.mesh_triangle);
    EXPECT_EQ(foot_of_copy.weights, foot.weights);
  }
}

// Counts what is done to values of its type.
struct Counted {
  Counted() { ++made; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) {
    ++assigned;
    return *this;
  }
  static inline int made = 0, assigned = 0;
};

// So that a copy takes no memory for what is not in use.
TEST(Room, ACopyWritesOnlyTheValuesInUse) {
  using Values = Room<Counted, 8>;
  const Values from;
  ASSERT_EQ(Counted::made, 8);
  Values copy(Values::kUntouched);
  copy.Take(from, 3);
  EXPECT_EQ(Counted::made, 8);
  EXPECT_EQ(Counted::assigned, 3);
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
