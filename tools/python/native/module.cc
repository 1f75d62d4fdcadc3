#include <pybind11/pybind11.h>

#include "tools/python/native/python_errors.h"
#include "tools/python/native/session_bindings.h"

PYBIND11_MODULE(_native, module) {
  hpdm::RegisterErrors(&module);
  hpdm::BindFiles(&module);
  hpdm::BindSessions(&module);
  hpdm::BindBatches(&module);
}
