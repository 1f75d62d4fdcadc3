#include "render/render_loop.h"

#include <epoxy/gl.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <thread>

#include "tests/support/render_loop_fixture.h"

namespace hpdm {
namespace {

double Luminance(const std::uint8_t* rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}
/// Ratio of red to green: metal is grey, tissue red.
double Redness(const std::uint8_t* rgb) { return rgb[0] / (rgb[1] + 1.0); }

TEST_F(RenderLoopTest, PictureIsLitInsideTheCircleAndBlackOutside) {
  const Image image = Picture(rest_snapshot_);
  const Laparoscope scope(scope_, 320, 240);
  int inside = 0, lit = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const double r = std::hypot(x + 0.5 - 160, y + 0.5 - 120);
      // The soft edge is 1.2 % of the radius or 1.5 px wide: 2 px from the circle it has ended.
      if (r > scope.circle_radius_px() + 2) {
        ASSERT_EQ(Luminance(image.At(x, y)), 0) << x << ", " << y;
      } else if (r < scope.circle_radius_px() - 2) {
        ++inside;
        lit += image.At(x, y)[0] > 10;
      }
    }
  }
  EXPECT_GT(lit, 0.99 * inside);
  EXPECT_GT(image.At(160, 120)[0], 80);         // the organ, facing the light
  EXPECT_GT(Redness(image.At(160, 120)), 1.5);  // and red
  EXPECT_LT(image.At(160, 6)[0], 80);           // the background is darker
}

TEST_F(RenderLoopTest, TheInstrumentAppearsWhereItsTipProjects) {
  const Image image = Picture(rest_snapshot_);
  const Laparoscope scope(scope_, 320, 240);
  for (const double along : {0.0, 0.01, 0.03}) {  // m up the shaft from the tip's centre
    const Vector3d pixel = scope.Project(rest_snapshot_.tools[0].X_WT * Vector3d(0, 0, along));
    const int x = static_cast<int>(pixel.x()), y = static_cast<int>(pixel.y());
    EXPECT_LT(Redness(image.At(x, y)), 1.25) << along;
  }
  // Its radius of 2.5 mm is 2.5 px here; 8 px to the side, and beyond the tip, is tissue again.
  const Vector3d tip = scope.Project(rest_snapshot_.tools[0].X_WT.translation());
  const int x = static_cast<int>(tip.x()), y = static_cast<int>(tip.y());
  EXPECT_GT(Redness(image.At(x - 8, y)), 1.5);
  EXPECT_GT(Redness(image.At(x, y + 8)), 1.5);
}

TEST_F(RenderLoopTest, JawsOpenToBothSidesAboutTheirPivot) {
  // A jaw whose tip is 20 mm before its pivot moves by 20 mm x sin 30 degrees, and its sibling to
  // the other side; both stay at rest when closed, and the pivot always.
  for (const double opening : {std::numbers::pi / 6, -std::numbers::pi / 6}) {
    const InstrumentPart jaw{.mesh = nullptr, .pivot = 0.018, .opening = opening};
    const Vector3d tip(0, 0, -0.002), pivot(0, 0.001, 0.018);
    EXPECT_LT((PoseInTool(jaw, 0) * tip - tip).norm(), 1e-15);
    EXPECT_LT((PoseInTool(jaw, 1) * pivot - pivot).norm(), 1e-15);
    EXPECT_NEAR((PoseInTool(jaw, 1) * tip).x(), opening > 0 ? 0.01 : -0.01, 1e-15);
  }
}

TEST_F(RenderLoopTest, DrawsTheHeldInstrument) {
  InstrumentVisual thick;
  thick.geometry.tip_radius = thick.geometry.shaft_radius = 0.005;
  instrument_.exchanges.push_back(thick);
  SceneSnapshot other = rest_snapshot_;
  other.tools[0].instrument_index = 1;
  const Image thin_image = Picture(rest_snapshot_), thick_image = Picture(other);
  EXPECT_NE(thick_image.rgb, thin_image.rgb);
  other.tools[0].instrument_index = 7;  // has no visual
  EXPECT_EQ(Picture(other).rgb, thin_image.rgb);
}

