#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "engine/snapshots.h"
#include "haptics/device/impulse_engine.h"
#include "haptics/device/mouse_hand.h"
#include "render/overlay/view_settings.h"
#include "render/window/window_event.h"

namespace hpdm {

/// Translates a window's keyboard and mouse events into controls of the loops. It has no window,
/// thread or clock of its own, so the same events give the same controls.
///
///     mouse (cursor captured)        moves the active instrument's tip across the picture
///     wheel                          inserts the instrument along its shaft, finely if turned slowly
///     left button; j                 closes its jaws while held; until pressed again
///     right button and drag; q, e    roll it
///     t, g, f, h                     move the second hand's tip up, down, left, right
///     y, b; c, n; v                  push it in, pull it out; roll it; close or open its jaws
///     gamepad                        the same: left stick, triggers, right stick, lower button
///     d                              presses the pedal of all instruments while held
///     Tab; 1, 2                      next instrument; that instrument. The last one's closed jaws
///                                    stay closed, as by j
///     x; Shift and x                 next exchange of the instrument; the previous one
///     Shift and mouse or wheel, arrows, PgUp, PgDn   move the scope about its trocar
///     +, -; a; comma, period         zoom; optics of 0, 30, 45 degrees; turn them
///     Home                           first view
///     Backspace; Shift and Backspace   begin the exercise's present step again; the one before it
///     o, i, p, s, r, F1              overlays, guidance, pause, screenshot, recording, help
///     Space or a click               captures the cursor; Space lets it go
///     Esc                            ends the session
///
/// The second hand is the next one that the window moves, so that the keyboard or a gamepad moves
/// one hand and the mouse the other at the same time. If the window moves one hand only, it is that
/// one. Its keys work while the cursor is free.
///
/// The tip moves in the plane through it that is parallel to the picture, as far as the cursor
/// moves on the screen. The device's workspace bounds it.
class TrainerInput {
 public:
  /// An instrument of the session.
  struct Instrument {
    std::optional<ImpulseEngineKinematics> mouse;  ///< Only if the window moves the instrument.
    HandTarget start;                              ///< The mouse's first target.
    int exchanges = 1;  ///< Number of instruments that the hand can hold in turn.
  };

  /// `view` is the window's first view. `instruments`: at most kMaxInstruments.
  TrainerInput(const ViewSettings& view, const std::vector<Instrument>& instruments);

  void Handle(const WindowEvent& event);
  /// Applies the held keys for `seconds`.
  void Advance(double seconds);

  /// Pauses or continues the session, as the key p does.
  void SetPaused(bool paused);

  /// Asks for a restart of the exercise, as the key Backspace does. `step`: as in RestartRequest.
  void Restart(int step);

  const ViewSettings& view() const { return view_; }
  const SessionControl& control() const { return control_; }
  const HandTarget& target(int instrument) const { return targets_[instrument]; }
  bool captured() const { return captured_; }  ///< The cursor moves the instrument.
  bool ended() const { return ended_; }

 private:
  void Take(const WindowEvent& event);
  void Press(int key);
  void Move(const MotionEvent& motion);
  void Turn(int instrument, double roll);
  void Insert(int instrument, double length);
  void MoveSecondHand(double seconds);
  void TurnWheel(double steps);
  void MoveScope(double up, double right, double insertion, double roll, double zoom);
  void NextInstrument();
  void Activate(int instrument);
  void Exchange();
  void NextOverlay();
  void NextOptics();
  void SetTarget(int instrument, const Vector3d& p_W, double roll);
  bool Held(int key) const { return held_.contains(key); }
  bool Shift() const { return Held(kKeyShift); }
  /// True if the mouse can move an instrument now.
  bool HasHand() const;
  /// Returns the hand that the keyboard and the gamepad move; -1: none.
  int SecondHand() const;
  void UpdateJaw();
  void UpdatePedal();
  Vector3d FollowOnScreen(const Vector3d& p_W, const MotionEvent& motion) const;
  double PixelsAcross() const;

  ViewSettings view_;
  LaparoscopeOptions first_scope_;
  SessionControl control_;
  std::vector<Instrument> instruments_;
  std::array<HandTarget, kMaxInstruments> targets_;
  std::array<bool, kMaxInstruments> closed_{};  // by key, until it is pressed again
  std::set<int> held_;
  GamepadEvent gamepad_;
  double wheel_rests_ = 0;  // s since the wheel turned
  bool pad_grips_ = false;  // the gamepad's grip is held, since the present second hand is one
  bool grips_ = false;      // the left button is held
  bool twists_ = false;     // the right button is held
  bool captured_ = false;
  bool ended_ = false;
};

}  // namespace hpdm
