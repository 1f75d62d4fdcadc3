// Tests what the picture shows of the layer between two blocks.

#include "render/tissue/attachment_renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/error.h"
#include "engine/deformation_loop.h"
#include "render/camera/picture_target.h"
#include "render/gl/egl_context.h"
#include "render/scene_renderer.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

constexpr int kWidth = 320, kHeight = 240;

/// A block that lies on another and has been lifted off it by 10 mm, seen from the front and above.
class LiftedBlock : public testing::Test {
 protected:
  void SetUp() override {
    try {
      context_ = std::make_unique<EglContext>();
    } catch (const MachineError& error) {
      GTEST_SKIP() << error.what();
    }
    models_.emplace_back(Rigid("below"),
                         GridBox({-0.03, -0.03, -0.02}, {0.03, 0.03, 0}, {12, 12, 4}));
    OrganOptions above;
    above.name = "above";
    above.lattice.cells = {3, 3, 2};
    above.supports.push_back({hpdm::Box{Vector3d(-1, -1, 0.015), Vector3d(1, 1, 1)}, {}});
    models_.emplace_back(above,
                         GridBox({-0.015, -0.015, 0.0003}, {0.015, 0.015, 0.02}, {12, 12, 8}));
    AttachmentOptions layer;
    layer.a = "above";
    layer.b = "below";
    layer.region = hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, 1)};
    layer.young = 20000;
    layer.thickness = layer.reach = 0.001;
    layer.strength = 10000;
    layer.toughness = 45;
    beds_.emplace_back(layer, models_[1], models_[0]);
    scene_ = SizedSnapshot(models_, 0, true, beds_);
    scene_.organs[1].offset_W = Vector3d(0, 0, 0.01);
  }

  static OrganOptions Rigid(const char* name) {
    OrganOptions organ;
    organ.name = name;
    organ.model = OrganModelType::kRigid;
    return organ;
  }

  void SetDamage(float damage) { scene_.damage[0].assign(scene_.damage[0].size(), damage); }

  Image Picture(bool with_layer, std::optional<FreeingGuide> guide = {}) {
    LaparoscopeOptions options;
    options.p_scope_W = Vector3d(0, -0.12, 0.05);
    options.p_target_W = Vector3d(0, -0.01, 0.005);
    const Laparoscope scope(options, kWidth, kHeight);
    const Colour pale(0.8f, 0.7f, 0.5f);
    SceneRenderer view({{.rest = &models_[0].rest(), .colour = pale},
                        {.rest = &models_[1].rest(), .colour = pale}},
                       {}, nullptr, {.occlusion = false, .shadows = false},
                       with_layer ? std::vector<AttachmentVisual>{{&beds_[0], {1, 0}}}
                                  : std::vector<AttachmentVisual>{});
    PictureTarget target(kWidth, kHeight, 4);
    target.Bind();
    view.Draw(scene_, scope, kOverlayNone, guide ? &*guide : nullptr);
    target.Resolve(scope);
    Image image;
    target.Read(&image);
    EXPECT_EQ(context_->Failure(), "");
    return image;
  }

  std::unique_ptr<EglContext> context_;
  std::vector<OrganModel> models_;
  std::vector<AttachmentBed> beds_;
  SceneSnapshot scene_;
};

struct Difference {
  int brighter = 0, darker = 0;  // pixels whose green differs by more than 10 of 255
};
Difference Between(const Image& before, const Image& after) {
  Difference found;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int change = after.At(x, y)[1] - before.At(x, y)[1];
      found.brighter += change > 10;
      found.darker += change < -10;
    }
  }
  return found;
}

TEST_F(LiftedBlock, HangsOnFibresWhileTheLayerHolds) {
  const Difference whole = Between(Picture(false), Picture(true));
  EXPECT_GT(whole.brighter, 200);
  EXPECT_LT(whole.darker, whole.brighter / 10);
}

TEST_F(LiftedBlock, HasFibresThatTurnWhiteBeforeTheyTear) {
  const auto white_pixels = [this](double lifted) {
    scene_.organs[1].offset_W = Vector3d(0, 0, lifted);
    const Image image = Picture(true);
    int count = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) count += image.At(x, y)[2] > 210;
    }
    return count;
  };
  ASSERT_NEAR(beds_[0].law.final, 0.009, 1e-9);  // m: torn from there on
  const int slack = white_pixels(0.002), taut = white_pixels(0.0085);
  EXPECT_GT(taut, 100);
  EXPECT_LT(slack, taut / 10);
}

