#include "render/overlay/overlay_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "engine/base/error.h"
#include "render/camera/picture_target.h"
#include "render/gl/egl_context.h"
#include "render/overlay/colour_map.h"
#include "render/overlay/contact_marks.h"
#include "render/overlay/lattice_marks.h"
#include "render/overlay/view_settings.h"
#include "render/scene_renderer.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

// CIE 1976 lightness, 0..100, of a colour on an sRGB screen.
double Lightness(const Colour& colour) {
  const double Y = Linear(colour).cast<double>().dot(Vector3d(0.2126, 0.7152, 0.0722));
  return Y > 216. / 24389 ? 116 * std::cbrt(Y) - 16 : 24389. / 27 * Y;
}

TEST(ColourMap, LightnessRisesEvenly) {
  const double dark = Lightness(MapColour(0)), light = Lightness(MapColour(1));
  EXPECT_GT(light - dark, 70);  // most of what a screen has
  double last = dark;
  for (int i = 1; i <= 200; ++i) {
    const double now = Lightness(MapColour(i / 200.));
    EXPECT_GT(now, last) << i;
    // Two just noticeable differences.
    EXPECT_NEAR(now, dark + (light - dark) * i / 200, 2) << i;
    last = now;
  }
}

TEST(RoundedUp, IsTheNextOfOneTwoFive) {
  EXPECT_DOUBLE_EQ(RoundedUp(0.0011), 0.002);
  EXPECT_DOUBLE_EQ(RoundedUp(0.0049), 0.005);
  EXPECT_DOUBLE_EQ(RoundedUp(0.0051), 0.01);
  EXPECT_DOUBLE_EQ(RoundedUp(2), 2);
  EXPECT_DOUBLE_EQ(RoundedUp(0), 1e-3);
}

OrganOptions SupportedOptions() {
  OrganOptions options;
  options.name = "ellipsoid";
  options.energy.type = EnergyType::kMetric;
  options.supports.push_back(
      {.region = BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, .stiffness = {}});
  return options;
}

OrganSnapshot ShapeAtRest(const OrganModel& model) {
  OrganSnapshot shape;
  shape.control_displacements = Points::Zero(model.control_points(), 3);
  shape.vertices = model.rest().vertices.cast<float>();
  return shape;
}

// Eq. 4 of the points that are drawn is the deformed shape: they are where the control points are.
TEST(LatticeMarks, PointsCarryTheDeformedShape) {
  const SurfaceMesh mesh = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2);
  std::srand(1);
  for (const BasisType basis : {BasisType::kBSpline, BasisType::kBernstein}) {
    OrganOptions options = SupportedOptions();
    options.energy.domain = EnergyDomain::kBox;  // no control point is dropped
    options.lattice.basis = basis;
    options.lattice.degree = {2, 3, 2};
    options.lattice.cells =
        basis == BasisType::kBSpline ? std::array{3, 2, 4} : std::array{1, 1, 1};
    const OrganModel model(options, mesh);
    OrganSnapshot shape = ShapeAtRest(model);
    shape.control_displacements = 0.01 * Points::Random(model.control_points(), 3);
    shape.offset_W = Vector3d(0.01, 0, -0.02);
    Points deformed = mesh.vertices + model.weights() * shape.control_displacements;
    deformed.rowwise() += shape.offset_W.transpose();
    const Points drawn = DisplacedControlPoints(model.lattice_organ()->lattice(), shape);
    // Round-off of sums of a few dozen products.
    EXPECT_LT((model.weights() * drawn - deformed).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(LatticeMarks, LinesJoinNeighboursAndLocalFunctionsHaveTheirOwnColour) {
  OrganOptions options = SupportedOptions();
  options.energy.type = EnergyType::kStrain;
  options.lattice.cells = {2, 2, 2};
  options.lattice.local.functions = 4;
  const OrganModel model(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2));
  OrganSnapshot shape = ShapeAtRest(model);
  shape.local_functions = {model.refinement_basis()->finer().kept()[7], -1};
  shape.local_displacements = Points::Zero(2, 3);
  Marks marks;
  AddLatticeMarks(model, ControlPointPresence(model), shape, &marks);
  // All 4^3 control points have tissue, but the 8 at the box's corners hold next to none of it: a
  // product of three border functions. Lines only join what is drawn.
  ASSERT_EQ(model.control_points(), 64);
  const auto points = std::count_if(marks.begin(), marks.end(),
                                    [](const Mark& mark) { return mark.a_W == mark.b_W; });
  EXPECT_GT(points, 8 + 1);
  EXPECT_LE(points, 64 - 8 + 1);
  for (const Mark& mark : marks) {
    EXPECT_GT(mark.opacity, 0);
    if (mark.a_W == mark.b_W) continue;
    // Neighbours differ along one axis of the grid.
    EXPECT_EQ(((mark.a_W - mark.b_W).array().abs() > 1e-6f).count(), 1);
  }
  const Eigen::Vector3f centre = model.refinement_basis()->centres().row(7).cast<float>();
  EXPECT_LT((marks.back().a_W - centre).norm(), 1e-7f);
  EXPECT_NE(marks.back().colour, marks[marks.size() - 2].colour);
}

TEST(ContactMarks, ArrowIsTheForceOnTheHand) {
  const SurfaceMesh mesh = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2);
  SolvedContact contact;
  OrganSnapshot shape;
  shape.vertices = mesh.vertices.cast<float>();
  Marks marks;
  AddContactMarks(contact, shape, mesh.triangles, &marks);
  EXPECT_TRUE(marks.empty());
  contact.kind = ContactKind::kPress;
  contact.contact_W = Vector3d(0, 0, 0.05);
  contact.normal_W = Vector3d::UnitZ();
  AddContactMarks(contact, shape, mesh.triangles, &marks);
  EXPECT_TRUE(marks.empty());  // near, but without a force
  contact.force_on_tissue_W = Vector3d(0.2, 0, -1.5);
  AddContactMarks(contact, shape, mesh.triangles, &marks);
  const Vector3d tip = marks.back().b_W.cast<double>();
  // Single precision.
  EXPECT_LT((tip - contact.contact_W + kArrowLength * contact.force_on_tissue_W).norm(), 1e-7);
  EXPECT_EQ(marks.back().radius_b, 0);  // a point
}

