#include "render/overlay/status_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/camera/laparoscope.h"
#include "render/overlay/text_layout.h"

namespace hpdm {
namespace {

/// Two tools in use, one of them on the liver.
struct Scenery {
  Scenery() {
    view.overlays = kOverlayText;
    view.window_width = 640;
    view.window_height = 480;
    health.ticks = 12000;
    health.haptic_hz = 999.9;
    health.deformation_hz = 30;
    health.wake_late_p99_ns = 42'000;
    health.step_compute_ns = 3'140'000;
    health.tool_count = 2;
    health.tools[0].force_W = Vector3d(0.3, -0.4, 0);
    health.tools[0].depth = 0.0123;
    health.tools[0].organ = 0;
    health.tools[0].peak_force = 2.5;
    scene.tool_count = 2;
    names.organs = {"liver"};
    names.instruments = {{"left grasper", "left hook"}, {"right probe"}};
  }
  StatusText Text() const {
    return MakeStatusText({view, health, scene, 29.7, error_scale, limits, X_WC, screenshot},
                          names);
  }

  double error_scale = 0;
  HandlingLimits limits;
  Isometry3d X_WC = Isometry3d::Identity();
  std::string screenshot;
  ViewSettings view;
  SessionHealth health;
  SceneSnapshot scene;
  StatusNames names;
};

bool Says(const std::vector<StatusLine>& lines, const std::string& text) {
  return std::any_of(lines.begin(), lines.end(), [&text](const StatusLine& line) {
    return line.text.find(text) != std::string::npos;
  });
}

TEST(StatusText, ShowsForceDepthOrganAndTheLoopsHealth) {
  const StatusText text = Scenery().Text();
  EXPECT_TRUE(Says(text.loops, "haptics 1000 Hz, late 42 \u00b5s (p99)"));
  EXPECT_TRUE(Says(text.loops, "deformation 30 Hz, 3.1 ms"));
  EXPECT_TRUE(Says(text.loops, "picture 30 Hz"));
  EXPECT_TRUE(Says(text.loops, "ticks missed: 0"));
  EXPECT_FALSE(Says(text.loops, "lost"));
  EXPECT_TRUE(Says(text.tools[0], "left grasper"));
  EXPECT_TRUE(Says(text.tools[0], "12.3 mm into liver"));
  EXPECT_TRUE(Says(text.tools[0], "0.50 N"));
  EXPECT_TRUE(Says(text.tools[0], "peak 2.50 N"));
  EXPECT_TRUE(Says(text.tools[1], "free"));
  for (const StatusLine& line : text.tools[0]) {
    if (line.bar) {
      EXPECT_NEAR(*line.bar, 0.5 / (kBarLimits * kDefaultForceLimit), 1e-12);
    }
  }
}

TEST(StatusText, MarksTheActiveInstrumentAndNamesTheHeldOne) {
  Scenery scenery;
  scenery.view.active_instrument = 1;
  scenery.scene.tools[0].instrument_index = 1;
  const StatusText text = scenery.Text();
  EXPECT_TRUE(Says(text.tools[0], "left hook"));
  EXPECT_FALSE(Says(text.tools[0], "\u25b8"));
  EXPECT_TRUE(Says(text.tools[1], "\u25b8 right probe"));
}

Tone ToneOf(const std::vector<StatusLine>& lines, const char* what) {
  for (const StatusLine& line : lines) {
    if (line.text.find(what) != std::string::npos) return line.tone;
  }
  return Tone::kGood;
}

TEST(StatusText, APressBeyondALimitRaisesAnAlarmAlsoWithoutTheTextOverlay) {
  Scenery scenery;
  EXPECT_TRUE(scenery.Text().alarms.empty());
  scenery.health.tools[0].depth = 0.061;
  EXPECT_EQ(ToneOf(scenery.Text().tools[0], "61.0 mm into liver"), Tone::kAlarm);
  scenery.view.overlays = kOverlayNone;
  EXPECT_EQ(ToneOf(scenery.Text().alarms, "left grasper: 61 mm deep, limit 20 mm"), Tone::kAlarm);
  EXPECT_FALSE(Says(scenery.Text().alarms, "N, limit"));
  scenery.limits.force = 0.4;
  EXPECT_TRUE(Says(scenery.Text().alarms, "left grasper: 0.5 N, limit 0.4 N"));
  scenery.limits.depth = 0.07;
  EXPECT_FALSE(Says(scenery.Text().alarms, "deep"));
  scenery.view.window_width = 0;
  EXPECT_TRUE(scenery.Text().alarms.empty()) << "a picture without text stays clean";
}

TEST(StatusText, AGrasperThatHoldsTissueSaysSoInsteadOfADepth) {
  Scenery scenery;
  scenery.health.tools[0].depth = 0;
  scenery.scene.contacts[0].kind = ContactKind::kGrasp;
  scenery.scene.contacts[0].organ = 0;
  const StatusText text = scenery.Text();
  EXPECT_TRUE(Says(text.tools[0], "holds liver"));
  EXPECT_FALSE(Says(text.tools[0], "mm"));
}

TEST(StatusText, AnswersTheUserAlsoWithoutTheTextOverlay) {
  Scenery scenery;
  scenery.view.overlays = kOverlayNone;
  EXPECT_TRUE(scenery.Text().state.empty());
  scenery.view.recording = true;
  scenery.view.wanted_instrument[0] = 1;
  scenery.screenshot = "saved screenshot_0001.png";
  const StatusText text = scenery.Text();
  EXPECT_TRUE(Says(text.state, "recording"));
  EXPECT_TRUE(Says(text.alarms, "left hook: free the tip to take it"));
  EXPECT_TRUE(Says(text.state, "saved screenshot_0001.png"));
  scenery.scene.tools[0].instrument_index = 1;
  EXPECT_FALSE(Says(scenery.Text().alarms, "left hook")) << "the exchange is done";
}

TEST(StatusText, TheClockShowsTheSessionsTime) {
  Scenery scenery;
  scenery.scene.step.time_ns = 65 * kNanosecondsPerSecond;
  EXPECT_EQ(scenery.Text().state[0].text, "1:05");
  scenery.scene.step.time_ns = 3725 * kNanosecondsPerSecond;
  EXPECT_EQ(scenery.Text().state[0].text, "1:02:05");
}

TEST(StatusText, ATextStandsOnTheSideOfItsHand) {
  Scenery scenery;
  EXPECT_FALSE(scenery.Text().on_right[0]) << "without known places by number";
  scenery.names.trocars_W = {{-0.1, 0, 0}, {0.1, 0, 0}};
  EXPECT_FALSE(scenery.Text().on_right[0]);
  EXPECT_TRUE(scenery.Text().on_right[1]);
  scenery.X_WC.linear() = Vector3d(-1, -1, 1).asDiagonal();  // the camera on its head
  EXPECT_TRUE(scenery.Text().on_right[0]);
  EXPECT_FALSE(scenery.Text().on_right[1]);
  scenery.names.trocars_W = {{-0.1, 0, 0}};
  EXPECT_TRUE(scenery.Text().on_right[0]) << "a single hand";
}

TEST(StatusText, RealTimeFiguresStayBelowWarningsAndFaultsOfTheSessionDoNot) {
  Scenery scenery;
  scenery.health.log_lost = 7;
  scenery.health.skipped.stalled = 3;
  scenery.health.tools[0].guard_flags = kGuardDeviceInvalid;
  const StatusText text = scenery.Text();
  EXPECT_EQ(ToneOf(text.loops, "log lost 7"), Tone::kAlarm);
  EXPECT_EQ(ToneOf(text.loops, "ticks missed: 3"), Tone::kPlain);
  EXPECT_EQ(ToneOf(text.loops, "haptics"), Tone::kDim);
  EXPECT_EQ(ToneOf(text.tools[0], "device lost"), Tone::kAlarm);
}

TEST(StatusText, ColoursOverOrgansHaveTheirRangeShown) {
  Scenery scenery;
  EXPECT_FALSE(Says(scenery.Text().state, "colours"));
  scenery.view.overlays |= kOverlayForce | kOverlayError;
  EXPECT_TRUE(Says(scenery.Text().state, "0 to 2 N"));
  EXPECT_FALSE(Says(scenery.Text().state, "mm"));  // without a reference
  scenery.error_scale = 0.005;
  EXPECT_TRUE(Says(scenery.Text().state, "0 to 5 mm"));
}

TEST(StatusText, PauseAndKeysAreShownWithoutTheTextOverlay) {
  Scenery scenery;
  scenery.view.overlays = kOverlayNone;
  EXPECT_TRUE(scenery.Text().loops.empty());
  EXPECT_TRUE(scenery.Text().tools[0].empty());
  EXPECT_TRUE(scenery.Text().banner.empty());
  scenery.view.paused = true;
  EXPECT_TRUE(Says(scenery.Text().alarms, "PAUSED"));
  EXPECT_TRUE(scenery.Text().banner.empty()) << "the middle of the picture stays free";
  scenery.view.help = true;
  EXPECT_TRUE(Says(scenery.Text().banner, "screenshot"));
}

TEST(GlyphAtlas, ReadsUtf8AndReplacesInvalidBytes) {
  EXPECT_EQ(CodePoints("a\u00b5\u25cf"), (std::vector<char32_t>{U'a', U'\u00b5', U'\u25cf'}));
  EXPECT_EQ(CodePoints("\xff\xc3(").size(), 3u);  // two stray bytes and a bracket
  EXPECT_EQ(CodePoints("\xff")[0], U'?');
  const GlyphAtlas atlas(13);
  EXPECT_EQ(&atlas.At(U'\u4e00'), &atlas.At(U'?'));
  EXPECT_EQ(atlas.Width("00"), 2 * atlas.Width("1")) << "digits have one width";
  EXPECT_GT(atlas.Width("m"), atlas.Width("i"));
  EXPECT_EQ(atlas.coverage()[0], 255);
}

TEST(GlyphAtlas, GlyphsDoNotOverlapInTheAtlas) {
  const GlyphAtlas atlas(17);
  std::vector<int> used(atlas.coverage().size(), 0);
  for (char32_t code = 0x20; code < 0x7f; ++code) {
    const Glyph& glyph = atlas.At(code);
    for (int y = glyph.y; y < glyph.y + glyph.height; ++y) {
      for (int x = glyph.x; x < glyph.x + glyph.width; ++x) {
        ASSERT_EQ(used[static_cast<std::size_t>(y) * atlas.width() + x]++, 0) << int(code);
      }
    }
  }
}

TEST(StatusText, ReportsAnInvertedOrOverstretchedOrgan) {
  Scenery scenery;
  EXPECT_FALSE(Says(scenery.Text().loops, "tissue"));
  scenery.health.step_flags = kStepInverted;
  EXPECT_TRUE(Says(scenery.Text().loops, "tissue inverted"));
  scenery.health.step_flags |= kStepRecovering;
  EXPECT_TRUE(Says(scenery.Text().loops, "overstretched"));
}

TEST(TextLayout, StaysInsideThePictureAtAnySize) {
  Scenery scenery;
  scenery.view.help = true;
  scenery.view.recording = true;
  scenery.view.click_takes = true;
  scenery.health.tools[0].depth = 0.061;
  for (const auto& [width, height] : {std::pair{640, 480}, {1920, 1080}, {480, 800}, {64, 48}}) {
    const GlyphAtlas atlas(TextPixels(width, height));
    const std::vector<TextQuad> quads = LayOut(scenery.Text(), atlas, width, height);
    EXPECT_FALSE(quads.empty());
    for (const TextQuad& quad : quads) {
      ASSERT_GE(quad.x, 0);
      ASSERT_GE(quad.y, 0);
      ASSERT_LE(quad.x + quad.width, width);
      ASSERT_LE(quad.y + quad.height, height);
    }
  }
}

/// Returns the CIELAB colour (D65) of an sRGB colour as seen with a kind of dichromacy, or as it is.
Vector3d SeenColour(const TextColour& colour, const Matrix3d& dichromacy) {
  Vector3d linear;
  for (int i = 0; i < 3; ++i) {
    const double c = colour[i];
    linear[i] = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  }
  linear = (dichromacy * linear).cwiseMax(0.0).cwiseMin(1.0).eval();
  Matrix3d to_xyz;
  to_xyz << 0.4124564, 0.3575761, 0.1804375, 0.2126729, 0.7151522, 0.0721750, 0.0193339, 0.1191920,
      0.9503041;
  const Vector3d xyz = (to_xyz * linear).cwiseQuotient(Vector3d(0.95047, 1, 1.08883));
  Vector3d f;
  for (int i = 0; i < 3; ++i) {
    f[i] = xyz[i] > 0.008856 ? std::cbrt(xyz[i]) : 7.787 * xyz[i] + 16.0 / 116;
  }
  return {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
}

/// Matrices on linear sRGB, of full severity (Machado, Oliveira, Fernandes 2009).
std::vector<Matrix3d> KindsOfSight() {
  Matrix3d protan, deutan, tritan;
  protan << 0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116,
      1.051998;
  deutan << 0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.011820, 0.042940,
      0.968881;
  tritan << 1.255528, -0.076749, -0.178779, -0.078411, 0.930809, 0.147602, 0.004733, 0.691367,
      0.303900;
  return {Matrix3d::Identity(), protan, deutan, tritan};
}

/// Returns the least distance between the colours of good, warning and alarm, in texts and in the bar.
double LeastDistance(Palette palette) {
  const std::vector<TextColour> texts = {ColourOf(Tone::kGood, palette),
                                         ColourOf(Tone::kWarning, palette),
                                         ColourOf(Tone::kAlarm, palette)};
  const std::vector<TextColour> bars = {BarColour(0.1, palette), BarColour(0.5, palette),
                                        BarColour(0.9, palette)};
  double least = 1e3;
  for (const Matrix3d& sight : KindsOfSight()) {
    for (const auto& colours : {texts, bars}) {
      for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t b = 0; b < a; ++b) {
          least = std::min(least,
                           (SeenColour(colours[a], sight) - SeenColour(colours[b], sight)).norm());
        }
      }
    }
  }
  return least;
}

TEST(TextLayout, ATeachersMarksAreAtTheirPlacesAndABleedingGrows) {
  const GlyphAtlas atlas(TextPixels(640, 480));
  PictureMarks marks;
  marks.count = 2;
  marks.marks[0] = {.kind = PictureMark::Kind::kPoint, .x = 0.25, .y = 0.5};
  marks.marks[1] = {
      .kind = PictureMark::Kind::kBleeding, .x = 0.75, .y = 0.25, .since_ns = 2'000'000'000};
  ViewSettings view;
  SessionHealth health;
  SceneSnapshot scene;
  scene.tool_count = 1;
  Eigen::Vector2d tip(0.75, 0.25);
  const auto laid_out = [&](double seconds) {
    scene.step.time_ns = static_cast<Nanoseconds>(1e9 * seconds);
    Status status{.view = view, .health = health, .scene = scene, .marks = &marks};
    status.tips[0] = tip;
    return LayOut(MakeStatusText(status, {}), atlas, 640, 480);
  };
  // Middles of what is drawn left and right of the picture's middle, and the right one's width.
  const auto disc_width = [&](double seconds) {
    int widest = 0;
    for (const TextQuad& quad : laid_out(seconds)) {
      const bool is_row = quad.height == 1 && quad.atlas_x == 0 && quad.atlas_y == 0;
      if (!is_row) continue;
      EXPECT_NEAR(quad.x + 0.5 * quad.width, 480, 1);
      widest = std::max(widest, quad.width);
    }
    return widest;
  };
  const int at_once = disc_width(2), later = disc_width(7), full = disc_width(17);
  EXPECT_GT(at_once, 10);
  EXPECT_GT(later, 2 * at_once);
  EXPECT_GT(full, later);
  EXPECT_EQ(disc_width(60), full);
  scene.sucks[0] = true;
  EXPECT_EQ(disc_width(17), at_once) << "suction takes the blood";
  tip.x() = 0.25;
  EXPECT_EQ(disc_width(17), full) << "beside the disc";
  scene.sucks[0] = false;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int bars = 0;
  for (const TextQuad& quad : laid_out(2)) {
    if (quad.colour != ColourOf(Tone::kWarning, Palette::kStandard)) continue;
    sum += Eigen::Vector2d(quad.x + 0.5 * quad.width, quad.y + 0.5 * quad.height);
    ++bars;
  }
  ASSERT_EQ(bars, 4);
  EXPECT_NEAR(sum.x() / bars, 160, 1);
  EXPECT_NEAR(sum.y() / bars, 240, 1);
}

TEST(Palette, ItsTonesAreApartForEveryKindOfSight) {
  EXPECT_GT(LeastDistance(Palette::kColourBlind), 30);
  EXPECT_LT(LeastDistance(Palette::kStandard), 15) << "the comparison can tell";
}

TEST(Palette, AnAlarmHasASignBesidesItsColour) {
  Scenery scenery;
  scenery.health.tools[0].depth = 0.061;  // beyond the limit: an alarm and a tool's line
  const GlyphAtlas atlas(TextPixels(640, 480));
  const auto count = [&](Palette palette, const TextColour& colour) {
    const std::vector<TextQuad> quads = LayOut(scenery.Text(), atlas, 640, 480, palette);
    return std::ranges::count(quads, colour, &TextQuad::colour);
  };
  const auto standard = count(Palette::kStandard, ColourOf(Tone::kAlarm, Palette::kStandard));
  EXPECT_GT(standard, 0);
  EXPECT_EQ(count(Palette::kColourBlind, ColourOf(Tone::kAlarm, Palette::kColourBlind)),
            standard + 2)
      << "a ! before each of two lines";
  EXPECT_EQ(count(Palette::kColourBlind, ColourOf(Tone::kAlarm, Palette::kStandard)), 0);
}

TEST(TextLayout, LeavesTheMiddleOfThePictureFree) {
  const GlyphAtlas atlas(TextPixels(640, 480));
  const Laparoscope scope({}, 640, 480);
  for (const TextQuad& quad : LayOut(Scenery().Text(), atlas, 640, 480)) {
    for (const int x : {quad.x, quad.x + quad.width}) {
      for (const int y : {quad.y, quad.y + quad.height}) {
        // The corners' blocks may cut the outer tenth of the circle's radius, which is dim.
        EXPECT_GT(std::hypot(x - 320, y - 240), 0.9 * scope.circle_radius_px());
      }
    }
  }
}

Scenery WithExercise() {
  Scenery scenery;
  scenery.names.exercise.emplace();
  ExerciseOptions& exercise = *scenery.names.exercise;
  exercise.name = "bed";
  exercise.steps = {
      {.name = "take"},
      {.name = "lift", .instruction = "Lift it off the liver until the layer is tight"}};
  exercise.errors = {{.name = "more than 4 N"}};
  scenery.health.exercise = {
      .present = true, .step = 1, .progress = 0.5, .time = 20.4, .time_left = 79.6, .score = 40};
  return scenery;
}

TEST(StatusText, AnExerciseSaysWhatIsNextAndWhatWasWrong) {
  Scenery scenery = WithExercise();
  scenery.health.exercise.step_times[0] = 10;
  StatusText text = scenery.Text();
  EXPECT_TRUE(Says(text.guidance, "2/2 Lift it off the liver until the"));
  EXPECT_TRUE(Says(text.guidance, "layer is tight")) << "the line is wrapped";
  EXPECT_TRUE(Says(text.guidance, "50 %"));
  EXPECT_TRUE(Says(text.guidance, "80 s left, 0 errors, score 40"));
  EXPECT_FALSE(Says(text.guidance, "4 N"));
  scenery.health.exercise.progress = 0.997f;
  EXPECT_TRUE(Says(scenery.Text().guidance, "99 %")) << "not done yet";
  scenery.health.exercise.errors = 1;
  scenery.health.exercise.last_error = 0;
  scenery.health.exercise.last_error_time = 18;
  EXPECT_TRUE(Says(scenery.Text().guidance, "more than 4 N"));
  EXPECT_TRUE(Says(scenery.Text().guidance, "1 error, "));
  scenery.health.exercise.last_error_time = 12;
  EXPECT_FALSE(Says(scenery.Text().guidance, "more than 4 N")) << "8.4 s ago";
  scenery.view.guidance = false;
  EXPECT_TRUE(scenery.Text().guidance.empty());
}

TEST(StatusText, AnExercisesEndIsShownInTheMiddle) {
  Scenery scenery = WithExercise();
  EXPECT_TRUE(scenery.Text().banner.empty());
  scenery.health.exercise.ended = true;
  EXPECT_TRUE(Says(scenery.Text().banner, "TIME IS OVER"));
  EXPECT_TRUE(scenery.Text().guidance.empty());
  scenery.health.exercise.passed = true;
  scenery.health.exercise.score = 87.4;
  EXPECT_TRUE(Says(scenery.Text().banner, "EXERCISE DONE"));
  EXPECT_TRUE(Says(scenery.Text().banner, "score 87 of 100"));
  scenery.view.help = true;
  EXPECT_FALSE(Says(scenery.Text().banner, "EXERCISE DONE")) << "the keys come first";
  EXPECT_TRUE(Scenery().Text().guidance.empty()) << "a scene without an exercise";
}

}  // namespace
}  // namespace hpdm
