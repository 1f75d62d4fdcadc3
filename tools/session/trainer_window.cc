#include "tools/session/trainer_window.h"

#include <algorithm>

namespace hpdm {
namespace {

// Longest time for which a held key acts in one update, after the program stalled.
constexpr double kMaxAdvance = 0.1;  // s

}  // namespace

TrainerWindow::TrainerWindow(int width, int height, const std::string& title,
                             const ViewSettings& view,
                             const std::vector<TrainerInput::Instrument>& instruments,
                             const Edges& edges)
    : window_(width, height, title), input_(view, instruments), edges_(edges) {
  Pump(0);
}

void TrainerWindow::Pump(double seconds) {
  for (const WindowEvent& event : window_.WaitForEvents(seconds)) input_.Handle(event);
  const Clock::time_point now = Clock::now();
  const double elapsed = std::chrono::duration<double>(now - pumped_).count();
  pumped_ = now;
  input_.Advance(std::min(elapsed, kMaxAdvance));
  window_.CaptureCursor(input_.captured());
  Publish();
}

void TrainerWindow::Resume() {
  edges_.control.Back() = input_.control();
  edges_.control.Back().paused = false;
  edges_.control.Publish();
}

void TrainerWindow::Publish() {
  edges_.view.Back() = input_.view();
  edges_.view.Publish();
  edges_.control.Back() = input_.control();
  edges_.control.Publish();
  for (int i = 0; i < kMaxInstruments; ++i) {
    if (edges_.targets[i] == nullptr) continue;
    edges_.targets[i]->Back() = input_.target(i);
    edges_.targets[i]->Publish();
  }
}

}  // namespace hpdm
