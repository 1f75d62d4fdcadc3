#include "engine/checkpoints.h"

#include <utility>

#include "engine/base/types.h"

namespace hpdm {

void Checkpoints::MakeRoom(const DeformationLoop& loop) { states_.assign(kept_.size(), loop); }

Checkpoints::Change Checkpoints::Follow(const RestartRequest& request, DeformationLoop* loop) {
  Change change;
  if (request.count != requests_) {
    requests_ = request.count;
    const bool of_present = request.step < 0;
    change.restarted = Restart(
        of_present ? present_ - RestartRequest::kPresent + request.step : request.step, loop);
  }
  change.kept = StepToKeep();
  if (change.kept >= 0) {
    states_[ToSize(change.kept)] = *loop;
    kept_[ToSize(change.kept)] = true;
    present_ = change.kept;
  }
  return change;
}

// Returns the step that begins again; -1 if it has never begun.
int Checkpoints::Restart(int step, DeformationLoop* loop) {
  if (step < 0 || step > present_ || !kept_[ToSize(step)]) return -1;
  loop->ReturnTo(states_[ToSize(step)]);
  present_ = step;
  ++restarts_;
  return step;
}

// A step that begins after a restart that the exercise does not know of yet is not the present one.
int Checkpoints::StepToKeep() {
  progress_.Update();
  const ExerciseProgress& progress = progress_.Front();
  const bool is_new = progress.restarts == restarts_ && progress.step != present_;
  const int step = std::exchange(recorded_, std::nullopt).value_or(is_new ? progress.step : -1);
  return step < std::ssize(kept_) ? step : -1;
}

}  // namespace hpdm
