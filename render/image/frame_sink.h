#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/types.h"
#include "render/image/image_file.h"

namespace hpdm {

/// Writes pictures as a film of constant rate: frame_000000.png, frame_000001.png, ... in one
/// folder, numbered without gaps, one for each multiple of 1 / fps in session time. The folder may
/// be renamed meanwhile. One thread.
class FrameSink {
 public:
  /// Creates the folder. Throws InputError if that fails or `fps` is not in (0, 1000].
  FrameSink(std::filesystem::path folder, double fps);
  ~FrameSink();
  FrameSink(const FrameSink&) = delete;
  FrameSink& operator=(const FrameSink&) = delete;

  /// Writes the picture of session time `time_ns` (not before the last one) once for each frame
  /// that is due: none, one, or several. After a stall of more than kMaxRepeats frames the film
  /// skips ahead, so that one late picture does not delay the next ones. A failed write ends the
  /// film (failure()).
  void Add(const Image& image, Nanoseconds time_ns);

  /// Pauses the film: the next picture follows the last one, without the time between.
  void Break() { first_ = true; }

  static constexpr int kMaxRepeats = 10;

  std::uint64_t written() const { return written_; }
  /// The reason why the film ended: one line; empty without a failure.
  const std::string& failure() const { return failure_; }

 private:
  std::filesystem::path folder_;
  int folder_descriptor_;
  double fps_;
  bool first_ = true;
  std::int64_t next_frame_ = 0;  // the next due frame, counted from session time 0
  std::uint64_t written_ = 0;
  std::vector<std::uint8_t> bytes_;
  std::string failure_;
};

}  // namespace hpdm
