#include "tools/python/native/session_calls.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>

#include "scenes/loader/scene.h"
#include "tools/python/native/python_errors.h"

namespace hpdm {
namespace {

namespace py = pybind11;

const InstrumentOptions& RequireHand(const LockstepSession& session, std::size_t hand) {
  const Scene& scene = session.model().scene();
  if (hand >= scene.instruments.size()) FailIndex("there is no such instrument");
  return scene.instruments[hand];
}

}  // namespace

py::object ExerciseOf(const LockstepSession& session) {
  const std::optional<ExerciseEvaluator>& exercise = session.exercise();
  if (!exercise) return py::none();
  const ExerciseResult& result = exercise->result();
  const ExerciseStatus status = exercise->Status();
  py::list errors;
  for (const ExerciseError& error : result.errors) {
    py::dict one;
    one["name"] = exercise->options().errors[ToSize(error.rule)].name;
    one["points"] = exercise->options().errors[ToSize(error.rule)].points;
    one["time"] = error.time;
    one["step"] = error.step;
    one["hand"] = error.hand;
    one["organ"] = error.organ;
    one["duct"] = error.duct;
    one["place"] = py::array_t<double>(3, error.place_W.data());
    one["force"] = error.force;
    errors.append(one);
  }
  py::dict all;
  all["step"] = status.step;
  all["steps"] = exercise->options().steps.size();
  all["progress"] = status.progress;
  all["step_times"] = result.step_times;
  all["errors"] = errors;
  all["time"] = result.time;
  all["score"] = result.score;
  all["ended"] = result.ended;
  all["passed"] = result.passed;
  return all;
}

void ExchangeTool(LockstepSession* session, std::size_t hand, int held) {
  const InstrumentOptions& options = RequireHand(*session, hand);
  const int count = options.HeldCount();
  if (held < 0 || held >= count) {
    FailIndex("instrument " + std::to_string(held) + " of hand \"" + options.name + "\": it has " +
              std::to_string(count));
  }
  session->Exchange(hand, held);
}

void PressPedal(LockstepSession* session, std::size_t hand, bool pressed) {
  RequireHand(*session, hand);
  session->Press(hand, pressed);
}

}  // namespace hpdm
