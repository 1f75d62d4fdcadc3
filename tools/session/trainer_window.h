#pragma once

#include <array>
#include <chrono>
#include <string>
#include <vector>

#include "engine/snapshots.h"
#include "engine/threads/triple_buffer.h"
#include "render/overlay/view_settings.h"
#include "render/window/window.h"
#include "tools/session/trainer_input.h"

namespace hpdm {

/// The trainee's window: handles its input and publishes the controls of the loops.
///
///     window --HandTarget (an instrument each)--> haptic loop (MouseHand)
///        |  '--SessionControl-------------------> haptic loop
///        '-----ViewSettings---------------------> render loop
///
/// Main thread, but for MakeContext, which the render thread calls.
class TrainerWindow {
 public:
  /// Edges of which the window is the only writer.
  struct Edges {
    TripleBuffer<ViewSettings>& view;
    TripleBuffer<SessionControl>& control;
    std::array<TripleBuffer<HandTarget>*, kMaxInstruments> targets;  ///< Null: no mouse device.
  };

  /// Opens the window with a picture of width x height pixels and publishes the first controls.
  /// Throws MachineError as Window does.
  TrainerWindow(int width, int height, const std::string& title, const ViewSettings& view,
                const std::vector<TrainerInput::Instrument>& instruments, const Edges& edges);

  /// Waits at most `seconds` for input, handles it and publishes the controls.
  void Pump(double seconds);

  /// Pauses or continues the session, as the key does. The controls are published by Pump.
  void SetPaused(bool paused) { input_.SetPaused(paused); }

  /// Asks for a restart of the exercise, as the key does. `step`: as in RestartRequest.
  void Restart(int step) { input_.Restart(step); }

  /// Ends a pause after the window is lost, when no key can end it.
  void Resume();

  bool paused() const { return input_.control().paused; }
  bool ended() const { return input_.ended(); }  ///< The user ended the session.
  bool lost() const { return window_.lost(); }   ///< The connection to the display is lost.

  /// Makes the context of the calling thread, which draws.
  std::unique_ptr<RenderContext> MakeContext() { return window_.MakeContext(); }

 private:
  using Clock = std::chrono::steady_clock;

  void Publish();

  Window window_;
  TrainerInput input_;
  Edges edges_;
  Clock::time_point pumped_ = Clock::now();
};

}  // namespace hpdm
