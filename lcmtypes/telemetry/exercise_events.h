#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/exercise/exercise_evaluator.h"

/// Events that an exercise is judged by, besides its steps.
namespace hpdm {

/// Name of the event that a lumen begins to leak.
inline constexpr std::string_view kPerforated = "lumen.perforated";

/// Returns the name of an organ's lumen: "the lumen of gallbladder". `number`: of its lumens; -1: it has one.
std::string LumenName(std::string_view organ, int number = -1);

/// Returns the text of kPerforated.
std::string PerforatedText(std::string_view lumen);

/// Returns the index in `organs` of the organ that a text of kPerforated is about; -1: none.
int PerforatedOrgan(std::string_view text, const std::vector<std::string>& organs);

/// Passes an event of a session to its exercise if that needs it, with the event's session time.
void AddExerciseEvent(Nanoseconds time_ns, std::string_view name, std::string_view text,
                      ExerciseEvaluator* exercise);

}  // namespace hpdm