TEST_F(RenderLoopTest, AShapeIsReadAgainOnlyIfItsVersionChanged) {
  const auto loop = MakeLoop();
  Publish(rest_snapshot_);
  ASSERT_TRUE(loop->Frame()) << loop->failure();
  const Image rest = loop->image();
  for (const std::uint64_t version : {1, 2}) {
    SceneSnapshot& back = buffer_->Back();
    back = Dented(0.012);
    back.step.number = ++number_;
    back.organs[0].version = version;  // 1: as of the shape at rest
    buffer_->Publish();
    ASSERT_TRUE(loop->Frame()) << loop->failure();
    EXPECT_EQ(loop->image().rgb == rest.rgb, version == 1);
  }
}

TEST_F(RenderLoopTest, AnOffsetMovesTheWholeOrganAndItsColours) {
  SceneSnapshot moved = rest_snapshot_, carried = rest_snapshot_;
  const Eigen::RowVector3f offset(0.0078125f, 0, -0.015625f);  // sums of floats without rounding
  moved.organs[0].vertices.rowwise() += offset;
  carried.organs[0].offset_W = offset.transpose().cast<double>();
  const Image expected = Picture(moved), image = Picture(carried);
  EXPECT_NE(image.rgb, Picture(rest_snapshot_).rgb);
  // Normals of triangles elsewhere round otherwise.
  int largest = 0;
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    largest = std::max(largest, std::abs(image.rgb[i] - expected.rgb[i]));
  }
  EXPECT_LE(largest, 2);
}

TEST_F(RenderLoopTest, ADentChangesThePictureThereAndNowhereElse) {
  const Image rest = Picture(rest_snapshot_);
  const Image dented = Picture(Dented(0.012));
  const Laparoscope scope(scope_, 320, 240);
  const Vector3d middle = scope.Project(Vector3d(0, 0, 0.045));
  // Vertices move within 30 mm of the dent's middle; normals change one edge further, and the
  // triangles that blend them reach another edge: 20 mm each at most.
  const double reach = 0.07 * scope.focal_length_px() / middle.z();
  int changed = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const double change = std::abs(Luminance(rest.At(x, y)) - Luminance(dented.At(x, y)));
      if (std::hypot(x - middle.x(), y - middle.y()) > reach) {
        ASSERT_EQ(change, 0) << x << ", " << y;
      }
      changed += change > 8;  // of 255: visible beside the old picture
    }
  }
  EXPECT_GT(changed, 400);  // a dent of 60 mm covers some 2,000 px
}

TEST_F(RenderLoopTest, TwoLoopsDrawTheSamePixels) {
  for (const double depth : {0.0, 0.004, 0.011}) {
    EXPECT_EQ(Picture(Dented(depth)).rgb, Picture(Dented(depth)).rgb);
  }
}

TEST_F(RenderLoopTest, DrawsOnlyNewStepsAndDropsOldOnes) {
  const auto loop = MakeLoop();
  EXPECT_FALSE(loop->Frame());
  EXPECT_EQ(loop->image().width, 0);
  for (const double depth : {0.002, 0.02, 0.005}) Publish(Dented(depth));
  EXPECT_TRUE(loop->Frame());
  EXPECT_FALSE(loop->Frame());
  EXPECT_EQ(loop->statistics().drawn, 1u);
  EXPECT_EQ(loop->statistics().dropped, 2u);
  EXPECT_FALSE(loop->statistics().renderer.empty());
}

/// Returns the step with a contact of the tip, `depth` (m) below the released surface.
SceneSnapshot WithContact(SceneSnapshot snapshot, ContactKind kind, double depth) {
  SolvedContact& contact = snapshot.contacts[0];
  contact.organ = 0;
  contact.kind = kind;
  contact.reaction = ReactionType::kLattice;
  contact.normal_W = Vector3d::UnitZ();
  contact.p_original_W = Vector3d(0, 0, 0.045);
  contact.contact_W = contact.p_original_W - depth * contact.normal_W;
  return snapshot;
}

