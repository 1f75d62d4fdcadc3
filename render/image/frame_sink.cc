#include "render/image/frame_sink.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <system_error>
#include <utility>

#include "engine/base/error.h"

namespace hpdm {

FrameSink::FrameSink(std::filesystem::path folder, double fps)
    : folder_(std::move(folder)), fps_(fps) {
  if (!(fps > 0 && fps <= 1000)) {
    throw InputError("frames: " + std::to_string(fps) +
                     " frames a second cannot be written; give more than 0, at most 1000");
  }
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) {
    throw InputError(folder_.string() + ": the folder cannot be created (" + error.message() +
                     "); choose another one");
  }
  folder_descriptor_ = open(folder_.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
}

FrameSink::~FrameSink() {
  if (folder_descriptor_ >= 0) close(folder_descriptor_);
}

void FrameSink::Add(const Image& image, Nanoseconds time_ns) {
  const auto newest = static_cast<std::int64_t>(std::floor(ToSeconds(time_ns) * fps_ + 1e-6));
  if (first_) next_frame_ = newest;
  first_ = false;
  if (newest < next_frame_ || !failure_.empty()) return;
  EncodePng(image, &bytes_);
  next_frame_ = std::max(next_frame_, newest + 1 - kMaxRepeats);
  for (; next_frame_ <= newest; ++next_frame_) {
    char name[40];
    // Numbers stay consecutive after a skip, because film encoders stop at the first gap.
    std::snprintf(name, sizeof name, "frame_%06llu.png", static_cast<unsigned long long>(written_));
    // Writes by the folder's descriptor, because its name may have changed.
    const std::string open_folder = "/proc/self/fd/" + std::to_string(folder_descriptor_);
    if (!WriteBytes(open_folder + "/" + name, bytes_, &failure_)) {
      failure_.replace(0, open_folder.size(), folder_.string());
      return;
    }
    ++written_;
  }
}

}  // namespace hpdm
