#pragma once

#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/snapshots.h"

namespace hpdm {

/// Writes the haptic samples thinned to a plot's resolution as comma-separated values: the time (s)
/// and for each instrument NAME the columns NAME_force (|F|, N), NAME_fx, _fy, _fz (force on the
/// hand, world, N), NAME_depth (m), NAME_x, _y, _z (tip, world, m) and NAME_contact (0 or 1). The
/// first sample at or after each multiple of the interval is kept as it is. Numbers have nine
/// significant digits whatever the locale, so that equal samples give equal bytes. One thread.
class Timeline {
 public:
  /// `interval` in ns. Names are written with their commas, quotes and line breaks replaced by "_".
  /// Throws InputError if the file cannot be created.
  Timeline(const std::string& path, Nanoseconds interval, std::span<const std::string> instruments);

  /// Never throws. Nothing more is written after a failed write.
  void Add(const HapticSample& sample) noexcept;
  /// Hands what was added to the operating system, which may refuse it.
  void Flush() noexcept;
  void Close() noexcept;

  /// Why rows are missing, with the remedy; empty if every row reached the file. Final after
  /// Close.
  std::string Explain() const;

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void Check(bool written) noexcept;

  std::unique_ptr<std::FILE, Closer> file_;
  Nanoseconds interval_;
  Nanoseconds next_ = 0;
  int tool_count_;
  bool failed_ = false;
  int error_ = 0;  // errno of the failure
};

}  // namespace hpdm