TEST_F(RenderLoopTest, KeepsThePictureOfTheDeepestPressAndOfNoLift) {
  const auto loop = MakeLoop();
  Image deepest;
  Publish(WithContact(Dented(0.030), ContactKind::kGrasp, 0.030));
  ASSERT_TRUE(loop->Frame()) << loop->failure();
  EXPECT_EQ(loop->deepest_image().width, 0) << "nothing has been pressed";
  EXPECT_EQ(loop->deepest_press(), 0);
  for (const double depth : {0.0, 0.006, 0.010, 0.007}) {
    Publish(WithContact(Dented(depth), ContactKind::kPress, depth));
    ASSERT_TRUE(loop->Frame()) << loop->failure();
    if (depth == 0.010) deepest = loop->image();
  }
  Publish(WithContact(Dented(0.040), ContactKind::kGrasp, 0.040));
  ASSERT_TRUE(loop->Frame()) << loop->failure();
  EXPECT_EQ(loop->deepest_image().rgb, deepest.rgb);
  EXPECT_NE(loop->image().rgb, deepest.rgb);
  EXPECT_NEAR(loop->deepest_press(), 0.010, 1e-12);
}

TEST_F(RenderLoopTest, APressThatThePapersSpringsFeelIsAsDeepAsItsOrgansDent) {
  SceneSnapshot snapshot = WithContact(Dented(0.005), ContactKind::kPress, 0);
  snapshot.contacts[0].reaction = ReactionType::kPaper;
  // Single precision of 0.1 m.
  EXPECT_NEAR(PressDepth(snapshot, {rest_.vertices.cast<float>()}), 0.005, 1e-8);
}

TEST_F(RenderLoopTest, TimesAreCountedOnTheSessionsClock) {
  buffer_ = std::make_unique<TripleBuffer<SceneSnapshot>>(rest_snapshot_);
  SpscQueue<FrameRecord> frames(1);
  // Every call of the clock advances it by a millisecond.
  RenderLoop loop({{&rest_}}, {{}}, scope_, options_, {*buffer_, &frames},
                  [this] { return clock_ns_ += 1'000'000; });
  SceneSnapshot snapshot = rest_snapshot_;
  snapshot.step.device_time_ns = 20'000'000;
  clock_ns_ = 50'000'000;
  for (int i = 0; i < 2; ++i) {
    Publish(snapshot);
    ASSERT_TRUE(loop.Frame()) << loop.failure();
  }
  FrameRecord frame;
  ASSERT_TRUE(frames.Pop(&frame));
  EXPECT_EQ(frame.time_ns, 52'000'000) << "begun at 51 ms, read back at the second look";
  EXPECT_EQ(frame.compute_ns, 2'000'000) << "kept at the third";
  EXPECT_EQ(frame.device_time_ns, 20'000'000);
  EXPECT_FALSE(frames.Pop(&frame));
  EXPECT_EQ(frames.Overflows(), 1u) << "the queue was full at the second frame, which did not wait";
}

TEST_F(RenderLoopTest, WritesAFilmOfSessionTime) {
  options_.frame_folder = std::filesystem::path(testing::TempDir()) / "hpdm_film";
  options_.frame_fps = 15;
  std::filesystem::remove_all(options_.frame_folder);
  const auto loop = MakeLoop();
  for (int step = 0; step < 30; ++step) {  // one second at 30 steps a second
    SceneSnapshot snapshot = Dented(0.0005 * step);
    snapshot.step.time_ns = step * kNanosecondsPerSecond / 30;
    Publish(snapshot);
    ASSERT_TRUE(loop->Frame()) << loop->failure();
  }
  EXPECT_EQ(loop->failure(), "");
  EXPECT_EQ(loop->frames_written(), 15u);
  EXPECT_TRUE(std::filesystem::exists(options_.frame_folder / "frame_000014.png"));
  EXPECT_FALSE(std::filesystem::exists(options_.frame_folder / "frame_000015.png"));
  EXPECT_EQ(ReadPng(options_.frame_folder / "frame_000000.png").rgb, Picture(Dented(0)).rgb);
}