TEST_F(LiftedBlock, HasDotsOfTheGuideWhereItsLayerStillHolds) {
  const Colour blue(0, 0, 1);  // raw tissue is red
  const auto blue_pixels = [](const Image& image) {
    int count = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        count += image.At(x, y)[2] > 150 && image.At(x, y)[1] < 80 && image.At(x, y)[0] < 80;
      }
    }
    return count;
  };
  EXPECT_EQ(blue_pixels(Picture(true)), 0);
  const int whole = blue_pixels(Picture(true, FreeingGuide{{0}, blue}));
  EXPECT_GT(whole, 50);
  EXPECT_EQ(blue_pixels(Picture(true, FreeingGuide{{1}, blue})), 0) << "another attachment";
  auto& damage = scene_.damage[0];
  std::fill(damage.begin(), damage.begin() + static_cast<std::ptrdiff_t>(damage.size() / 2), 1.0f);
  const int half = blue_pixels(Picture(true, FreeingGuide{{0}, blue}));
  EXPECT_GT(half, 0.3 * whole);
  EXPECT_LT(half, 0.7 * whole);
  FreeingGuide from_tip{{0}, blue};
  from_tip.tips_W[1] = Vector3d(0.03, -0.02, 0.01);
  EXPECT_GT(blue_pixels(Picture(true, from_tip)), half + 20) << "a line from an instrument's tip";
  SetDamage(1);
  EXPECT_EQ(blue_pixels(Picture(true, from_tip)), 0);
}

TEST_F(LiftedBlock, LeavesARawSurfaceAndNoFibreWhereTheLayerIsTorn) {
  const Image bare = Picture(false);
  SetDamage(1);
  const Difference torn = Between(bare, Picture(true));
  EXPECT_EQ(torn.brighter, 0);
  EXPECT_GT(torn.darker, 200);
}

TEST_F(LiftedBlock, IsCharredWhereItWasBurnt) {
  SetDamage(1);
  const Image torn = Picture(true);
  scene_.burnt[0].assign(scene_.burnt[0].size(), 1);
  const Image burnt = Picture(true);
  int blacker = 0, redder = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int change = burnt.At(x, y)[0] - torn.At(x, y)[0];
      blacker += change < -10;
      redder += change > 0;
    }
  }
  EXPECT_GT(blacker, 200);
  EXPECT_EQ(redder, 0);
}

// A leaf in front of the blocks, 24 mm wide. At rest it is a sheet; where a strip has torn one looks
// through it.
TEST_F(LiftedBlock, ALeafIsASheetWithHolesWhereItHasTorn) {
  beds_.clear();
  AttachmentOptions leaf;
  leaf.a = "above";
  leaf.b = "below";
  leaf.young = 1e5;
  leaf.thickness = 0.0003;
  leaf.strength = 5e4;
  leaf.toughness = 2000;
  leaf.reach = 0.001;
  leaf.paths_W = {std::vector<Vector3d>{{-0.012, -0.015, 0.015}, {0.012, -0.015, 0.015}},
                  std::vector<Vector3d>{{-0.012, -0.025, 0}, {0.012, -0.025, 0}}};
  models_[1] = OrganModel(Rigid("above"), models_[1].rest());
  beds_.emplace_back(leaf, models_[1], models_[0]);
  scene_ = SizedSnapshot(models_, 0, true, beds_);
  const Image none = Picture(false), whole = Picture(true);
  scene_.damage[0][5] = scene_.damage[0][6] = 1;
  const Image torn = Picture(true);
  int covered = 0, holes = 0, others = 0;
  double columns = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool sheet = whole.At(x, y)[1] != none.At(x, y)[1];
      covered += sheet;
      if (torn.At(x, y)[1] == whole.At(x, y)[1]) continue;
      columns += x;
      (sheet ? holes : others) += 1;
    }
  }
  EXPECT_GT(covered, 1000);
  EXPECT_NEAR(holes, covered / 6.0, 0.04 * covered) << "two of twelve strips";
  EXPECT_EQ(others, 0);
  EXPECT_NEAR(columns / holes, kWidth / 2.0, 3) << "in its middle";
}

