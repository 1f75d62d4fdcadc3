#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <string>

namespace hpdm {

/// Turns InputError and MachineError into hpdm.InputError and hpdm.MachineError.
void RegisterErrors(pybind11::module_* module);

/// Throws Python's RuntimeError, ValueError or IndexError.
[[noreturn]] void FailState(const std::string& message);
[[noreturn]] void FailValue(const std::string& message);
[[noreturn]] void FailIndex(const std::string& message);

/// Refuses threads of a parent process: they do not exist after a fork.
class ProcessCheck {
 public:
  ProcessCheck();
  /// True in the process that constructed it.
  bool SameProcess() const;
  /// Throws RuntimeError in a forked child; `what`: "the batch's threads".
  void Require(const char* what) const;

 private:
  int forks_;  // before the construction
};

/// Holds an object for one call; throws RuntimeError if another thread has it.
class OneCaller {
 public:
  OneCaller(std::atomic<bool>* busy, const char* what);
  ~OneCaller() { busy_->store(false, std::memory_order_release); }
  OneCaller(const OneCaller&) = delete;
  OneCaller& operator=(const OneCaller&) = delete;

 private:
  std::atomic<bool>* busy_;
};

}  // namespace hpdm