TEST_F(RenderLoopTest, TakesTheNewestViewAndTheWindowsSize) {
  settings_ = std::make_unique<TripleBuffer<ViewSettings>>();
  const auto loop = MakeLoop();
  Publish(rest_snapshot_);
  ASSERT_TRUE(loop->Frame()) << loop->failure();
  EXPECT_EQ(loop->image().width, 320) << "before the window's first settings";

  LaparoscopeOptions closer = scope_;
  closer.field_of_view = 0.6 * scope_.field_of_view;
  const auto show = [&](const LaparoscopeOptions& scope, int width, int height) {
    settings_->Back() = {};
    settings_->Back().scope = scope;
    settings_->Back().window_width = width;
    settings_->Back().window_height = height;
    settings_->Publish();
    Publish(rest_snapshot_);
    EXPECT_TRUE(loop->Frame()) << loop->failure();
  };
  show(closer, 200, 240);
  EXPECT_EQ(loop->image().width, 200);
  EXPECT_EQ(loop->image().height, 240);
  // The same as a loop that was made for this view.
  const Image live = loop->image();
  options_.width = 200;
  scope_ = closer;
  const auto still = MakeLoop();
  Publish(rest_snapshot_);
  ASSERT_TRUE(still->Frame());
  EXPECT_EQ(live.rgb, still->image().rgb);
}

TEST_F(RenderLoopTest, RecordedPicturesHaveTextOnlyWithTheTextOverlay) {
  settings_ = std::make_unique<TripleBuffer<ViewSettings>>();
  const auto loop = MakeLoop();
  const auto picture = [&](std::uint32_t overlays, bool paused) {
    settings_->Back() = {};
    settings_->Back().scope = scope_;
    settings_->Back().overlays = overlays;
    settings_->Back().paused = paused;
    settings_->Publish();
    Publish(rest_snapshot_);
    EXPECT_TRUE(loop->Frame()) << loop->failure();
    return loop->image();
  };
  EXPECT_EQ(picture(kOverlayNone, true).rgb, picture(kOverlayNone, false).rgb);
  EXPECT_NE(picture(kOverlayText, true).rgb, picture(kOverlayText, false).rgb);
}

TEST_F(RenderLoopTest, AnImpossibleViewKeepsTheLastOne) {
  settings_ = std::make_unique<TripleBuffer<ViewSettings>>();
  const auto loop = MakeLoop();
  Publish(rest_snapshot_);
  ASSERT_TRUE(loop->Frame()) << loop->failure();
  const Image before = loop->image();
  settings_->Back().scope.field_of_view = -1;
  settings_->Back().window_width = 0;  // minimised
  settings_->Publish();
  Publish(rest_snapshot_);
  ASSERT_TRUE(loop->Frame()) << loop->failure();
  EXPECT_EQ(loop->image().rgb, before.rgb);
}

TEST_F(RenderLoopTest, AGlErrorEndsRenderingWithOneLineAndNoException) {
  const auto loop = MakeLoop();
  Publish(rest_snapshot_);
  ASSERT_TRUE(loop->Frame());
  const Image before = loop->image();
  glEnable(0xFFFF);
  Publish(Dented(0.01));
  EXPECT_FALSE(loop->Frame());
  EXPECT_NE(loop->failure().find("GL_INVALID_ENUM"), std::string::npos) << loop->failure();
  EXPECT_EQ(loop->failure().find('\n'), std::string::npos);
  Publish(Dented(0.01));
  EXPECT_FALSE(loop->Frame());
  EXPECT_EQ(loop->image().rgb, before.rgb);
  EXPECT_EQ(loop->statistics().drawn, 1u);
}

TEST_F(RenderLoopTest, ALostContextEndsRenderingAndIsFreedSafely) {
  auto loop = MakeLoop();
  Publish(rest_snapshot_);
  ASSERT_TRUE(loop->Frame());
  { EglContext taker; }  // leaves no context current on this thread
  Publish(Dented(0.01));
  EXPECT_FALSE(loop->Frame());
  EXPECT_NE(loop->failure().find("no longer current"), std::string::npos) << loop->failure();
  loop.reset();
}

