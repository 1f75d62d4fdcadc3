#include "engine/step/grasp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/deformation_loop.h"
#include "tests/support/deformation_loop_fixture.h"
#include "tools/shared/edge_wedge.h"
#include "tools/shared/one_organ.h"

namespace hpdm {
namespace {

// Jaws of 5 mm that close on the edge of the wedge. Their tips lie EdgeWedge::kHeld behind it. They
// move on by `further` before the step (m). Before they close they are at `from` (m).
class EdgeGrasp {
 public:
  EdgeGrasp(double edge, int cells, int functions, const Vector3d& further = Vector3d::Zero(),
            const Vector3d& from = Vector3d(1, 1, 1))
      : models_(OneOrgan(EdgeWedge::Options(cells, functions), EdgeWedge::Surface(edge))),
        loop_(models_, {Grasper()}, {tools_, patch_, render_, telemetry_}) {
    Step(from, 1);
    Step(further, 0, -further);
  }

  // Returns the force on the tissue, N. The jaws closed at `p_TC`.
  Vector3d Step(const Vector3d& p_W, double jaw, const Vector3d& p_TC = Vector3d::Zero()) {
    ToolState state;
    state.tool_count = 1;
    state.tools[0].X_WT.translation() = p_W;
    state.tools[0].p_trocar_W = p_W + Vector3d(0, 0, 0.3);
    state.tools[0].jaw = jaw;
    state.tools[0].X_TC.translation() = p_TC;
    state.contact_points[0][0].slip_T = slip_T;
    loop_.Step(state, 0);
    patch_.Update();
    return Patch().force_on_tissue_W;
  }
  const ToolPatch& Patch() const { return patch_.Front().tools[0].main(); }
  // Force along `axis` per way along it, the jaws' orientation held, N/m.
  double Stiffness(int axis) { return Step(1e-3 * Vector3d::Unit(axis), 0)[axis] / 1e-3; }

  Vector3d slip_T = Vector3d::Zero();

 private:
  static ToolOptions Grasper() {
    ToolOptions tool;
    tool.geometries[0].can_grasp = true;
    return tool;
  }

