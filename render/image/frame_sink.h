#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/types.h"
#include "render/image/image_file.h"

namespace hpdm {

/// Writes pictures as a film of constant rate: frame_000000.png, frame_000001.png, ... in one
/// folder, numbered without holes; a new one whenever the session passes a multiple of 1 / fps. A
/// folder that is renamed meanwhile takes its film along. One thread.
class FrameSink {
 public:
  /// Creates the folder. Throws InputError when that fails or `fps` is not in (0, 1000].
  FrameSink(std::filesystem::path folder, double fps);
  ~FrameSink();
  FrameSink(const FrameSink&) = delete;
  FrameSink& operator=(const FrameSink&) = delete;

  /// Takes the picture of session time `time_ns` (not before the last one) and writes the frames
  /// that have become due: none when the session has not reached the next one, several of the same
  /// picture when it is past more than one. At most kMaxRepeats at once: after a longer stall the
  /// film skips ahead, so that one late picture cannot hold up the next ones. A write that fails
  /// ends the film (failure()).
  void Add(const Image& image, Nanoseconds time_ns);

  /// The film pauses: the next picture follows the last one, whatever time has passed.
  void Break() { first_ = true; }

  static constexpr int kMaxRepeats = 10;

  std::uint64_t written() const { return written_; }
  /// One line, empty while all is well.
  const std::string& failure() const { return failure_; }

 private:
  std::filesystem::path folder_;
  int folder_descriptor_;
  double fps_;
  bool first_ = true;
  std::int64_t next_frame_ = 0;  // the next due, counted from session time 0
  std::uint64_t written_ = 0;
  std::vector<std::uint8_t> bytes_;
  std::string failure_;
};

}  // namespace hpdm