TEST_F(RenderLoopTest, RunDrawsOnItsOwnThreadNoFasterThanAskedAndStops) {
  options_.max_hz = 25;
  buffer_ = std::make_unique<TripleBuffer<SceneSnapshot>>(rest_snapshot_);
  const auto begin = std::chrono::steady_clock::now();
  RenderLoop loop({{&rest_}}, {{}}, scope_, options_, {*buffer_}, [begin] {
    return std::chrono::nanoseconds(std::chrono::steady_clock::now() - begin).count();
  });
  Nanoseconds ran_ns = 0;
  {
    std::jthread thread([&loop](std::stop_token stop) { loop.Run(stop); });
    const SceneSnapshot dented = Dented(0.01);
    for (int step = 0; step < 120; ++step) {
      Publish(dented);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ran_ns = std::chrono::nanoseconds(std::chrono::steady_clock::now() - begin).count();
  }
  EXPECT_EQ(loop.failure(), "");
  const RenderStatistics& statistics = loop.statistics();
  EXPECT_GE(statistics.drawn, 1u);
  // The mean rate is bounded; half a period's head start and the first frame make two more.
  EXPECT_LE(statistics.drawn, ToSeconds(ran_ns) * 25 + 2);
  EXPECT_GT(statistics.dropped, 0u);
  EXPECT_LE(statistics.drawn + statistics.dropped, 120u);
  EXPECT_EQ(loop.image().width, 320);
}

TEST_F(RenderLoopTest, APauseIsDrawnFiveTimesASecondAndAtOnceWhereTheViewChanges) {
  buffer_ = std::make_unique<TripleBuffer<SceneSnapshot>>(rest_snapshot_);
  settings_ = std::make_unique<TripleBuffer<ViewSettings>>();
  SpscQueue<FrameRecord> frames(100);
  std::atomic<Nanoseconds> clock_ns{0};
  RenderLoop loop({{&rest_}}, {{}}, scope_, options_, {*buffer_, &frames, settings_.get()},
                  [&clock_ns] { return clock_ns.load(); });
  std::jthread thread([&loop](std::stop_token stop) { loop.Run(stop); });
  ViewSettings view;
  view.scope = scope_;
  // True if a picture is drawn `after_ms` of the session's clock later.
  const auto draws = [&](int after_ms, std::chrono::milliseconds wait) {
    clock_ns += after_ms * Nanoseconds{1'000'000};
    settings_->Back() = view;
    settings_->Publish();
    Publish(rest_snapshot_);
    FrameRecord frame;
    const auto end = std::chrono::steady_clock::now() + wait;
    while (std::chrono::steady_clock::now() < end) {
      if (frames.Pop(&frame)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  };
  constexpr std::chrono::seconds kDeadline(20);
  constexpr std::chrono::milliseconds kMoment(200);
  ASSERT_TRUE(draws(0, kDeadline));
  EXPECT_TRUE(draws(40, kDeadline)) << "30 times a second while it runs";
  view.paused = true;
  EXPECT_TRUE(draws(40, kDeadline)) << "to show the pause";
  EXPECT_FALSE(draws(150, kMoment));
  EXPECT_TRUE(draws(60, kDeadline));
  view.scope.field_of_view *= 0.9;
  EXPECT_TRUE(draws(40, kDeadline)) << "the trainee zooms";
  view.paused = false;
  EXPECT_TRUE(draws(40, kDeadline));
  EXPECT_TRUE(draws(40, kDeadline));
}

TEST_F(RenderLoopTest, ImpossibleOptionsAreRefusedAtSetUp) {
  options_.max_hz = 0;
  EXPECT_THROW(MakeLoop(), InputError);
  options_.max_hz = 30;
  options_.frame_folder = "/dev/null/frames";
  EXPECT_THROW(MakeLoop(), InputError);
}

}  // namespace
}  // namespace hpdm
