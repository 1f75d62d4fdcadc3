#pragma once

#include <pybind11/pybind11.h>

#include "tools/session/lockstep_session.h"

namespace hpdm {

/// Calls of Python on one session, which may be one of a batch. The session does not step meanwhile.

/// Returns the judgement of the scene's exercise as a dict; None in a scene without one.
pybind11::object ExerciseOf(const LockstepSession& session);

/// Gives a hand its instrument number `held` (0: the first) once its tip is free. Throws IndexError if
/// there is no such hand or instrument.
void ExchangeTool(LockstepSession* session, std::size_t hand, int held);

/// Presses or releases the pedal of a hand from the next step on. Throws IndexError if there is no
/// such hand.
void PressPedal(LockstepSession* session, std::size_t hand, bool pressed);

}  // namespace hpdm
