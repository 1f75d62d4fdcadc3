#include "tools/session/trainer_input.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "render/camera/laparoscope.h"

namespace hpdm {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kWidth = 800, kHeight = 600;  // px

class TrainerInputTest : public testing::Test {
 protected:
  TrainerInputTest() {
    view_.scope.p_scope_W = Vector3d(0, -0.12, 0.1);
    view_.scope.p_target_W = Vector3d::Zero();
    view_.overlays = kOverlayText;
  }

  static TrainerInput::Instrument Tool(const Vector3d& p_trocar_W, const Vector3d& p_W) {
    TrainerInput::Instrument tool;
    tool.mouse.emplace(p_trocar_W, p_W - p_trocar_W, DeviceProfile{});
    tool.start.p_W = p_W;
    tool.exchanges = 3;
    return tool;
  }
  /// A left and a right instrument of the mouse.
  static std::vector<TrainerInput::Instrument> LeftAndRight() {
    return {Tool({-0.08, -0.05, 0.12}, {-0.02, 0, 0.01}), Tool({0.08, -0.05, 0.12}, {0.02, 0, 0})};
  }
  TrainerInput Input(const std::vector<TrainerInput::Instrument>& tools = LeftAndRight()) const {
    TrainerInput input(view_, tools);
    input.Handle(ResizeEvent{kWidth, kHeight});
    return input;
  }
  /// The same with the cursor captured.
  TrainerInput Taken() const {
    TrainerInput input = Input();
    Click(&input);
    return input;
  }
  static void Type(TrainerInput* input, int key) {
    input->Handle(KeyEvent{key, true});
    input->Handle(KeyEvent{key, false});
  }
  static void Click(TrainerInput* input) {
    input->Handle(ButtonEvent{MouseButton::kLeft, true});
    input->Handle(ButtonEvent{MouseButton::kLeft, false});
  }
  static Vector3d OnScreen(const TrainerInput& input, const Vector3d& p_W) {
    return Laparoscope(input.view().scope, kWidth, kHeight).Project(p_W);
  }
  static double Insertion(const TrainerInput& input, int tool) {
    return (input.target(tool).p_W - LeftAndRight()[tool].mouse->p_trocar_W()).norm();
  }

