#include "render/overlay/status_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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
  EXPECT_TRUE(Says(text.tools[0], "12.3 mm liver"));
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
  EXPECT_EQ(ToneOf(scenery.Text().tools[0], "61.0 mm liver"), Tone::kAlarm);
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
  EXPECT_TRUE(Says(text.state, "left hook: free the tip to take it"));
  EXPECT_TRUE(Says(text.state, "saved screenshot_0001.png"));
  scenery.scene.tools[0].instrument_index = 1;
  EXPECT_FALSE(Says(scenery.Text().state, "left hook")) << "the exchange is done";
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
  EXPECT_TRUE(Says(scenery.Text().banner, "PAUSED"));
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
  StatusText text = scenery.Text();
  EXPECT_TRUE(Says(text.guidance, "2/2 Lift it off the liver until the layer is"));
  EXPECT_TRUE(Says(text.guidance, "tight")) << "the line is wrapped";
  EXPECT_TRUE(Says(text.guidance, "50 %"));
  EXPECT_TRUE(Says(text.guidance, "80 s left, 0 errors, score 40"));
  EXPECT_FALSE(Says(text.guidance, "4 N"));
  scenery.health.exercise.errors = 1;
  scenery.health.exercise.last_error = 0;
  scenery.health.exercise.last_error_time = 18;
  EXPECT_TRUE(Says(scenery.Text().guidance, "more than 4 N"));
  EXPECT_TRUE(Says(scenery.Text().guidance, "1 error, "));
  scenery.health.exercise.last_error_time = 16;
  EXPECT_FALSE(Says(scenery.Text().guidance, "more than 4 N")) << "4.4 s ago";
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
