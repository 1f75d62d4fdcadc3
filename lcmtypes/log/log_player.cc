#include "lcmtypes/log/log_player.h"

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

namespace hpdm {
namespace {

constexpr std::uint64_t kMarkBytes = 256 << 10;
// A reader later than this has slowed the playback.
constexpr double kSlipNs = 200e6;

/// Returns the time between two time stamps; 0 if the clock was set back.
std::int64_t Step(std::int64_t from_us, std::int64_t to_us) {
  if (to_us <= from_us) return 0;
  const std::uint64_t step =
      static_cast<std::uint64_t>(to_us) - static_cast<std::uint64_t>(from_us);
  return step > std::uint64_t{PlayTime::kMaxSilenceUs} ? 0 : static_cast<std::int64_t>(step);
}

PlayClock MachineClock() {
  return {[] {
            return std::chrono::duration_cast<std::chrono::nanoseconds>(
                       std::chrono::steady_clock::now().time_since_epoch())
                .count();
          },
          [](Nanoseconds duration) {
            std::this_thread::sleep_for(std::chrono::nanoseconds(duration));
          }};
}

}  // namespace

std::int64_t PlayTime::Advance(std::int64_t time_us, const std::int64_t* next_us) {
  if (!started_) last_us_ = time_us;
  started_ = true;
  std::int64_t mended = time_us;
  if (next_us != nullptr && *next_us >= last_us_) {
    mended = std::clamp(time_us, last_us_, *next_us);
  }
  // Otherwise the clock was set back, at this event or at the one after it.
  played_us_ += Step(last_us_, mended);
  last_us_ = mended;
  return played_us_;
}

LogPlayer::LogPlayer(const std::string& path, const std::vector<std::string>& indexed,
                     PlayClock clock)
    : reader_(path), clock_(clock.now ? std::move(clock) : MachineClock()) {
  BuildIndex(indexed);
  GoTo(marks_.front());
  StartClockAt(0);
}

void LogPlayer::BuildIndex(const std::vector<std::string>& indexed) {
  for (const std::string& channel : indexed) indexed_[channel];
  marks_.push_back({0, 0, {}});
  GoTo(marks_.front());
  while (has_next_) {
    ++events_;
    length_us_ = next_us_;
    const auto found = indexed_.find(next_.channel);
    if (found != indexed_.end() && found->second.size() < kMaxIndexed) {
      found->second.push_back(next_offset_);
    }
    if (has_after_ && after_offset_ - marks_.back().offset >= kMarkBytes) {
      marks_.push_back({after_offset_, next_us_, time_});
    }
    Advance();
  }
  damaged_stretches_ = reader_.damaged_stretches();
  damaged_bytes_ = reader_.damaged_bytes();
}

bool LogPlayer::Read(LogEvent* event, std::uint64_t* offset) {
  if (!reader_.Next(event)) return false;
  *offset = reader_.event_start();
  return true;
}

void LogPlayer::GoTo(const Mark& mark) {
  reader_.Seek(mark.offset);
  time_ = mark.time;
  has_after_ = Read(&after_, &after_offset_);
  Advance();
}

void LogPlayer::Advance() {
  std::swap(next_, after_);
  has_next_ = has_after_;
  next_offset_ = after_offset_;
  has_after_ = has_next_ && Read(&after_, &after_offset_);
  if (has_next_) next_us_ = time_.Advance(next_.time_us, has_after_ ? &after_.time_us : nullptr);
}

/// Returns the nanoseconds until the next event is due; negative if it is overdue.
double LogPlayer::DueIn() const {
  if (next_us_ <= clock_position_us_) return 0;  // includes events before the target of a seek
  if (paused_) return std::numeric_limits<double>::infinity();
  if (speed_ == kUnlimited) return 0;
  return 1000 * static_cast<double>(next_us_ - clock_position_us_) / speed_ -
         static_cast<double>(clock_.now() - clock_start_);
}

bool LogPlayer::Next(LogEvent* event, std::chrono::milliseconds patience) {
  if (!has_next_) return false;
  const double due_in = DueIn();
  if (due_in > 0) {
    const auto most = static_cast<double>(std::chrono::nanoseconds(patience).count());
    if (most > 0) clock_.sleep(static_cast<Nanoseconds>(std::min(most, due_in)));
    if (due_in > most) return false;
  }
  if (due_in < -kSlipNs) StartClockAt(next_us_);
  if (speed_ == kUnlimited) clock_position_us_ = std::max(clock_position_us_, next_us_);
  std::swap(*event, next_);
  event_us_ = next_us_;
  Advance();
  return true;
}

std::int64_t LogPlayer::position_us() const {
  if (!has_next_) return length_us_;
  if (paused_ || speed_ == kUnlimited) return clock_position_us_;
  const double elapsed_us = 1e-3 * speed_ * static_cast<double>(clock_.now() - clock_start_);
  // The position stops at the next event until that event is read.
  const std::int64_t room = std::max<std::int64_t>(next_us_ - clock_position_us_, 0);
  return clock_position_us_ +
         static_cast<std::int64_t>(std::min(elapsed_us, static_cast<double>(room)));
}

void LogPlayer::StartClockAt(std::int64_t position_us) {
  clock_position_us_ = position_us;
  clock_start_ = clock_.now();
}

void LogPlayer::SetSpeed(double speed) {
  StartClockAt(position_us());
  speed_ = speed == kUnlimited ? speed : std::clamp(speed, kSlowest, kFastest);
}

void LogPlayer::Pause(bool paused) {
  StartClockAt(position_us());
  paused_ = paused;
}

void LogPlayer::Seek(std::int64_t position_us, std::int64_t lead_in_us) {
  const std::int64_t to = std::clamp<std::int64_t>(position_us, 0, length_us_);
  const std::int64_t from = to > lead_in_us ? to - lead_in_us : 0;
  const auto after = std::partition_point(
      marks_.begin(), marks_.end(), [from](const Mark& mark) { return mark.played_us < from; });
  GoTo(after == marks_.begin() ? *after : *(after - 1));
  while (has_next_ && next_us_ < from) Advance();
  StartClockAt(to);
}

void LogPlayer::ForEachBefore(const std::string& channel,
                              const std::function<void(const LogEvent&)>& visit) {
  const auto found = indexed_.find(channel);
  if (found != indexed_.end()) Visit(Before(found->second), visit);
}

void LogPlayer::ForNewestBefore(const std::function<void(const LogEvent&)>& visit) {
  for (const auto& [channel, offsets] : indexed_) {
    const std::span<const std::uint64_t> before = Before(offsets);
    Visit(before.last(std::min<std::size_t>(before.size(), 1)), visit);
  }
}

/// Returns the offsets before the next event's.
std::span<const std::uint64_t> LogPlayer::Before(const std::vector<std::uint64_t>& offsets) const {
  const std::uint64_t end = has_next_ ? next_offset_ : reader_.size();
  return {offsets.begin(), std::lower_bound(offsets.begin(), offsets.end(), end)};
}

void LogPlayer::Visit(std::span<const std::uint64_t> offsets,
                      const std::function<void(const LogEvent&)>& visit) {
  const std::uint64_t position = reader_.position();
  LogEvent event;
  for (const std::uint64_t offset : offsets) {
    reader_.Seek(offset);
    if (reader_.Next(&event)) visit(event);
  }
  reader_.Seek(position);
}

}  // namespace hpdm