class OverlayRendererTest : public testing::Test {
 protected:
  static constexpr int kWidth = 320, kHeight = 240;
  void SetUp() override {
    try {
      context_ = std::make_unique<EglContext>();
    } catch (const MachineError& error) {
      GTEST_SKIP() << error.what();
    }
    target_.emplace(kWidth, kHeight, 4);
    organ_.rest = &model_.rest();
    organ_.model = &model_;
    LaparoscopeOptions scope;
    scope.p_scope_W = Vector3d(0.02, -0.12, 0.2);
    scope_.emplace(scope, kWidth, kHeight);
    snapshot_.organs.push_back(ShapeAtRest(model_));
    snapshot_.tool_count = 1;
    snapshot_.contacts[0] = {.organ = 0,
                             .kind = ContactKind::kPress,
                             .contact_W = Vector3d(0, 0, 0.05),
                             .force_on_tissue_W = Vector3d(0, 0, -1),
                             .normal_W = Vector3d::UnitZ(),
                             .kernel_radius = 0.0025};
  }
  void Show(const OrganVisual& organ) {
    view_.emplace(std::vector{organ}, std::vector<InstrumentVisual>());
  }
  Image Draw(std::uint32_t overlays) {
    ++snapshot_.organs[0].version;
    if (!view_) Show(organ_);
    Image image;
    target_->Bind();
    view_->Draw(snapshot_, *scope_, overlays);
    target_->Resolve(*scope_);
    view_->DrawScales(overlays);
    target_->Read(&image);
    EXPECT_EQ(context_->Failure(), "");
    return image;
  }
  // Pixels that differ, by their farthest distance from a place, px; within the scope's circle,
  // outside of which the scales stand.
  static double FarthestChange(const Image& a, const Image& b, const Vector3d& place, int* count) {
    double farthest = 0;
    *count = 0;
    for (int y = 0; y < a.height; ++y) {
      for (int x = 0; x < a.width; ++x) {
        const double dx = x + 0.5 - a.width / 2., dy = y + 0.5 - a.height / 2.;
        if (std::hypot(dx, dy) > 0.49 * a.height) continue;
        if (std::equal(a.At(x, y), a.At(x, y) + 3, b.At(x, y))) continue;
        ++*count;
        farthest = std::max(farthest, std::hypot(x + 0.5 - place.x(), y + 0.5 - place.y()));
      }
    }
    return farthest;
  }

  const OrganModel model_{SupportedOptions(), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3)};
  std::unique_ptr<EglContext> context_;
  std::optional<PictureTarget> target_;
  std::optional<Laparoscope> scope_;
  std::optional<SceneRenderer> view_;
  OrganVisual organ_;
  SceneSnapshot snapshot_;
};