// Points beside a hanging layer, and beyond what is left of it.
TEST_F(LiftedBlock, TellsHowFarWhatIsLeftOfALayerIs) {
  SceneRenderer view({{.rest = &models_[0].rest()}, {.rest = &models_[1].rest()}}, {}, nullptr,
                     {.occlusion = false, .shadows = false}, {{&beds_[0], {1, 0}}});
  double tautness = 0, gap = 0;
  const auto distance = [&](const Vector3d& p_W, int attachment = 0) {
    LaparoscopeOptions options;
    options.p_scope_W = Vector3d(0, -0.12, 0.05);
    PictureTarget target(kWidth, kHeight, 1);
    target.Bind();
    FreeingGuide guide{{attachment}};
    guide.tips_W[2] = p_W;
    view.Draw(scene_, Laparoscope(options, kWidth, kHeight), kOverlayNone, &guide);
    EXPECT_FALSE(guide.nearest[0]) << "no instrument there";
    tautness = guide.tautness;
    const std::optional<NearestFibre>& nearest = guide.nearest[2];
    if (!nearest) return std::numeric_limits<double>::infinity();
    EXPECT_EQ(nearest->attachment, attachment);
    gap = nearest->gap;
    return (p_W - nearest->p_W).norm();
  };
  const AttachmentBed& bed = beds_[0];
  const Vector3d middle_W =
      (bed.points_W[0].row(0) + bed.points_W[1].row(0)).transpose() / 2 + Vector3d(0, 0, 0.005);
  // A fibre ends on the surfaces' triangles, up to half a millimetre beside its sample's points.
  EXPECT_LT(distance(middle_W), 5e-4) << "on a fibre, lifted by half of the blocks' way";
  EXPECT_NEAR(gap, 0.0103, 2e-4) << "between the blocks";
  EXPECT_EQ(tautness, 1) << "a layer tears at 2 toughness / strength = 9 mm";
  scene_.organs[1].offset_W.z() = 0.0045;
  distance(middle_W);
  EXPECT_NEAR(tautness, 0.5, 1e-3);
  scene_.organs[1].offset_W.z() = 0.01;
  const double beside = distance(middle_W + Vector3d(0, -0.05, 0));
  EXPECT_GT(beside, 0.02);
  EXPECT_LE(beside, 0.05 + 5e-4);
  scene_.damage[0][0] = 1;
  EXPECT_GT(distance(middle_W), 0.001) << "its fibre has torn";
  EXPECT_TRUE(std::isinf(distance(middle_W, 1))) << "another attachment";
  SetDamage(1);
  EXPECT_TRUE(std::isinf(distance(middle_W)));
}

TEST_F(LiftedBlock, SmokeRisesSpreadsAndIsGone) {
  const Image clear = Picture(false);
  scene_.smoke.Add({.p_W = Vector3d(0, 0, 0.035), .time_ns = 1'000'000'000});
  const auto row_and_count = [&](Nanoseconds time_ns) {
    scene_.step.time_ns = time_ns;
    const Image image = Picture(false);
    double rows = 0;
    int count = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (image.At(x, y)[2] == clear.At(x, y)[2]) continue;
        rows += y;
        ++count;
      }
    }
    return std::pair{count > 0 ? rows / count : 0, count};
  };
  const auto [first_row, first] = row_and_count(1'100'000'000);
  const auto [later_row, later] = row_and_count(1'700'000'000);
  EXPECT_GT(first, 10);
  EXPECT_GT(later, 2 * first);
  EXPECT_LT(later_row, first_row) << "the first row is the uppermost";
  EXPECT_EQ(row_and_count(2'600'000'000).second, 0);
  EXPECT_EQ(row_and_count(900'000'000).second, 0) << "before it was made";
}

TEST_F(LiftedBlock, ShowsNothingOfALayerThatIsClosed) {
  scene_.organs[1].offset_W.setZero();
  EXPECT_EQ(Picture(false).rgb, Picture(true).rgb);
}

}  // namespace
}  // namespace hpdm
