#include "lcmtypes/log/log.h"

#include <fcntl.h>
#include <stdio_ext.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <lcm/lcm-cpp.hpp>

#include "engine/base/error.h"

namespace hpdm {
namespace {

// An event in the file: sync word, event number (8), time stamp (8), channel length (4), data
// length (4), channel, data; big-endian.
constexpr std::array<std::uint8_t, 4> kSync = {0xED, 0xA1, 0xDA, 0x01};
constexpr std::array<std::uint8_t, 4> kZstd = {0x28, 0xB5, 0x2F, 0xFD};  // of zstd's files
constexpr std::uint64_t kHeaderBytes = 28;
constexpr std::uint32_t kMaxChannelBytes = 999;  // as liblcm accepts them

constexpr std::size_t kWriteBufferBytes = 1 << 18;
constexpr std::size_t kReadWindowBytes = 1 << 20;

std::uint32_t Big32(const std::uint8_t* p) {
  return std::uint32_t{p[0]} << 24 | std::uint32_t{p[1]} << 16 | std::uint32_t{p[2]} << 8 | p[3];
}
std::uint64_t Big64(const std::uint8_t* p) { return std::uint64_t{Big32(p)} << 32 | Big32(p + 4); }

}  // namespace

std::string LogState::Explain() const {
  const std::string lost = ", " + std::to_string(dropped) + " events lost; ";
  switch (failure) {
    case LogFailure::kNone:
      return "";
    case LogFailure::kWrite:
      return std::string("the log cannot be written (") + std::strerror(error) + ")" + lost +
             "free space or choose another --out";
    case LogFailure::kVanished:
      return "the log was deleted while it was written" + lost +
             "leave the session folder alone until the session ends";
  }
  return "";
}

SessionLog::SessionLog(const std::string& path, std::int64_t epoch_us)
    : stream_buffer_(kWriteBufferBytes),
      path_(path),
      file_(std::make_unique<lcm::LogFile>(path, "w")),
      epoch_us_(epoch_us),
      last_us_(epoch_us) {
  if (!file_->good()) {
    throw InputError(path + ": cannot create the log (" + std::strerror(errno) +
                     "); choose a folder that exists and can be written");
  }
  std::setvbuf(file_->getFilePtr(), stream_buffer_.data(), _IOFBF, stream_buffer_.size());
}

SessionLog::~SessionLog() { Close(); }

void SessionLog::Write(const char* channel, Nanoseconds time,
                       std::span<const std::uint8_t> data) noexcept {
  last_us_ = std::max(last_us_, epoch_us_ + time / 1000);
  Append(channel, last_us_, data);
}

void SessionLog::Append(const char* channel, std::int64_t time_us,
                        std::span<const std::uint8_t> data) noexcept {
  if (!file_) {
    ++state_.dropped;
    return;
  }
  lcm::LogEvent event;
  event.eventnum = 0;  // the file assigns the number
  event.timestamp = time_us;
  event.channel = channel;  // our names fit into the string's own buffer: no allocation
  event.datalen = static_cast<std::int32_t>(data.size());
  event.data = const_cast<std::uint8_t*>(data.data());  // never written
  ++state_.events;
  state_.bytes += kHeaderBytes + event.channel.size() + data.size();
  if (file_->writeEvent(&event) != 0) Fail(LogFailure::kWrite, errno);
}

void SessionLog::Flush() noexcept {
  if (!file_) return;
  std::FILE* stream = file_->getFilePtr();
  if (std::fflush(stream) != 0) {
    Fail(LogFailure::kWrite, errno);
    return;
  }
  struct stat status;
  if (fstat(fileno(stream), &status) != 0) {
    Fail(LogFailure::kWrite, errno);
    return;
  }
  if (status.st_nlink == 0) {
    Fail(LogFailure::kVanished, ENOENT);
    return;
  }
  flushed_events_ = state_.events;
  flushed_bytes_ = state_.bytes;
  struct stat named;
  state_.moved = stat(path_.c_str(), &named) != 0 || named.st_ino != status.st_ino ||
                 named.st_dev != status.st_dev;
}

void SessionLog::Close() noexcept {
  Flush();
  file_.reset();
}

void SessionLog::Fail(LogFailure failure, int error) noexcept {
  state_.failure = failure;
  state_.error = error;
  state_.dropped += state_.events - flushed_events_;
  state_.events = flushed_events_;
  state_.bytes = flushed_bytes_;
  // Closing the stream would write its remaining bytes. They are discarded, and the torn event that
  // is in the file already is cut off. If that fails, a reader skips the torn tail.
  std::FILE* stream = file_->getFilePtr();
  __fpurge(stream);
  [[maybe_unused]] const int cut = ftruncate(fileno(stream), static_cast<off_t>(flushed_bytes_));
  file_.reset();
}

LogReader::File::File(const std::string& path)
    // Opening a pipe must not block; it is refused below.
    : descriptor_(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  if (descriptor_ < 0) {
    throw InputError(path + ": cannot open the log (" + std::strerror(errno) +
                     "); give the path of a session.lcmlog");
  }
}

LogReader::File::~File() { close(descriptor_); }

LogReader::LogReader(const std::string& path) : file_(path) {
  struct stat status;
  if (fstat(file_.descriptor(), &status) != 0 || !S_ISREG(status.st_mode)) {
    throw InputError(path + ": not a regular file; give the path of a session.lcmlog");
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
  std::array<std::uint8_t, 4> begin = {};
  if (pread(file_.descriptor(), begin.data(), begin.size(), 0) == 4 && begin == kZstd) {
    throw InputError(path + ": is compressed; unpack it with zstd -d and give the session.lcmlog");
  }
}

/// Returns the file's bytes [at, at + bytes), valid until the next call, or null if the file ends
/// before.
const std::uint8_t* LogReader::View(std::uint64_t at, std::uint64_t bytes) {
  if (at > size_ || bytes > size_ - at) return nullptr;
  if (at < window_start_ || at + bytes > window_start_ + window_.size()) {
    const std::uint64_t wanted =
        std::min<std::uint64_t>(std::max<std::uint64_t>(bytes, kReadWindowBytes), size_ - at);
    window_.resize(wanted);
    window_start_ = at;
    std::uint64_t got = 0;
    while (got < wanted) {
      const ssize_t n = pread(file_.descriptor(), window_.data() + got, wanted - got,
                              static_cast<off_t>(at + got));
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) break;  // the file shrank or cannot be read further
      got += static_cast<std::uint64_t>(n);
    }
    window_.resize(got);
    if (got < wanted) size_ = at + got;
    if (got < bytes) return nullptr;
  }
  return window_.data() + (at - window_start_);
}

/// True if a sync word, or the part of one before the end of the file, starts at `at` <= size_.
/// Does not move the window: a wrong length may point far away while reading continues here.
bool LogReader::IsBorder(std::uint64_t at) const {
  std::array<std::uint8_t, kSync.size()> word;
  const std::size_t bytes = std::min<std::uint64_t>(word.size(), size_ - at);
  if (at >= window_start_ && at + bytes <= window_start_ + window_.size()) {
    std::copy_n(window_.begin() + static_cast<std::ptrdiff_t>(at - window_start_), bytes,
                word.begin());
  } else if (pread(file_.descriptor(), word.data(), bytes, static_cast<off_t>(at)) !=
             static_cast<ssize_t>(bytes)) {
    return false;
  }
  return std::equal(word.begin(), word.begin() + bytes, kSync.begin());
}

/// Reads the event that starts at `at`. Returns its size in the file, or 0 if no intact one starts
/// there.
std::uint64_t LogReader::ReadEventAt(std::uint64_t at, LogEvent* event) {
  const std::uint8_t* header = View(at, kHeaderBytes);
  if (header == nullptr || !std::equal(kSync.begin(), kSync.end(), header)) return 0;
  const std::uint32_t channel_bytes = Big32(header + 20);
  const std::uint32_t data_bytes = Big32(header + 24);
  event->number = static_cast<std::int64_t>(Big64(header + 4));
  event->time_us = static_cast<std::int64_t>(Big64(header + 12));
  if (channel_bytes == 0 || channel_bytes > kMaxChannelBytes || data_bytes > INT32_MAX) return 0;

  const std::uint64_t bytes = kHeaderBytes + channel_bytes + data_bytes;
  if (bytes > size_ - at) return 0;
  // The bytes after the event reveal a wrong length before its data is read.
  if (!IsBorder(at + bytes)) return 0;

  const std::uint8_t* body = View(at + kHeaderBytes, bytes - kHeaderBytes);
  if (body == nullptr || std::find(body, body + channel_bytes, 0) != body + channel_bytes) return 0;
  event->channel.assign(reinterpret_cast<const char*>(body), channel_bytes);
  event->data.assign(body + channel_bytes, body + channel_bytes + data_bytes);
  return bytes;
}

/// Returns the position of the next sync word at or after `from`, or the file's size if there is
/// none.
std::uint64_t LogReader::FindSync(std::uint64_t from) {
  while (from + kSync.size() <= size_) {
    const std::uint64_t window_end = window_start_ + window_.size();
    const bool in_window = from >= window_start_ && from + kSync.size() <= window_end;
    const std::uint64_t bytes =
        std::min<std::uint64_t>(in_window ? window_end - from : kReadWindowBytes, size_ - from);
    const std::uint8_t* begin = View(from, bytes);
    if (begin == nullptr) break;
    const std::uint8_t* found = std::search(begin, begin + bytes, kSync.begin(), kSync.end());
    if (found != begin + bytes) return from + static_cast<std::uint64_t>(found - begin);
    from += bytes - (kSync.size() - 1);  // a word may straddle two windows
  }
  return size_;
}

bool LogReader::Next(LogEvent* event) {
  const std::uint64_t start = position_;
  while (position_ < size_) {
    if (const std::uint64_t bytes = ReadEventAt(position_, event)) {
      if (position_ > start) {
        ++damaged_stretches_;
        damaged_bytes_ += position_ - start;
      }
      event_start_ = position_;
      position_ += bytes;
      intact_end_ = position_;
      return true;
    }
    position_ = FindSync(position_ + 1);
  }
  if (size_ > start) {
    ++damaged_stretches_;
    damaged_bytes_ += size_ - start;
  }
  position_ = std::max(position_, size_);
  return false;
}

}  // namespace hpdm
