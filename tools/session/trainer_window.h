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

/// The trainee's window: takes its input and tells the loops what is asked of them.
///
///     window --HandTarget (an instrument each)--> haptic loop (MouseHand)
///        |  '--SessionControl-------------------> haptic loop
///        '-----ViewSettings---------------------> render loop
///
/// Main thread, but for MakeContext, which the render thread calls.
class TrainerWindow {
 public:
  /// What the window writes: the only writer of each.
  struct Edges {
    TripleBuffer<ViewSettings>& view;
    TripleBuffer<SessionControl>& control;
    std::array<TripleBuffer<HandTarget>*, kMaxInstruments> targets;  ///< Null: not the mouse's.
  };

  /// Opens the window with a picture of width x height pixels and tells the loops where they start.
  /// Throws MachineError as Window does.
  TrainerWindow(int width, int height, const std::string& title, const ViewSettings& view,
                const std::vector<TrainerInput::Instrument>& instruments, const Edges& edges);

  /// Takes what has been typed and moved, waiting at most `seconds` for it, and tells the loops.
  void Pump(double seconds);

  /// Ends a pause that nobody can end by a key any more.
  void Resume();

  bool ended() const { return input_.ended(); }  ///< The user wants no more.
  bool lost() const { return window_.lost(); }   ///< Its display was lost.

  /// Of the calling thread, which draws.
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
