#include "tools/python/native/python_errors.h"

#include <pthread.h>

#include "engine/base/error.h"

namespace hpdm {
namespace {

namespace py = pybind11;

std::atomic<int> forks = 0;  // of this process since the first one

void SetPythonError(const char* name, const char* message) {
  const py::object type = py::module_::import("hpdm.errors").attr(name);
  PyErr_SetString(type.ptr(), message);
}

}  // namespace

void RegisterErrors(py::module_* /*module*/) {
  pthread_atfork(nullptr, nullptr, [] { ++forks; });
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const InputError& error) {
      SetPythonError("InputError", error.what());
    } catch (const MachineError& error) {
      SetPythonError("MachineError", error.what());
    }
  });
}

void FailState(const std::string& message) { throw std::runtime_error(message); }
void FailValue(const std::string& message) { throw py::value_error(message); }
void FailIndex(const std::string& message) { throw py::index_error(message); }

ProcessCheck::ProcessCheck() : forks_(forks) {}
bool ProcessCheck::SameProcess() const { return forks_ == forks; }

void ProcessCheck::Require(const char* what) const {
  if (SameProcess()) return;
  FailState(std::string(what) +
            " belong to the parent process and do not run after a fork; start processes with "
            "multiprocessing.get_context(\"spawn\") and make the object there");
}

OneCaller::OneCaller(std::atomic<bool>* busy, const char* what) : busy_(busy) {
  if (busy_->exchange(true, std::memory_order_acquire)) {
    FailState(std::string(what) + " is in use by another thread; give each thread one of its own");
  }
}

}  // namespace hpdm
