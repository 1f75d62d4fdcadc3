#pragma once

#include <string>

namespace hpdm {

/// Says on standard error what is being prepared: on a terminal in one line that changes, elsewhere
/// in a line each, "hpdm: preparing WHAT". Main thread.
class SetUpProgress {
 public:
  /// `quiet`: says nothing.
  explicit SetUpProgress(bool quiet);
  /// Clears the terminal's line, so that a message of failure starts at its beginning.
  ~SetUpProgress() { Clear(); }
  SetUpProgress(const SetUpProgress&) = delete;
  SetUpProgress& operator=(const SetUpProgress&) = delete;

  /// Says that `what` is being prepared now.
  void Say(const std::string& what);
  /// Clears the terminal's line.
  void Clear();

 private:
  bool quiet_;
  bool terminal_;
  bool shown_ = false;  // the terminal's line has text
};

}  // namespace hpdm
