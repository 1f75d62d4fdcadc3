#include "lcmtypes/analysis/logged_session.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "engine/base/error.h"
#include "lcmtypes/wire/mesh_codec.h"

namespace hpdm {
namespace {

constexpr double kSamePlace = 1e-6;  // m

template <typename Range>
bool SameNumbers(const Range& a, const Range& b, double tolerance) {
  return std::equal(std::begin(a), std::end(a), std::begin(b), std::end(b),
                    [&](double x, double y) { return std::abs(x - y) <= tolerance; });
}

bool SamePart(const mesh_t& a, const mesh_t& b) {
  for (int k = 0; k < 3; ++k) {
    if (a.degree[k] != b.degree[k] || a.cells[k] != b.cells[k]) return false;
    if (!SameNumbers(a.axes[k], b.axes[k], kSamePlace)) return false;
  }
  return a.name == b.name && a.part_count == b.part_count && a.total_vertices == b.total_vertices &&
         a.total_triangles == b.total_triangles && a.total_kept == b.total_kept &&
         a.basis == b.basis && a.local_refinement == b.local_refinement &&
         SameNumbers(a.origin, b.origin, kSamePlace) &&
         SameNumbers(a.lengths, b.lengths, kSamePlace) &&
         SameNumbers(a.vertices, b.vertices, kSamePlace) && a.triangles == b.triangles &&
         a.kept == b.kept;
}

}  // namespace

bool TickReader::Next(LoggedTick* tick) {
  while (reader_.Next(&event_)) {
    if (visit_) visit_(event_);
    if (event_.channel == kEventChannel) {
      ReadInterval();
    } else if (event_.channel == kToolChannel) {
      HapticSample sample;
      if (!DecodeMessage(event_.data, &tool_) || !FromMessage(tool_, &sample) ||
          sample.tick < next_tick_) {
        ++unreadable_;
        continue;
      }
      // The sample before has no output. Checks whether its number fits the samples around it.
      const bool fits = waiting_ && (Expected(*waiting_) ||
                                     sample.tick == waiting_->tick + 1 + sample.skipped.Total());
      if (waiting_ && (!fits || sample.tick <= waiting_->tick)) {
        ++unreadable_;
        // An expected number takes precedence over one that contradicts it.
        if (!fits) waiting_ = sample;
        continue;
      }
      const std::optional<HapticSample> before = std::exchange(waiting_, sample);
      if (before) return Finish(*before, false, tick);
    } else if (event_.channel == kForceChannel) {
      if (!waiting_) continue;  // its input is lost
      HapticSample whole;
      if (!DecodeMessage(event_.data, &force_) ||
          force_.tick != static_cast<std::int64_t>(waiting_->tick) ||
          !FromMessage(force_, &(whole = *waiting_))) {
        ++unreadable_;
        continue;
      }
      waiting_.reset();
      return Finish(whole, true, tick);
    }
  }
  if (!waiting_) return false;
  const HapticSample last = *std::exchange(waiting_, std::nullopt);
  if (Expected(last)) return Finish(last, false, tick);
  ++unreadable_;
  return false;
}

void TickReader::ReadInterval() {
  event_t message;
  if (!DecodeMessage(event_.data, &message) || message.name != kLogThinned) return;
  output_interval_ = ThinnedInterval(message.text);
  intervals_ = TickIntervals(output_interval_);
}

bool TickReader::Expected(const HapticSample& sample) const {
  return sample.tick == next_tick_ + sample.skipped.Total();
}

bool TickReader::Finish(const HapticSample& sample, bool has_output, LoggedTick* tick) {
  tick->sample = sample;
  tick->has_output = has_output;
  tick->output_lost = intervals_.Begins(sample.tick) && !has_output;
  const std::uint64_t accounted = next_tick_ + tick->sample.skipped.Total();
  tick->lost_before = tick->sample.tick > accounted ? tick->sample.tick - accounted : 0;
  next_tick_ = tick->sample.tick + 1;
  return true;
}

LoggedSession::LoggedSession(const std::string& path) : path_(path) {
  LogReader reader(path);
  LogEvent event;
  contact_t contact;
  LoggedStep step;
  bool has_ticks = false;
  while (reader.Next(&event)) {
    if (event.channel == kToolChannel) {
      has_ticks = true;
    } else if (event.channel == kContactChannel) {
      if (!DecodeMessage(event.data, &contact) ||
          !FromMessage(contact, &step.sample, &step.visible_tick)) {
        continue;
      }
      if (step.sample.step.number == steps_.size() + 1) {
        steps_.push_back(step);
      } else {
        ++steps_unusable_;
      }
    } else if (event.channel == kMeshChannel) {
      mesh_t part;
      if (DecodeMessage(event.data, &part)) mesh_parts_.push_back(std::move(part));
    } else if (event.channel == kEventChannel) {
      event_t message;
      if (!DecodeMessage(event.data, &message)) continue;
      if (message.name == kSessionStart) start_text_ = message.text;
      if (message.name == "session.end") closed_ = true;
    }
  }
  damaged_stretches_ = reader.damaged_stretches();
  damaged_bytes_ = reader.damaged_bytes();
  if (!has_ticks) {
    throw InputError(path + ": contains no session data; give the session.lcmlog of a session");
  }
}

std::string LoggedSession::WhyAnother(const SessionInfo& info) const {
  if (!start_text_.empty() && start_text_ != SessionStartText(info.instruments)) {
    return "its instruments differ (" + start_text_ + ")";
  }
  std::vector<std::vector<mesh_t>> organs;
  for (std::size_t o = 0; o < info.organs.size(); ++o) {
    organs.push_back(SplitMesh(static_cast<int>(o), info.organs[o]));
  }
  for (const mesh_t& part : mesh_parts_) {
    const auto o = static_cast<std::size_t>(part.organ);
    if (part.organ < 0 || o >= organs.size()) return "it has more organs";
    if (part.part < 0 || static_cast<std::size_t>(part.part) >= organs[o].size() ||
        !SamePart(part, organs[o][static_cast<std::size_t>(part.part)])) {
      return "its organ \"" + part.name + "\" has another mesh or lattice";
    }
  }
  return "";
}

}  // namespace hpdm
