#include "lcmtypes/telemetry/log_writer.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kFlushPeriod = kNanosecondsPerSecond / 10;

}  // namespace

LogWriter::LogWriter(const Options& options, std::span<const std::string> instruments)
    : log_(options.log_path, options.epoch_us) {
  if (options.timeline_path.empty()) return;
  timeline_.emplace(options.timeline_path, options.timeline_interval, instruments);
}

void LogWriter::Add(const HapticSample& sample) noexcept {
  if (timeline_) timeline_->Add(sample);
}

void LogWriter::Flush(Nanoseconds now) noexcept {
  if (now - last_flush_ < kFlushPeriod) return;
  log_.Flush();
  if (timeline_) timeline_->Flush();
  last_flush_ = now;
}

void LogWriter::Close() noexcept {
  if (timeline_) timeline_->Close();
  log_.Close();
}

std::string LogWriter::TimelineFailure() const { return timeline_ ? timeline_->Explain() : ""; }

}  // namespace hpdm