TEST_F(OverlayRendererTest, SwitchedOffTheyDoNotChangeThePicture) {
  const Points reference = Points::Constant(model_.rest().vertices.rows(), 3, 0.002);
  organ_.reference = &reference;
  const Image before = Draw(kOverlayNone);
  for (const std::uint32_t overlay :
       {kOverlayForce, kOverlayContacts, kOverlayLattice, kOverlayError}) {
    EXPECT_NE(Draw(overlay).rgb, before.rgb) << overlay;
  }
  EXPECT_EQ(Draw(kOverlayNone).rgb, before.rgb);
}

TEST_F(OverlayRendererTest, ForceColoursOnlyTheSurroundingsOfItsContact) {
  const Image before = Draw(kOverlayNone), after = Draw(kOverlayForce);
  const Vector3d place = scope_->Project(snapshot_.contacts[0].contact_W);
  const double radius_px = kForceSpotRadii * 0.0025 / place.z() * scope_->focal_length_px();
  int changed = 0;
  // The spot is a ball's cut through the organ: nearer parts of it may be drawn a tenth larger.
  EXPECT_LT(FarthestChange(before, after, place, &changed), 1.1 * radius_px + 1);
  EXPECT_GT(changed, 0.3 * radius_px * radius_px);
  snapshot_.contacts[0].force_on_tissue_W.setZero();
  FarthestChange(before, Draw(kOverlayForce), place, &changed);
  EXPECT_EQ(changed, 0);
}

TEST_F(OverlayRendererTest, AnOrganWhereItsReferenceIsHasTheFirstColour) {
  const Points reference = Points::Constant(model_.rest().vertices.rows(), 3, 0.002);
  organ_.reference = &reference;
  organ_.error_scale = 0.01;
  const int x = kWidth / 2, y = kHeight / 2;
  const auto colour = [&] {
    const Image image = Draw(kOverlayError);
    return (Colour(image.At(x, y)[0], image.At(x, y)[1], image.At(x, y)[2]) / 255.0f).eval();
  };
  const double rest_error = std::sqrt(3) * 0.002 / organ_.error_scale;
  // 8 % of the tissue shines through, and tilted surfaces are up to 30 % darker.
  EXPECT_LT((colour() - MapColour(rest_error)).cwiseAbs().maxCoeff(), 0.2f);
  snapshot_.organs[0].vertices.array() += 0.002f;
  EXPECT_LT((colour() - MapColour(0)).cwiseAbs().maxCoeff(), 0.2f);
}

TEST_F(OverlayRendererTest, WithoutAReferenceThereIsNoErrorToShow) {
  EXPECT_EQ(Draw(kOverlayError).rgb, Draw(kOverlayNone).rgb);
}

TEST_F(OverlayRendererTest, TheScaleShowsTheMapsColours) {
  const Image image = Draw(kOverlayForce);
  // The middle of the bar, 12 px wide, 16 px from the right and 60 px high.
  const int x = kWidth - 16 - 6, height = 60;
  for (const double value : {0.1, 0.4, 0.6, 0.9}) {
    const int y = kHeight / 2 + height / 2 - static_cast<int>(std::lround(value * height));
    const Colour seen = Colour(image.At(x, y)[0], image.At(x, y)[1], image.At(x, y)[2]) / 255.0f;
    // One pixel is a sixtieth of the map, in which a component changes by 0.04 at most.
    EXPECT_LT((seen - MapColour(value)).cwiseAbs().maxCoeff(), 0.05f) << value;
  }
}

TEST_F(OverlayRendererTest, TheShadersDeformationGivesTheSamePicture) {
  snapshot_.organs[0].control_displacements.col(2).setConstant(0.004);
  snapshot_.organs[0].control_displacements.col(0).setLinSpaced(0, 0.01);
  snapshot_.organs[0].vertices =
      (model_.rest().vertices + model_.weights() * snapshot_.organs[0].control_displacements)
          .cast<float>();
  organ_.ffd = FfdPath::kCpu;
  const Image cpu = Draw(kOverlayNone);
  organ_.ffd = FfdPath::kShader;
  Show(organ_);
  const Image shader = Draw(kOverlayNone);
  double sum = 0;
  for (std::size_t i = 0; i < cpu.rgb.size(); ++i) sum += std::abs(cpu.rgb[i] - shader.rgb[i]);
  // Normals differ by tenths of a degree: less than one level of 255 on average.
  EXPECT_LT(sum / static_cast<double>(cpu.rgb.size()), 1);
}

}  // namespace
}  // namespace hpdm
