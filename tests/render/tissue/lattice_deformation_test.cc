#include "render/tissue/lattice_deformation.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <memory>
#include <numbers>
#include <ostream>
#include <string>

#include "engine/base/error.h"
#include "engine/deformation_loop.h"
#include "render/camera/picture_target.h"
#include "render/gl/egl_context.h"
#include "tests/support/shapes.h"
#include "tools/shared/one_organ.h"

namespace hpdm {
namespace {

struct Case {
  const char* name;
  BasisType basis;
  std::array<int, 3> degree, cells;
  EnergyType energy = EnergyType::kStrain;
  StrainMeasure strain = StrainMeasure::kSmall;
  int local_functions = 0;
  bool moves = false;
};
void PrintTo(const Case& each, std::ostream* out) { *out << each.name; }

// An ellipsoid of 0.1 x 0.07 x 0.05 m half-axes in a pose of its own, held in its lower part.
std::vector<OrganModel> OrganOf(const Case& each) {
  OrganOptions options;
  options.name = each.name;
  options.X_WO = SomePose();
  options.lattice.basis = each.basis;
  options.lattice.degree = each.degree;
  options.lattice.cells = each.cells;
  options.lattice.local.functions = each.local_functions;
  options.energy.type = each.energy;
  options.energy.strain = each.strain;
  if (each.moves)
    options.motion = {.displacement_W = Vector3d(0.002, -0.001, 0.01), .frequency = 0.25};
  options.supports.push_back(
      {.region = BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, .stiffness = {}});
  return OneOrgan(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3, options.X_WO));
}

// Returns the loop's snapshot after two tips press the organ from above, about 15 mm deep.
OrganSnapshot Pressed(const std::vector<OrganModel>& organs) {
  constexpr int kSteps = 5;
  TripleBuffer<ToolState> tools;
  TripleBuffer<ContactPatch> patch;
  TripleBuffer<SceneSnapshot> render(SizedSnapshot(organs, 2, true));
  TripleBuffer<SceneSnapshot> telemetry(SizedSnapshot(organs, 2, false));
  DeformationLoop loop(organs, {ToolOptions(), ToolOptions()}, {tools, patch, render, telemetry});
  const Isometry3d& X_WO = organs[0].options().X_WO;
  for (int step = 0; step < kSteps; ++step) {
    ToolState state;
    state.tick = static_cast<std::uint64_t>(step) + 1;
    state.time_ns = step * 100'000'000LL;
    state.tool_count = 2;
    for (int t = 0; t < 2; ++t) {
      const Vector3d p_O(t == 0 ? 0.03 : -0.035, 0.01, 0.052 - 0.004 * step);
      state.tools[t].X_WT = X_WO * Eigen::Translation3d(p_O);
      state.tools[t].p_trocar_W = X_WO * Vector3d(p_O + Vector3d(0, 0, 0.2));
    }
    loop.Step(state, state.time_ns);
  }
  render.Update();
  return render.Front().organs[0];
}

PointsF ReadBack(const GlObject& buffer, Eigen::Index rows) {
  PointsF values(rows, 3);
  glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
  glGetBufferSubData(
      GL_ARRAY_BUFFER, 0,
      static_cast<GLsizeiptr>(static_cast<std::size_t>(values.size()) * sizeof(float)),
      values.data());
  return values;
}

struct PressedOrgan {
  std::vector<OrganModel> organs;
  OrganSnapshot shape;
};

// Solved once a case.
const PressedOrgan& Solved(const Case& each) {
  static std::map<std::string, PressedOrgan> solved;
  const auto [it, added] = solved.try_emplace(each.name);
  if (added) {
    it->second.organs = OrganOf(each);
    it->second.shape = Pressed(it->second.organs);
  }
  return it->second;
}

double LargestDistance(const PointsF& a, const PointsF& b) {
  return (a - b).cast<double>().rowwise().norm().maxCoeff();
}

class LatticeDeformationTest : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    try {
      context_ = std::make_unique<EglContext>();
      target_ = std::make_unique<PictureTarget>(16, 16, 1);
      target_->Bind();
    } catch (const MachineError& error) {
      GTEST_SKIP() << error.what();
    }
  }
  void Deform(const OrganModel& model, const OrganSnapshot& shape) {
    const GlObject position_buffer(GlKind::kBuffer), normal_buffer(GlKind::kBuffer);
    LatticeDeformation deformation(model, model.rest().vertices, model.rest_normals());
    deformation.Deform(shape, position_buffer, normal_buffer);
    positions_ = ReadBack(position_buffer, model.rest().vertices.rows());
    normals_ = ReadBack(normal_buffer, model.rest().vertices.rows());
    EXPECT_EQ(context_->Failure(), "");
  }

  std::unique_ptr<EglContext> context_;
  std::unique_ptr<PictureTarget> target_;
  PointsF positions_, normals_;
};

INSTANTIATE_TEST_SUITE_P(
    Lattices, LatticeDeformationTest,
    testing::Values(
        Case{"bspline", BasisType::kBSpline, {2, 2, 2}, {4, 4, 4}},
        Case{"local_functions_on_a_moving_organ",
             BasisType::kBSpline,
             {2, 2, 2},
             {4, 3, 2},
             EnergyType::kStrain,
             StrainMeasure::kSmall,
             20,
             true},
        Case{"mixed_degrees", BasisType::kBSpline, {3, 1, 2}, {3, 5, 4}, EnergyType::kMetric},
        Case{"finite_strain",
             BasisType::kBSpline,
             {2, 2, 2},
             {4, 4, 3},
             EnergyType::kStrain,
             StrainMeasure::kFinite},
        Case{"bernstein", BasisType::kBernstein, {4, 3, 3}, {1, 1, 1}},
        Case{"bernstein_finite_strain",
             BasisType::kBernstein,
             {2, 3, 2},
             {1, 1, 1},
             EnergyType::kStrain,
             StrainMeasure::kFinite}),
    testing::PrintToStringParamName());