  std::vector<OrganModel> models_;
  TripleBuffer<ToolState> tools_;
  TripleBuffer<ContactPatch> patch_;
  TripleBuffer<SceneSnapshot> render_{SizedSnapshot(models_, 1, true)};
  TripleBuffer<SceneSnapshot> telemetry_{SizedSnapshot(models_, 1, false)};
  DeformationLoop loop_;
};

// The stiffness of four models: two lattices by two meshes.
TEST(Grasp, OfAnEdgeHasTheStiffnessOfTetrahedra) {
  std::vector<double> along, off;
  for (const auto& [cells, functions] : {std::pair(4, 27), std::pair(6, 64)}) {
    for (const double edge : {0.008, 0.003}) {
      EdgeGrasp grasp(edge, cells, functions);
      ASSERT_EQ(grasp.Patch().kind, ContactKind::kGrasp);
      along.push_back(grasp.Stiffness(1));
      off.push_back(grasp.Stiffness(2));
      EXPECT_NEAR(along.back() / EdgeWedge::kAlongEdge, 1, 0.1) << cells << ' ' << edge;
      EXPECT_NEAR(off.back() / EdgeWedge::kOffEdge, 1, 0.1) << cells << ' ' << edge;
    }
  }
  for (const auto& stiffness : {along, off}) {
    const auto [least, most] = std::minmax_element(stiffness.begin(), stiffness.end());
    EXPECT_LT(*most / *least, 1.05);
  }
}

// Its contact names no triangle before.
TEST(Grasp, NeedsNoPressBefore) {
  const OrganModel model(EdgeWedge::Options(2, 0), EdgeWedge::Surface(0.008));
  OrganState state(model, 1);
  Grasp grasp(0);
  grasp.Reserve(state.control_displacements.rows());
  TipContact contact;
  grasp.Take(ToolPose{}, ToolGeometry{}, TipPress(0, 0, 0), model, &state, &contact);
  EXPECT_TRUE(grasp.holds());
  EXPECT_GE(contact.at.triangle, 0);
}

// The step comes when the jaws have moved on by 3 mm.
TEST(Grasp, HoldsTheTissueThatWasBetweenTheJawsAsTheyClosed) {
  const Vector3d further(0.001, 0.002, 0.002);
  EdgeGrasp late(0.005, 4, 27, further), at_once(0.005, 4, 27);
  const Vector3d pulled = at_once.Step(further, 0);
  EXPECT_LT((late.Patch().force_on_tissue_W - pulled).norm(), 1e-9 * pulled.norm());
  EXPECT_GT(pulled.norm(), 0.01);
}

// Jaws that hold a wall have one jaw on each of its sides. When they let go, the tip presses on the side
// that it had pressed before.
TEST(Grasp, StaysOnTheSideFromWhichTheToolCame) {
  for (const double side : {-1.0, 1.0}) {
    EdgeGrasp grasp(0.005, 4, 0, Vector3d::Zero(), Vector3d(0.008 * side, 0, 0));
    const ToolPatch& patch = grasp.Patch();
    ASSERT_EQ(patch.kind, ContactKind::kGrasp);
    for (const int corner : patch.triangles[0]) {
      EXPECT_GT(side * patch.points[corner].normal_W.x(), 0.5);
    }
  }
}

// Returns the force on an ellipsoid pressed `depth` (m) at its top, before the jaws close there and
// after, N.
std::pair<Vector3d, Vector3d> BeforeAndAfterClosing(double depth, double radius, int cells,
                                                    OrganModelType type = OrganModelType::kHpdm) {
  OrganOptions options = PressedEllipsoidOptions();
  options.model = type;
  options.energy.type = EnergyType::kStrain;
  options.lattice.cells = {cells, cells, cells};
  const std::vector<OrganModel> models = OneOrgan(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 4));
  ToolOptions grasper;
  grasper.geometries[0].can_grasp = true;
  grasper.geometries[0].tip_radius = radius;
  TripleBuffer<ToolState> tools;
  TripleBuffer<ContactPatch> patch;
  TripleBuffer<SceneSnapshot> render{SizedSnapshot(models, 1, true)};
  TripleBuffer<SceneSnapshot> telemetry{SizedSnapshot(models, 1, false)};
  DeformationLoop loop(models, {grasper}, {tools, patch, render, telemetry});
  std::vector<Vector3d> forces;
  for (const double jaw : {1.0, 1.0, 0.1}) {
    ToolState state;
    state.tool_count = 1;
    state.tools[0].X_WT.translation() = Vector3d(0.003, -0.002, 0.05 + radius - depth);
    state.tools[0].p_trocar_W = Vector3d(0, 0, 0.3);
    state.tools[0].jaw = jaw;
    loop.Step(state, 0);
    patch.Update();
    forces.push_back(patch.Front().tools[0].main().force_on_tissue_W);
  }
  EXPECT_EQ(patch.Front().tools[0].main().kind, ContactKind::kGrasp);
  return {forces[1], forces[2]};
}

// Jaws that close on pressed tissue hold it as it is.
TEST(Grasp, ClosingTheJawsDoesNotChangeTheForce) {
  for (const auto& [depth, radius, cells] :
       {std::tuple(0.003, 0.0025, 6), std::tuple(0.008, 0.005, 6), std::tuple(0.003, 0.005, 4)}) {
    const auto [before, after] = BeforeAndAfterClosing(depth, radius, cells);
    EXPECT_GT(before.norm(), 0.005);
    EXPECT_LT((after - before).norm(), 0.01 * before.norm())
        << cells << " cells, radius " << radius << ", depth " << depth << ": " << before.transpose()
        << " N, then " << after.transpose();
  }
}

// They have no compliance to keep the force by.
TEST(Grasp, HoldsPressedTissueOfSurfaceModels) {
  for (const auto type : {OrganModelType::kMassSpring, OrganModelType::kContinuum}) {
    EXPECT_TRUE(BeforeAndAfterClosing(0.003, 0.005, 4, type).second.allFinite());
  }
}

TEST(Grasp, FollowsTheSlipAndEndsWhenTheTissueLeavesTheFaces) {
  EdgeGrasp grasp(0.008, 4, 27);
  const Vector3d pull(0, 0, 0.003);
  const double held = grasp.Step(pull, 0).z();
  grasp.slip_T = Vector3d(0, 0, -0.001);
  EXPECT_NEAR(grasp.Step(pull, 0).z(), held * 2 / 3, 1e-6 * held);
  EXPECT_EQ(grasp.Patch().slip_T, grasp.slip_T);
  grasp.slip_T = Vector3d(0, 0, -0.003);
  EXPECT_EQ(grasp.Patch().kind, ContactKind::kGrasp);
  grasp.slip_T = Vector3d(0, 0, -0.005);  // the middle of 8 mm
  grasp.Step(pull, 0);
  EXPECT_NE(grasp.Patch().kind, ContactKind::kGrasp);
}

}  // namespace
}  // namespace hpdm
