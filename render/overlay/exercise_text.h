#pragma once

#include <vector>

#include "render/overlay/status_text.h"

namespace hpdm {

/// Returns the step at which the exercise is; nullptr without one, as in a replay, and after the last.
const ExerciseStepOptions* PresentStep(const ExerciseStatus& status, const StatusNames& names);

/// Returns the exercise's present step, how far it is, and the last error for a while. `tautness`: that of
/// the layer to free (Status::tautness).
std::vector<StatusLine> GuidanceLines(const ExerciseStatus& status, const ExerciseOptions& exercise,
                                      double tautness, bool paused);

/// Returns the kinds of errors so far, with how often each was made.
std::vector<StatusLine> ErrorLines(const ExerciseStatus& status, const ExerciseOptions& exercise);

/// Returns the result of an exercise that has ended: its score, the steps that were done with their
/// times, the errors with their points, and how to go on.
std::vector<StatusLine> ResultLines(const ExerciseStatus& status, const ExerciseOptions& exercise);

}  // namespace hpdm
