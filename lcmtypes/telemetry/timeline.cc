#include "lcmtypes/telemetry/timeline.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "engine/base/error.h"

namespace hpdm {
namespace {

/// A line of text on the stack: 18 numbers of at most 16 characters and their commas fit.
class Row {
 public:
  explicit Row(double first) { Append(first); }
  void Add(double value) {
    *end_++ = ',';
    Append(value);
  }
  void Add(const Vector3d& v) {
    for (int k = 0; k < 3; ++k) Add(v[k]);
  }
  bool WriteTo(std::FILE* file) {
    *end_++ = '\n';
    const auto size = static_cast<std::size_t>(end_ - text_.data());
    return std::fwrite(text_.data(), 1, size, file) == size;
  }

 private:
  void Append(double value) {
    constexpr int kDigits = 9;
    end_ = std::to_chars(end_, text_.data() + text_.size() - 1, value, std::chars_format::general,
                         kDigits)
               .ptr;
  }
  std::array<char, 512> text_;
  char* end_ = text_.data();
};

}  // namespace

Timeline::Timeline(const std::string& path, Nanoseconds interval,
                   std::span<const std::string> instruments)
    : file_(std::fopen(path.c_str(), "w")),
      interval_(interval),
      tool_count_(std::min<int>(static_cast<int>(instruments.size()), kMaxInstruments)) {
  if (!file_) {
    throw InputError(path + ": cannot create the time line (" + std::strerror(errno) +
                     "): choose a folder that exists and can be written");
  }
  std::string header = "t";
  for (int i = 0; i < tool_count_; ++i) {
    std::string name = instruments[i];
    std::replace_if(
        name.begin(), name.end(), [](char c) { return std::strchr(",\"\r\n", c) != nullptr; }, '_');
    for (const char* column :
         {"_force", "_fx", "_fy", "_fz", "_depth", "_x", "_y", "_z", "_contact"}) {
      header += "," + name + column;
    }
  }
  header += '\n';
  Check(std::fputs(header.c_str(), file_.get()) >= 0);
}

void Timeline::Add(const HapticSample& sample) noexcept {
  if (failed_ || !file_ || sample.time_ns < next_) return;
  next_ = (sample.time_ns / interval_ + 1) * interval_;
  Row row(ToSeconds(sample.time_ns));
  for (int i = 0; i < tool_count_; ++i) {
    const ToolSample& tool = sample.tools[i];
    row.Add(tool.force_W.norm());
    row.Add(tool.force_W);
    row.Add(tool.depth);
    row.Add(tool.p_tip_W);
    row.Add(tool.kind == ContactKind::kNone ? 0 : 1);
  }
  Check(row.WriteTo(file_.get()));
}

void Timeline::Flush() noexcept {
  if (file_ && !failed_) Check(std::fflush(file_.get()) == 0);
}

void Timeline::Close() noexcept {
  Flush();
  file_.reset();
}

void Timeline::Check(bool written) noexcept {
  if (written || failed_) return;
  failed_ = true;
  error_ = errno;
}

std::string Timeline::Explain() const {
  if (!failed_) return "";
  return std::string("the time line cannot be written (") + std::strerror(error_) +
         "), its end is missing; free space or choose another --out";
}

}  // namespace hpdm