  ViewSettings view_;
};

TEST_F(TrainerInputTest, TheTipFollowsTheCursorPixelByPixelWhateverTheLens) {
  for (const double distortion : {0.0, -0.25, 0.2}) {
    view_.scope.distortion = distortion;
    TrainerInput input = Taken();
    const Vector3d before = OnScreen(input, input.target(0).p_W);
    input.Handle(MotionEvent{40, -25});
    input.Handle(MotionEvent{-15, 60});
    const Vector3d after = OnScreen(input, input.target(0).p_W);
    // Round-off of a projection and its inverse.
    EXPECT_NEAR(after.x() - before.x(), 25, 1e-6) << distortion;
    EXPECT_NEAR(after.y() - before.y(), 35, 1e-6) << distortion;
    EXPECT_NEAR(after.z(), before.z(), 1e-12) << "at the same distance from the lens";
  }
}

TEST_F(TrainerInputTest, WithoutTheCursorTheMouseMovesNothing) {
  TrainerInput input = Input();
  EXPECT_FALSE(input.captured());
  EXPECT_TRUE(input.view().click_takes);
  const Vector3d before = input.target(0).p_W;
  input.Handle(MotionEvent{40, -25});
  EXPECT_EQ(input.target(0).p_W, before);

  Click(&input);
  EXPECT_TRUE(input.captured());
  EXPECT_FALSE(input.view().click_takes);
  input.Handle(MotionEvent{40, -25});
  EXPECT_NE(input.target(0).p_W, before);

  Type(&input, ' ');
  EXPECT_FALSE(input.captured());
  Type(&input, ' ');
  EXPECT_TRUE(input.captured());
  input.Handle(FocusEvent{false});
  EXPECT_FALSE(input.captured()) << "another window has the keyboard";
}

TEST_F(TrainerInputTest, TheWheelMovesTheTipAlongItsShaft) {
  TrainerInput input = Input();
  const Vector3d before = input.target(0).p_W;
  const double insertion = Insertion(input, 0);
  input.Handle(WheelEvent{2});
  EXPECT_NEAR(Insertion(input, 0), insertion + 0.008, 1e-12);  // 4 mm a step
  const Vector3d shaft_W = before - LeftAndRight()[0].mouse->p_trocar_W();
  EXPECT_NEAR((input.target(0).p_W - before).cross(shaft_W).norm(), 0, 1e-15);
  input.Handle(WheelEvent{-2});
  EXPECT_TRUE(input.target(0).p_W.isApprox(before, 1e-12));
}

TEST_F(TrainerInputTest, AWheelThatTurnsSlowlyMovesTheTipFinely) {
  TrainerInput input = Input();
  const double insertion = Insertion(input, 0);
  input.Advance(0.2);
  input.Handle(WheelEvent{1});
  EXPECT_NEAR(Insertion(input, 0), insertion + 0.001, 1e-12);
  input.Advance(0.1);
  input.Handle(WheelEvent{1});
  EXPECT_NEAR(Insertion(input, 0), insertion + 0.005, 1e-12) << "it turns on";
}

TEST_F(TrainerInputTest, TheWorkspaceBoundsTheTipWithoutSlack) {
  TrainerInput input = Taken();
  const DeviceProfile profile;
  for (int i = 0; i < 200; ++i) input.Handle(WheelEvent{1});
  EXPECT_NEAR(Insertion(input, 0), profile.max_insertion, 1e-12);
  input.Handle(WheelEvent{-1});
  EXPECT_NEAR(Insertion(input, 0), profile.max_insertion - 0.004, 1e-12);
}

TEST_F(TrainerInputTest, TheLeftButtonClosesTheJawWhileHeldButNotOnTheClickThatTakes) {
  TrainerInput input = Input();
  input.Handle(ButtonEvent{MouseButton::kLeft, true});
  EXPECT_EQ(input.target(0).jaw, 1) << "the click that takes the instrument";
  input.Handle(ButtonEvent{MouseButton::kLeft, false});
  input.Handle(ButtonEvent{MouseButton::kLeft, true});
  EXPECT_EQ(input.target(0).jaw, 0);
  EXPECT_EQ(input.target(1).jaw, 1) << "the other instrument's stay open";
  input.Handle(ButtonEvent{MouseButton::kLeft, false});
  EXPECT_EQ(input.target(0).jaw, 1);
}

TEST_F(TrainerInputTest, AJawClosedByKeyStaysClosedWhileTheOtherInstrumentWorks) {
  TrainerInput input = Taken();
  Type(&input, 'j');
  EXPECT_EQ(input.target(0).jaw, 0);
  Type(&input, kKeyTab);
  EXPECT_EQ(input.view().active_instrument, 1);
  EXPECT_EQ(input.target(0).jaw, 0);
  EXPECT_EQ(input.target(1).jaw, 1);
  const Vector3d held = input.target(0).p_W;
  input.Handle(MotionEvent{30, 30});
  EXPECT_EQ(input.target(0).p_W, held);
  Type(&input, '1');
  Type(&input, 'j');
  EXPECT_EQ(input.target(0).jaw, 1);
}

TEST_F(TrainerInputTest, RightDragsAndHeldKeysRoll) {
  TrainerInput input = Taken();
  const Vector3d before = input.target(0).p_W;
  input.Handle(ButtonEvent{MouseButton::kRight, true});
  input.Handle(MotionEvent{20, 7});
  input.Handle(ButtonEvent{MouseButton::kRight, false});
  EXPECT_NEAR(input.target(0).roll, 10 * kDegree, 1e-12);  // half a degree a pixel
  EXPECT_TRUE(input.target(0).p_W.isApprox(before, 1e-12));
  input.Handle(KeyEvent{'q', true});
  for (int i = 0; i < 50; ++i) input.Advance(0.01);
  input.Handle(KeyEvent{'q', false});
  input.Advance(1);
  EXPECT_NEAR(input.target(0).roll, -50 * kDegree, 1e-12);  // 120 degrees a second
}

TEST_F(TrainerInputTest, KeysMoveTheSecondHandWhileTheMouseMovesTheFirst) {
  TrainerInput input = Taken();
  const HandTarget first = input.target(0), second = input.target(1);
  input.Handle(KeyEvent{'h', true});
  input.Handle(KeyEvent{'t', true});
  input.Advance(0.1);
  EXPECT_EQ(input.target(0).p_W, first.p_W);
  const Vector3d moved_W = input.target(1).p_W - second.p_W;
  const Matrix3d axes_W = Laparoscope(input.view().scope, kWidth, kHeight).X_WC().linear();
  // 20 mm/s to the right and upwards, in the picture's plane.
  EXPECT_TRUE((axes_W.transpose() * moved_W).isApprox(Vector3d(0.002, 0.002, 0), 1e-9))
      << moved_W.transpose();
  input.Handle(MotionEvent{30, 0});
  EXPECT_NE(input.target(0).p_W, first.p_W) << "both at the same time";
  input.Handle(FocusEvent{false});

  const double insertion = Insertion(input, 1);
  input.Handle(KeyEvent{'y', true});
  input.Handle(KeyEvent{'n', true});
  input.Advance(0.1);
  EXPECT_NEAR(Insertion(input, 1), insertion + 0.0015, 1e-12);  // 15 mm/s
  EXPECT_NEAR(input.target(1).roll, 12 * kDegree, 1e-12);
  Type(&input, 'v');
  EXPECT_EQ(input.target(0).jaw, 1);
  EXPECT_EQ(input.target(1).jaw, 0);
  Type(&input, 'v');
  EXPECT_EQ(input.target(1).jaw, 1);
}

TEST_F(TrainerInputTest, TheSecondHandIsNeitherMovedInAPauseNorByAnAbsentMouse) {
  TrainerInput input = Input();
  Type(&input, 'p');
  const Vector3d before = input.target(1).p_W;
  input.Handle(KeyEvent{'h', true});
  input.Handle(KeyEvent{'y', true});
  input.Handle(KeyEvent{'c', true});
  input.Advance(0.1);
  EXPECT_EQ(input.target(1).p_W, before);

  // The keys move the only hand that the window has.
  std::vector<TrainerInput::Instrument> tools = LeftAndRight();
  tools[1].mouse.reset();
  TrainerInput alone = Input(tools);
  alone.Handle(KeyEvent{'h', true});
  alone.Advance(0.1);
  EXPECT_NE(alone.target(0).p_W, tools[0].start.p_W);
  EXPECT_EQ(alone.target(1).p_W, tools[1].start.p_W);
  TrainerInput none = Input({});
  none.Handle(KeyEvent{'v', true});
  none.Advance(0.1);
}

TEST_F(TrainerInputTest, AGamepadMovesTheSecondHandAndItsButtonClosesTheJaws) {
  TrainerInput input = Taken();
  const HandTarget first = input.target(0), second = input.target(1);
  const double insertion = Insertion(input, 1);
  input.Handle(GamepadEvent{.in = -0.5, .roll = 0.5, .grip = true});
  input.Advance(0.1);
  EXPECT_NEAR(Insertion(input, 1), insertion - 0.0015, 1e-12);
  EXPECT_NEAR(input.target(1).roll, 6 * kDegree, 1e-12);
  EXPECT_EQ(input.target(1).jaw, 0);
  EXPECT_EQ(input.target(0).jaw, 1);
  input.Handle(GamepadEvent{});
  EXPECT_EQ(input.target(1).jaw, 1);
  input.Handle(GamepadEvent{.right = 1});
  const double before = OnScreen(input, input.target(1).p_W).x();
  input.Advance(0.1);
  EXPECT_GT(OnScreen(input, input.target(1).p_W).x(), before);
  EXPECT_NE(input.target(1).p_W, second.p_W);
  EXPECT_EQ(input.target(0).p_W, first.p_W);
}

TEST_F(TrainerInputTest, InstrumentsThatTheMouseDoesNotMoveAreSkipped) {
  std::vector<TrainerInput::Instrument> tools = LeftAndRight();
  tools[0].mouse.reset();
  TrainerInput input = Input(tools);
  EXPECT_EQ(input.view().active_instrument, 1);
  for (const int key : {int{kKeyTab}, int{'1'}}) {
    Type(&input, key);
    EXPECT_EQ(input.view().active_instrument, 1);
  }
  tools[1].mouse.reset();
  TrainerInput watching = Input(tools);
  Click(&watching);
  watching.Handle(MotionEvent{5, 5});
  watching.Handle(WheelEvent{1});
  Type(&watching, 'x');
  EXPECT_FALSE(watching.view().click_takes);
}

TEST_F(TrainerInputTest, ExchangesCycleForTheActiveInstrument) {
  TrainerInput input = Input();
  std::vector<int> held;
  for (int i = 0; i < 4; ++i) {
    Type(&input, 'x');
    held.push_back(input.control().instrument_index[0]);
  }
  EXPECT_EQ(held, (std::vector<int>{1, 2, 0, 1}));
  EXPECT_EQ(input.view().wanted_instrument, input.control().instrument_index);
  EXPECT_EQ(input.control().instrument_index[1], 0);
}

TEST_F(TrainerInputTest, APauseHoldsTheInstrumentsAndNotTheScope) {
  TrainerInput input = Taken();
  Type(&input, 'p');
  EXPECT_TRUE(input.control().paused);
  EXPECT_TRUE(input.view().paused);
  const HandTarget before = input.target(0);
  input.Handle(MotionEvent{30, 30});
  input.Handle(WheelEvent{1});
  input.Handle(ButtonEvent{MouseButton::kLeft, true});
  EXPECT_EQ(input.target(0).p_W, before.p_W);
  EXPECT_EQ(input.target(0).jaw, before.jaw);
  const double field = input.view().scope.field_of_view;
  input.Handle(KeyEvent{'+', true});
  input.Advance(0.1);
  EXPECT_LT(input.view().scope.field_of_view, field);
  input.Handle(ButtonEvent{MouseButton::kLeft, false});
  Type(&input, 'p');
  EXPECT_FALSE(input.control().paused);
  input.Handle(MotionEvent{30, 30});
  EXPECT_NE(input.target(0).p_W, before.p_W);
}

TEST_F(TrainerInputTest, ArrowsAndShiftedDragsTurnTheViewAboutTheTrocar) {
  TrainerInput input = Taken();
  const Laparoscope before(input.view().scope, kWidth, kHeight);
  const Vector3d tip = input.target(0).p_W;
  input.Handle(KeyEvent{kKeyRight, true});
  for (int i = 0; i < 60; ++i) input.Advance(0.01);
  input.Handle(KeyEvent{kKeyRight, false});
  const Laparoscope right(input.view().scope, kWidth, kHeight);
  EXPECT_GT(right.ViewingAxis_W().dot(before.X_WC().linear().col(0)), 0.05);
  EXPECT_TRUE(right.p_trocar_W().isApprox(before.p_trocar_W(), 1e-12));

  // Across the circle's radius: half of the field of view.
  input.Handle(KeyEvent{kKeyShift, true});
  input.Handle(MotionEvent{0, -before.circle_radius_px()});
  const Laparoscope up(input.view().scope, kWidth, kHeight);
  EXPECT_NEAR(std::acos(up.ViewingAxis_W().dot(right.ViewingAxis_W())),
              0.5 * view_.scope.field_of_view, 1e-9);
  EXPECT_GT(up.ViewingAxis_W().dot(right.X_WC().linear().col(1)), 0);
  const double depth = (input.view().scope.p_scope_W - up.p_trocar_W()).norm();
  input.Handle(WheelEvent{3});
  EXPECT_NEAR((input.view().scope.p_scope_W - up.p_trocar_W()).norm(), depth + 0.012, 1e-12);
  EXPECT_EQ(input.target(0).p_W, tip) << "the instrument stays";
}

TEST_F(TrainerInputTest, OpticsCycleAndKeepTheShaft) {
  TrainerInput input = Input();
  const Vector3d shaft_W = Laparoscope(input.view().scope, kWidth, kHeight).ShaftAxis_W();
  for (const double degrees : {30.0, 45.0, 0.0, 30.0}) {
    Type(&input, 'a');
    EXPECT_NEAR(input.view().scope.angle, degrees * kDegree, 1e-12);
    const Laparoscope scope(input.view().scope, kWidth, kHeight);
    EXPECT_TRUE(scope.ShaftAxis_W().isApprox(shaft_W, 1e-9));
  }
}

TEST_F(TrainerInputTest, WhateverIsTypedTheScopeCanBeDrawn) {
  TrainerInput input = Taken();
  for (const int key : {int{kKeyUp}, int{kKeyRight}, int{kKeyPageUp}, int{'+'}, int{'.'}}) {
    input.Handle(KeyEvent{key, true});
  }
  for (int i = 0; i < 3000; ++i) {
    input.Advance(0.01);
    ASSERT_NO_THROW(Laparoscope(input.view().scope, kWidth, kHeight)) << i;
  }
  input.Handle(FocusEvent{false});
  const double field = input.view().scope.field_of_view;
  input.Handle(KeyEvent{'-', true});
  for (int i = 0; i < 3000; ++i) input.Advance(0.01);
  EXPECT_GT(input.view().scope.field_of_view, field);
  EXPECT_NO_THROW(Laparoscope(input.view().scope, kWidth, kHeight));
}

TEST_F(TrainerInputTest, KeysAskForPicturesHelpOverlaysAndTheEnd) {
  TrainerInput input = Input();
  Type(&input, 's');
  Type(&input, 's');
  EXPECT_EQ(input.view().screenshots, 2u);
  Type(&input, 'r');
  EXPECT_TRUE(input.view().recording);
  Type(&input, kKeyF1);
  EXPECT_TRUE(input.view().help);
  Type(&input, kKeyF1);
  EXPECT_FALSE(input.view().help);
  EXPECT_FALSE(input.ended());
  Type(&input, kKeyEscape);
  EXPECT_TRUE(input.ended());
  TrainerInput closed = Input();
  closed.Handle(CloseEvent{});
  EXPECT_TRUE(closed.ended());
}

TEST_F(TrainerInputTest, OverlaysComeInTurnAndTheErrorOnlyWithAReference) {
  for (const bool has_reference : {false, true}) {
    view_.has_reference = has_reference;
    TrainerInput input = Input();
    std::uint32_t shown = 0;
    int presses = 0;
    do {
      Type(&input, 'o');
      shown |= input.view().overlays;
    } while (input.view().overlays != kOverlayText && ++presses < 20);
    const std::uint32_t always = kOverlayForce | kOverlayContacts | kOverlayLattice | kOverlayText;
    EXPECT_EQ(shown, has_reference ? always | kOverlayError : always);
  }
}

TEST_F(TrainerInputTest, ThePedalIsPressedWhileItsKeyIsHeld) {
  TrainerInput input = Input();
  constexpr std::array<bool, kMaxInstruments> kOff{}, kOn{true, true, true, true};
  EXPECT_EQ(input.control().pedal, kOff);
  input.Handle(KeyEvent{'d', true});
  EXPECT_EQ(input.control().pedal, kOn);
  input.Handle(KeyEvent{'e', true});
  input.Handle(KeyEvent{'e', false});
  EXPECT_EQ(input.control().pedal, kOn) << "another key";
  input.Handle(KeyEvent{'d', false});
  EXPECT_EQ(input.control().pedal, kOff);
}

TEST_F(TrainerInputTest, ThePedalIsReleasedInAPauseAndWhenTheWindowLosesItsFocus) {
  TrainerInput input = Input();
  constexpr std::array<bool, kMaxInstruments> kOff{};
  input.Handle(KeyEvent{'d', true});
  Type(&input, 'p');
  EXPECT_EQ(input.control().pedal, kOff);
  Type(&input, 'p');
  EXPECT_NE(input.control().pedal, kOff) << "still held";
  input.Handle(FocusEvent{false});
  EXPECT_EQ(input.control().pedal, kOff);
  input.Handle(FocusEvent{true});
  EXPECT_EQ(input.control().pedal, kOff) << "until it is pressed again";
}

TEST_F(TrainerInputTest, GuidanceIsSwitchedByItsKey) {
  TrainerInput input = Input();
  EXPECT_TRUE(input.view().guidance);
  Type(&input, 'i');
  EXPECT_FALSE(input.view().guidance);
  Type(&input, 'i');
  EXPECT_TRUE(input.view().guidance);
}

TEST_F(TrainerInputTest, ATeachersPauseIsThatOfTheKey) {
  TrainerInput input = Input();
  input.Handle(KeyEvent{'d', true});
  input.SetPaused(true);
  EXPECT_TRUE(input.view().paused);
  EXPECT_TRUE(input.control().paused);
  EXPECT_EQ(input.control().pedal, (std::array<bool, kMaxInstruments>{})) << "released";
  input.SetPaused(true);
  EXPECT_TRUE(input.control().paused);
  Type(&input, 'p');
  EXPECT_FALSE(input.control().paused) << "the trainee may continue";
  input.SetPaused(true);
  input.SetPaused(false);
  EXPECT_FALSE(input.view().paused);
}

}  // namespace
}  // namespace hpdm
