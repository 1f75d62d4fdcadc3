#include "tools/session/trainer_input.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "engine/base/angle.h"
#include "engine/base/check.h"
#include "render/camera/laparoscope.h"

namespace hpdm {
namespace {

// Rates of held keys, per second.
constexpr double kScopeTurn = 8 * kDegree;  // rad
constexpr double kScopeSlide = 0.04;        // m
constexpr double kOpticsTurn = 60 * kDegree;
constexpr double kToolTurn = 120 * kDegree;
constexpr double kZoom = 1.8;         // factor on the focal length
constexpr double kHandSpeed = 0.04;   // m of the second hand's tip, across the picture
constexpr double kHandInsert = 0.03;  // m, along its shaft
constexpr double kKeyShare = 0.5;  // of these two: a key cannot be pressed a little, as a stick can

constexpr double kWheelInsertion = 0.004;    // m per step
constexpr double kFineInsertion = 0.001;     // m, for one that comes after kSlowWheel
constexpr double kSlowWheel = 0.15;          // s
constexpr double kDragTurn = 0.5 * kDegree;  // rad per pixel
constexpr double kMinTipDepth = 0.01;        // m: a tip at the lens would not follow the cursor

// Overlays that the key o shows in turn.
constexpr std::uint32_t kOverlayCycle[] = {
    kOverlayText,
    kOverlayText | kOverlayForce,
    kOverlayText | kOverlayForce | kOverlayContacts,
    kOverlayText | kOverlayLattice,
    kOverlayText | kOverlayError,
    kOverlayNone,
};
constexpr double kOptics[] = {0, 30 * kDegree, 45 * kDegree};

}  // namespace

TrainerInput::TrainerInput(const ViewSettings& view, const std::vector<Instrument>& instruments)
    : view_(view), first_scope_(view.scope), instruments_(instruments) {
  HPDM_CHECK(instruments.size() <= kMaxInstruments);
  for (std::size_t i = 0; i < instruments.size(); ++i) targets_[i] = instruments[i].start;
  // The first active instrument is the first that the mouse moves.
  if (!HasHand()) NextInstrument();
}

bool TrainerInput::HasHand() const {
  const auto active = static_cast<std::size_t>(view_.active_instrument);
  return active < instruments_.size() && instruments_[active].mouse && !view_.paused;
}

void TrainerInput::Handle(const WindowEvent& event) {
  Take(event);
  view_.click_takes = !captured_ && HasHand();
}

void TrainerInput::Take(const WindowEvent& event) {
  if (const auto* key = std::get_if<KeyEvent>(&event)) {
    if (key->down) {
      held_.insert(key->key);
      Press(key->key);
    } else {
      held_.erase(key->key);
    }
    UpdatePedal();
  } else if (const auto* motion = std::get_if<MotionEvent>(&event)) {
    Move(*motion);
  } else if (const auto* wheel = std::get_if<WheelEvent>(&event)) {
    TurnWheel(wheel->steps);
  } else if (const auto* button = std::get_if<ButtonEvent>(&event)) {
    if (button->button == MouseButton::kLeft) {
      // The click that captures the cursor does not close the jaws.
      grips_ = button->down && captured_;
      captured_ |= button->down;
      UpdateJaw();
    } else if (button->button == MouseButton::kRight) {
      twists_ = button->down;
    }
  } else if (const auto* size = std::get_if<ResizeEvent>(&event)) {
    view_.window_width = size->width;
    view_.window_height = size->height;
  } else if (const auto* focus = std::get_if<FocusEvent>(&event)) {
    if (focus->focused) return;
    // Another window has the keyboard: all keys and buttons count as released.
    held_.clear();
    gamepad_ = {};
    pad_grips_ = false;
    captured_ = grips_ = twists_ = false;
    UpdateJaw();
    UpdatePedal();
  } else if (const auto* gamepad = std::get_if<GamepadEvent>(&event)) {
    const bool gripped = gamepad_.grip;
    gamepad_ = *gamepad;
    if (gamepad_.grip != gripped) pad_grips_ = gamepad_.grip;
    UpdateJaw();
  } else if (std::holds_alternative<CloseEvent>(event)) {
    ended_ = true;
  }
}

void TrainerInput::Press(int key) {
  switch (key) {
    case kKeyEscape:
      ended_ = true;
      break;
    case kKeyF1:
      view_.help = !view_.help;
      break;
    case ' ':
      captured_ = !captured_;
      grips_ = twists_ = false;
      UpdateJaw();
      break;
    case kKeyTab:
      NextInstrument();
      break;
    case '1':
    case '2':
    case '3':
    case '4':
      Activate(key - '1');
      break;
    case 'j':
      closed_[view_.active_instrument] = !closed_[view_.active_instrument];
      UpdateJaw();
      break;
    case 'v':
      if (const int second = SecondHand(); second >= 0) closed_[second] = !closed_[second];
      UpdateJaw();
      break;
    case 'x':
      Exchange();
      break;
    case kKeyHome:
      view_.scope = first_scope_;
      break;
    case kKeyBackspace:
      Restart(Shift() ? RestartRequest::kPresent - 1 : RestartRequest::kPresent);
      break;
    case 'a':
      NextOptics();
      break;
    case 'o':
      NextOverlay();
      break;
    case 'i':
      view_.guidance = !view_.guidance;
      break;
    case 'p':
      SetPaused(!view_.paused);
      break;
    case 's':
      ++view_.screenshots;
      break;
    case 'r':
      view_.recording = !view_.recording;
      break;
    default:
      break;
  }
}

void TrainerInput::SetPaused(bool paused) {
  control_.paused = view_.paused = paused;
  UpdateJaw();
  UpdatePedal();
  view_.click_takes = !captured_ && HasHand();
}

void TrainerInput::Restart(int step) {
  if (view_.has_exercise && !ended_) control_.restart = {control_.restart.count + 1, step};
}

void TrainerInput::Advance(double seconds) {
  wheel_rests_ += seconds;
  const auto axis = [this, seconds](int forth, int back) {
    return seconds * (static_cast<double>(Held(forth)) - static_cast<double>(Held(back)));
  };
  MoveScope(kScopeTurn * axis(kKeyUp, kKeyDown), kScopeTurn * axis(kKeyRight, kKeyLeft),
            kScopeSlide * axis(kKeyPageUp, kKeyPageDown), kOpticsTurn * axis('.', ','),
            std::pow(kZoom, axis(Held('=') ? '=' : '+', '-')));
  if (HasHand()) Turn(view_.active_instrument, kToolTurn * axis('e', 'q'));
  MoveSecondHand(seconds);
}

int TrainerInput::SecondHand() const {
  const std::size_t count = instruments_.size();
  for (std::size_t step = 1; step <= count; ++step) {
    const std::size_t next = (static_cast<std::size_t>(view_.active_instrument) + step) % count;
    if (instruments_[next].mouse) return static_cast<int>(next);
  }
  return -1;
}

void TrainerInput::MoveSecondHand(double seconds) {
  const int second = SecondHand();
  if (second < 0 || view_.paused) return;
  const auto rate = [this](int forth, int back, double stick, double key) {
    const double keys = static_cast<double>(Held(forth)) - static_cast<double>(Held(back));
    return std::clamp(key * keys + stick, -1.0, 1.0);
  };
  const Vector3d across_C(rate('h', 'f', gamepad_.right, kKeyShare),
                          rate('t', 'g', gamepad_.up, kKeyShare), 0);
  if (!across_C.isZero()) {
    const Laparoscope scope(view_.scope, Laparoscope::kMinSide, Laparoscope::kMinSide);
    const Vector3d move_W = scope.X_WC().linear() * (kHandSpeed * seconds * across_C);
    SetTarget(second, targets_[second].p_W + move_W, targets_[second].roll);
  }
  Insert(second, kHandInsert * seconds * rate('y', 'b', gamepad_.in, kKeyShare));
  Turn(second, kToolTurn * seconds * rate('n', 'c', gamepad_.roll, 1));
}

void TrainerInput::TurnWheel(double steps) {
  const bool slow = wheel_rests_ > kSlowWheel;
  wheel_rests_ = 0;
  if (Shift()) {
    MoveScope(0, 0, kWheelInsertion * steps, 0, 1);
  } else if (HasHand()) {
    Insert(view_.active_instrument, (slow ? kFineInsertion : kWheelInsertion) * steps);
  }
}

void TrainerInput::Move(const MotionEvent& motion) {
  if (!captured_) return;
  if (Shift()) {
    // Dragging across the circle's radius turns the view by half of its field of view.
    const double turn = view_.scope.field_of_view / PixelsAcross();
    MoveScope(-turn * motion.dy, turn * motion.dx, 0, 0, 1);
    return;
  }
  if (!HasHand()) return;
  if (twists_) {
    Turn(view_.active_instrument, kDragTurn * motion.dx);
    return;
  }
  const int active = view_.active_instrument;
  SetTarget(active, FollowOnScreen(targets_[active].p_W, motion), targets_[active].roll);
}

// Moves a point with the cursor, at its distance from the lens.
Vector3d TrainerInput::FollowOnScreen(const Vector3d& p_W, const MotionEvent& motion) const {
  // A square picture as high as the circle has the window's pixels.
  const int side = std::clamp(std::min(view_.window_width, view_.window_height),
                              Laparoscope::kMinSide, Laparoscope::kMaxSide);
  const Laparoscope scope(view_.scope, side, side);
  const Vector3d pixel = scope.Project(p_W);
  const double depth = std::max(kMinTipDepth, pixel.z()), focal = scope.focal_length_px();
  Vector3d move_C(depth * motion.dx / focal, -depth * motion.dy / focal, 0);
  // Corrects for the lens distortion inside the picture circle.
  const Eigen::Vector2d from = pixel.head<2>() - Eigen::Vector2d::Constant(0.5 * side);
  const Eigen::Vector2d to = from + Eigen::Vector2d(motion.dx, motion.dy);
  const double edge = scope.circle_radius_px();
  if (pixel.z() > kMinTipDepth && from.norm() < edge && to.norm() < edge) {
    const auto straight = [&scope, focal](const Eigen::Vector2d& at) -> Eigen::Vector2d {
      const double tangent = at.norm() / focal;
      return tangent == 0 ? at : Eigen::Vector2d(at * (scope.Undistorted(tangent) / tangent));
    };
    const Eigen::Vector2d move = depth / focal * (straight(to) - straight(from));
    move_C << move.x(), -move.y(), 0;
  }
  return p_W + scope.X_WC().linear() * move_C;
}

double TrainerInput::PixelsAcross() const {
  const int side = std::min(view_.window_width, view_.window_height);
  return Laparoscope::kCircleFraction * std::max(side, Laparoscope::kMinSide);
}

void TrainerInput::Turn(int instrument, double roll) {
  if (roll == 0) return;
  SetTarget(instrument, targets_[instrument].p_W, targets_[instrument].roll + roll);
}

// Pushes the tip in along the shaft by `length`, m.
void TrainerInput::Insert(int instrument, double length) {
  if (length == 0) return;
  const Vector3d& p_W = targets_[instrument].p_W;
  const Vector3d along_W = (p_W - instruments_[instrument].mouse->p_trocar_W()).normalized();
  SetTarget(instrument, p_W + length * along_W, targets_[instrument].roll);
}

// Clamps the target to the device's workspace, so that a mouse moved beyond it takes effect as soon
// as it turns back.
void TrainerInput::SetTarget(int instrument, const Vector3d& p_W, double roll) {
  HandTarget& target = targets_[instrument];
  const ImpulseEngineKinematics& kinematics = *instruments_[instrument].mouse;
  const JointVector joints = kinematics.Inverse(p_W, roll, target.jaw).joints;
  target.p_W = kinematics.Forward(joints).translation();
  target.roll = joints[kRoll];
}

void TrainerInput::UpdateJaw() {
  for (int i = 0; i < static_cast<int>(instruments_.size()); ++i) {
    const bool gripped =
        (grips_ && i == view_.active_instrument) || (pad_grips_ && i == SecondHand());
    if (!view_.paused) targets_[i].jaw = closed_[i] || gripped ? 0 : 1;
  }
}

void TrainerInput::UpdatePedal() { control_.pedal.fill(Held('d') && !view_.paused); }

void TrainerInput::MoveScope(double up, double right, double insertion, double roll, double zoom) {
  if (up == 0 && right == 0 && insertion == 0 && roll == 0 && zoom == 1) return;
  view_.scope = Moved(
      view_.scope, {.up = up, .right = right, .insertion = insertion, .roll = roll, .zoom = zoom});
}

void TrainerInput::NextOptics() {
  // Takes the next larger angle; after the largest the first again.
  const auto* next = std::find_if(std::begin(kOptics), std::end(kOptics), [this](double angle) {
    return angle > view_.scope.angle + 1e-6;
  });
  view_.scope = WithOptics(view_.scope, next == std::end(kOptics) ? kOptics[0] : *next);
}

void TrainerInput::NextOverlay() {
  const auto* now = std::find(std::begin(kOverlayCycle), std::end(kOverlayCycle), view_.overlays);
  do {
    const bool last = now == std::end(kOverlayCycle) || std::next(now) == std::end(kOverlayCycle);
    now = last ? std::begin(kOverlayCycle) : std::next(now);
  } while ((*now & kOverlayError) != 0 && !view_.has_reference);
  view_.overlays = *now;
}

void TrainerInput::NextInstrument() {
  for (std::size_t step = 1; step <= instruments_.size(); ++step) {
    const std::size_t next =
        (static_cast<std::size_t>(view_.active_instrument) + step) % instruments_.size();
    if (!instruments_[next].mouse) continue;
    Activate(static_cast<int>(next));
    return;
  }
}

void TrainerInput::Activate(int instrument) {
  if (static_cast<std::size_t>(instrument) >= instruments_.size()) return;
  if (!instruments_[instrument].mouse) return;
  // What the mouse or the gamepad holds stays held.
  if (instrument != view_.active_instrument && !view_.paused) {
    if (grips_) closed_[view_.active_instrument] = true;
    if (const int second = SecondHand(); pad_grips_ && second >= 0) closed_[second] = true;
    pad_grips_ = false;
  }
  view_.active_instrument = instrument;
  grips_ = false;
  UpdateJaw();
}

// Asks for the active hand's next instrument, or with Shift for the previous one.
void TrainerInput::Exchange() {
  const auto active = static_cast<std::size_t>(view_.active_instrument);
  if (active >= instruments_.size()) return;
  const int count = instruments_[active].exchanges;
  int& instrument_index = control_.instrument_index[active];
  instrument_index = (instrument_index + (Shift() ? count - 1 : 1)) % count;
  view_.wanted_instrument[active] = instrument_index;
}

}  // namespace hpdm
