#pragma once

#include <limits>

namespace hpdm {

/// Counts how often the tissue in one tool's jaws slips. Rests of at most kRest between two ticks
/// that slip belong to the same slip, since the tremor of a hand interrupts it.
class SlipCounter {
 public:
  static constexpr double kRest = 0.25;  ///< s.

  /// Adds a tick at `time` (s) with its ToolSample::slip (m). Returns true if a slip begins.
  bool Add(double time, double slip) {
    const bool slips = slip > last_;
    const bool begins = slips && time - until_ > kRest;
    last_ = slip;
    if (slips) until_ = time;
    count_ += begins;
    return begins;
  }
  int count() const { return count_; }

 private:
  double last_ = 0;                                          // m
  double until_ = -std::numeric_limits<double>::infinity();  // s
  int count_ = 0;
};

}  // namespace hpdm
