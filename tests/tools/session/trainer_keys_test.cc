// Keys of the trainer's window by which a newcomer loses or keeps what a hand holds, and the view.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "engine/base/angle.h"
#include "render/camera/laparoscope.h"
#include "tools/session/trainer_input.h"

namespace hpdm {
namespace {

/// A left and a right instrument of the mouse, of three exchanges each.
class TrainerKeys : public testing::Test {
 protected:
  static constexpr int kSide = 600;  // px

  TrainerKeys() {
    view_.scope.p_scope_W = Vector3d(0, -0.12, 0.1);
    view_.scope.p_target_W = Vector3d::Zero();
  }
  TrainerInput Input() const {
    std::vector<TrainerInput::Instrument> tools(2);
    for (std::size_t t = 0; t < tools.size(); ++t) {
      const double side = t == 0 ? -1 : 1;
      const Vector3d p_trocar_W(0.08 * side, -0.05, 0.12), p_W(0.02 * side, 0, 0.01);
      tools[t].mouse.emplace(p_trocar_W, p_W - p_trocar_W, DeviceProfile{});
      tools[t].start.p_W = p_W;
      tools[t].exchanges = 3;
    }
    TrainerInput input(view_, tools);
    input.Handle(ResizeEvent{kSide, kSide});
    return input;
  }
  static void Type(TrainerInput* input, int key) {
    input->Handle(KeyEvent{key, true});
    input->Handle(KeyEvent{key, false});
  }

  ViewSettings view_;
};

TEST_F(TrainerKeys, ChoosingAnotherInstrumentKeepsWhatTheMouseOrTheGamepadHolds) {
  TrainerInput input = Input();
  Type(&input, ' ');  // takes the cursor
  input.Handle(ButtonEvent{MouseButton::kLeft, true});
  Type(&input, kKeyTab);
  EXPECT_EQ(input.target(0).jaw, 0) << "latched";
  EXPECT_EQ(input.target(1).jaw, 1);
  input.Handle(ButtonEvent{MouseButton::kLeft, false});
  EXPECT_EQ(input.target(0).jaw, 0);
  Type(&input, '1');
  EXPECT_EQ(input.target(0).jaw, 0);
  Type(&input, 'j');
  EXPECT_EQ(input.target(0).jaw, 1) << "as j does";

  input.Handle(GamepadEvent{.grip = true});
  EXPECT_EQ(input.target(1).jaw, 0);
  Type(&input, '2');
  EXPECT_EQ(input.target(1).jaw, 0) << "latched";
  EXPECT_EQ(input.target(0).jaw, 1) << "the grip is not that of the new second hand";
  input.Handle(GamepadEvent{});
  input.Handle(GamepadEvent{.grip = true});
  EXPECT_EQ(input.target(0).jaw, 0);
  Type(&input, '2');
  input.Handle(GamepadEvent{});
  EXPECT_EQ(input.target(0).jaw, 1) << "the same instrument chosen again";
}

TEST_F(TrainerKeys, ShiftExchangesBackwards) {
  TrainerInput input = Input();
  input.Handle(KeyEvent{kKeyShift, true});
  std::vector<int> held;
  for (int i = 0; i < 4; ++i) {
    Type(&input, 'x');
    held.push_back(input.control().instrument_index[0]);
  }
  EXPECT_EQ(held, (std::vector<int>{2, 1, 0, 2}));
  EXPECT_EQ(input.view().wanted_instrument, input.control().instrument_index);
}

TEST_F(TrainerKeys, AnArrowTurnsSlowlyAndHomeRestoresTheFirstView) {
  TrainerInput input = Input();
  const Laparoscope first(input.view().scope, kSide, kSide);
  input.Handle(KeyEvent{kKeyRight, true});
  for (int i = 0; i < 30; ++i) input.Advance(0.01);
  input.Handle(KeyEvent{kKeyRight, false});
  const Laparoscope turned(input.view().scope, kSide, kSide);
  const double turn = std::acos(turned.ViewingAxis_W().dot(first.ViewingAxis_W()));
  EXPECT_GT(turn, 1 * kDegree);
  EXPECT_LT(turn, 3 * kDegree) << "0.3 s";
  Type(&input, 'a');
  input.Handle(KeyEvent{'+', true});
  input.Advance(0.1);
  Type(&input, kKeyHome);
  EXPECT_EQ(input.view().scope.angle, view_.scope.angle);
  EXPECT_EQ(input.view().scope.field_of_view, view_.scope.field_of_view);
  EXPECT_EQ(input.view().scope.p_scope_W, view_.scope.p_scope_W);
  EXPECT_EQ(input.view().scope.p_target_W, view_.scope.p_target_W);
}

TEST_F(TrainerKeys, BackspaceAsksForThePresentStepAgainAndWithShiftForTheOneBefore) {
  TrainerInput without = Input();
  Type(&without, kKeyBackspace);
  EXPECT_EQ(without.control().restart.count, 0) << "the scene has no exercise";
  view_.has_exercise = true;
  TrainerInput input = Input();
  Type(&input, kKeyBackspace);
  EXPECT_EQ(input.control().restart.count, 1);
  EXPECT_EQ(input.control().restart.step, RestartRequest::kPresent);
  input.Handle(KeyEvent{kKeyShift, true});
  Type(&input, kKeyBackspace);
  EXPECT_EQ(input.control().restart.count, 2);
  EXPECT_EQ(input.control().restart.step, RestartRequest::kPresent - 1);
  input.Restart(3);
  EXPECT_EQ(input.control().restart.count, 3) << "the teacher's";
  EXPECT_EQ(input.control().restart.step, 3);
}

}  // namespace
}  // namespace hpdm