TEST_P(LatticeDeformationTest, ShaderAndLoopAgreeOnVertices) {
  const auto& [organs, shape] = Solved(GetParam());
  const PointsF rest = organs[0].rest().vertices.cast<float>();
  ASSERT_GT(LargestDistance(shape.vertices, rest), 0.003);
  if (GetParam().energy == EnergyType::kStrain) {
    ASSERT_GT(shape.indentation_count, 0);
  }
  if (GetParam().local_functions > 0) {
    ASSERT_GT(shape.local_displacements.norm(), 1e-4);
  }
  if (GetParam().moves) {
    ASSERT_GT(shape.offset_W.norm(), 5e-4);
  }
  Deform(organs[0], shape);
  // Promised: 1e-5 of the organ's size. Single precision at 0.4 m is 3e-8, a hundred times
  // that with a Bernstein lattice far from rest.
  const double size = 0.2;
  const double distance = LargestDistance(positions_, shape.vertices);
  RecordProperty("distance_over_size", std::to_string(1e6 * distance / size) + "e-6");
  EXPECT_LT(distance, 4e-6 * size);
}

TEST_P(LatticeDeformationTest, NormalsAreThoseOfTheDeformedSurface) {
  const auto& [organs, shape] = Solved(GetParam());
  PointsF expected;
  VertexNormalsF(shape.vertices, organs[0].rest().triangles, &expected);
  Deform(organs[0], shape);
  const Eigen::ArrayXd cosines =
      normals_.cwiseProduct(expected).rowwise().sum().cast<double>().array().min(1);
  EXPECT_LT((normals_.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-5);
  // Triangles of 6 mm see little of an indentation of 2.5 mm radius, around which they differ most.
  const Eigen::ArrayXd angles = cosines.acos() * 180 / std::numbers::pi;
  RecordProperty("mean_degrees", std::to_string(angles.mean()));
  RecordProperty("largest_degrees", std::to_string(angles.maxCoeff()));
  EXPECT_LT(angles.mean(), 0.5);
}

// Differences of positions along two tangents of the same map give the normal without triangles.
TEST_P(LatticeDeformationTest, NormalsAreOrthogonalToTheMappedTangentPlane) {
  const auto& [organs, shape] = Solved(GetParam());
  const OrganModel& model = organs[0];
  Deform(model, shape);
  const PointsF normals = normals_;
  constexpr double kStep = 2e-4;  // m
  const GlObject position_buffer(GlKind::kBuffer), normal_buffer(GlKind::kBuffer);
  const Eigen::Index count = model.rest().vertices.rows();
  std::array<Points, 2> tangents = {Points(count, 3), Points(count, 3)};
  for (Eigen::Index v = 0; v < count; ++v) {
    const Vector3d n = model.rest_normals().row(v);
    tangents[0].row(v) = n.unitOrthogonal();
    tangents[1].row(v) = n.cross(n.unitOrthogonal());
  }
  Eigen::ArrayXd off = Eigen::ArrayXd::Zero(count);
  for (const Points& tangent : tangents) {
    Points image = Points::Zero(count, 3);
    for (const double sign : {-1., 1.}) {
      LatticeDeformation moved(model, model.rest().vertices + sign * kStep * tangent,
                               model.rest_normals());
      moved.Deform(shape, position_buffer, normal_buffer);
      image += sign / (2 * kStep) * ReadBack(position_buffer, count).cast<double>();
    }
    off = off.max(image.cwiseProduct(normals.cast<double>()).rowwise().sum().array().abs());
  }
  // Round-off of positions, 3e-8 m over 4e-4 m, and at the indentations the curvature of their
  // shape; a degree-1 spline has a kink between its cells.
  EXPECT_LT(off.mean(), 1e-3);
}

TEST(FfdPath, OrgansWithoutALatticeUseTheCpu) {
  OrganOptions options;
  options.name = "skin";
  options.model = OrganModelType::kContinuum;
  options.supports.push_back(
      {.region = BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, .stiffness = {}});
  const OrganModel skin(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2));
  EXPECT_FALSE(UsesShader(FfdPath::kShader, "", skin));
}

TEST(FfdPath, SoftwareRenderersUseTheCpuUnlessForced) {
  const std::vector<OrganModel> organs =
      OrganOf({"bspline", BasisType::kBSpline, {2, 2, 2}, {2, 2, 2}});
  const char* const software = "llvmpipe (LLVM 15.0.6, 256 bits), 4.5";
  EXPECT_FALSE(UsesShader(FfdPath::kAuto, software, organs[0]));
  EXPECT_TRUE(UsesShader(FfdPath::kShader, software, organs[0]));
  EXPECT_TRUE(UsesShader(FfdPath::kAuto, "Mesa Intel(R) UHD Graphics 620", organs[0]));
  EXPECT_FALSE(UsesShader(FfdPath::kCpu, "Mesa Intel(R) UHD Graphics 620", organs[0]));
}

}  // namespace
}  // namespace hpdm
