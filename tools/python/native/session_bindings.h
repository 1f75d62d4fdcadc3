#pragma once

#include <pybind11/pybind11.h>

namespace hpdm {

/// Adds the scene's model, sessions and their states. Docstrings for users are in hpdm/*.py.
void BindSessions(pybind11::module_* module);

/// Adds batches. Call after BindSessions.
void BindBatches(pybind11::module_* module);

/// Adds scenes, logs, static solutions, plans and drivers.
void BindFiles(pybind11::module_* module);

}  // namespace hpdm
