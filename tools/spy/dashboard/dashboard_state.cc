#include "tools/spy/dashboard/dashboard_state.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "lcmtypes/telemetry/session_info.h"

namespace hpdm {
namespace {

constexpr std::size_t kMaxTextBytes = 500;

template <typename Numbers>
bool AllFinite(const Numbers& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](auto x) { return std::isfinite(x); });
}

template <typename Message>
bool Decode(const LogEvent& event, const char* channel, Message* message) {
  return event.channel == channel && DecodeMessage(event.data, message);
}

// Adds a count. Counts of a damaged message may have any value, so the sum saturates.
void Count(std::int64_t more, std::int64_t* sum) {
  if (__builtin_add_overflow(*sum, more, sum)) {
    using Limits = std::numeric_limits<std::int64_t>;
    *sum = more > 0 ? Limits::max() : Limits::min();
  }
}

bool IsFinite(const indentation_t& indentation) {
  return AllFinite(std::span(indentation.centre)) && AllFinite(std::span(indentation.normal)) &&
         AllFinite(std::span(indentation.amplitude)) && std::isfinite(indentation.resolved_radius);
}

}  // namespace

void DashboardState::Take(const LogEvent& event) {
  newest_us_ = std::max(newest_us_, event.time_us);
  if (!channels_.Add(event)) return;
  force_t force;
  contact_t contact;
  organ_t organ;
  mesh_t mesh;
  stats_t stats;
  event_t happened;
  exercise_t exercise;
  if (Decode(event, kForceChannel, &force)) {
    Take(force);
  } else if (Decode(event, kContactChannel, &contact)) {
    Take(contact);
  } else if (event.data.size() <= kMaxShapeBytes && Decode(event, kOrganChannel, &organ)) {
    Take(std::move(organ));
  } else if (Decode(event, kMeshChannel, &mesh)) {
    Take(std::move(mesh));
  } else if (Decode(event, kStatsChannel, &stats)) {
    Take(stats);
  } else if (Decode(event, kEventChannel, &happened)) {
    Take(happened);
  } else if (Decode(event, kExerciseChannel, &exercise)) {
    Take(exercise);
  }
}

void DashboardState::Take(const force_t& force) {
  HapticSample sample;
  if (!FromMessage(force, &sample)) return;
  const TickOrder::Verdict verdict = order_.Judge(force.time_ns);
  if (verdict == TickOrder::Verdict::kStray) return;
  if (verdict == TickOrder::Verdict::kAhead) {
    ahead_ = force;
    return;
  }
  if (verdict == TickOrder::Verdict::kRestart) Restart();
  // Counts the peak of the tick that jumped ahead, now that another follows it.
  if (ahead_ && ahead_->time_ns <= force.time_ns) trace_.Add(*ahead_);
  ahead_.reset();
  trace_.Add(force);
  force_ = force;
  ++tools_version_;
}

void DashboardState::Take(const contact_t& contact) {
  StepSample sample;
  std::int64_t visible_tick;
  if (!FromMessage(contact, &sample, &visible_tick)) return;
  contact_ = contact;
  ++tools_version_;
}

void DashboardState::Take(organ_t&& shape) {
  OrganSnapshot snapshot;
  if (shape.organ >= kMaxOrgans || !FromMessage(shape, &snapshot)) return;
  if (!AllFinite(shape.displacements) || !AllFinite(shape.local_displacements) ||
      !AllFinite(std::span(shape.offset)) ||
      !std::all_of(shape.indentations.begin(), shape.indentations.end(), IsFinite)) {
    return;
  }
  Organ& organ = organs_[shape.organ];
  organ.shape = std::move(shape);
  organ.shape_version = ++versions_;
}

void DashboardState::Take(mesh_t&& part) {
  if (part.organ < 0 || part.organ >= kMaxOrgans) return;
  std::size_t bytes = 0;
  for (const auto& [number, organ] : organs_) bytes += organ.mesh.bytes();
  if (bytes > kMaxMeshBytes) return;
  Organ& organ = organs_[part.organ];
  if (organ.mesh.Take(std::move(part))) organ.mesh_version = ++versions_;
}

void DashboardState::Take(const stats_t& stats) {
  latencies_.Add(stats);
  const std::array<const loop_stats_t*, 3> loops = {&stats.haptic, &stats.deformation,
                                                    &stats.render};
  for (std::size_t i = 0; i < loops.size(); ++i) Count(loops[i]->missed, &missed_[i]);
  Count(stats.skipped_late_wake_up, &skipped_[0]);
  Count(stats.skipped_long_compute, &skipped_[1]);
  Count(stats.skipped_stalled, &skipped_[2]);
  Count(stats.stolen_ns, &stolen_ns_);
  Count(stats.interval_ns, &counted_ns_);
  stats_ = stats;
  stats_->bins.clear();
  ++health_version_;
}

void DashboardState::Take(const event_t& event) {
  if (event.name == kSessionStart) {
    // If two sessions publish, the dashboard follows the one whose ticks come first.
    order_ = {};
    ahead_.reset();
    Restart();
    organs_.clear();  // the new session's meshes follow
  }
  AddEvent(event);
}

void DashboardState::Take(const exercise_t& exercise) {
  exercise_ = exercise;
  for (std::string* text : {&exercise_->name, &exercise_->instruction, &exercise_->last_error}) {
    text->resize(std::min(text->size(), kMaxTextBytes));
  }
  ++exercise_version_;
}

void DashboardState::AddEvent(const event_t& event) {
  if (event.name == kSessionStart) {
    instruments_ = InstrumentsIn(event.text.substr(0, kMaxTextBytes), kMaxInstruments);
    ++names_version_;
  }
  Happened& happened = events_.emplace_back(Happened{++events_count_, event});
  happened.event.name.resize(std::min(happened.event.name.size(), kMaxTextBytes));
  happened.event.text.resize(std::min(happened.event.text.size(), kMaxTextBytes));
  if (events_.size() > kMaxEvents) events_.pop_front();
}

void DashboardState::Recall(const LogEvent& event) {
  event_t happened;
  mesh_t mesh;
  if (Decode(event, kEventChannel, &happened)) {
    AddEvent(happened);
  } else if (Decode(event, kMeshChannel, &mesh)) {
    Take(std::move(mesh));
  }
}

void DashboardState::Finish() { trace_.Finish(); }

void DashboardState::Interrupt() {
  newest_us_ = 0;
  channels_.Interrupt();
  order_ = {};
  ahead_.reset();
  Restart();
}

void DashboardState::Restart() {
  ++generation_;
  trace_.Clear();
  force_.reset();
  contact_.reset();
  stats_.reset();
  exercise_.reset();
  ++exercise_version_;
  latencies_ = {};
  missed_ = {};
  skipped_ = {};
  stolen_ns_ = counted_ns_ = 0;
  events_.clear();
  for (auto& [number, organ] : organs_) {
    organ.shape.reset();
    organ.shape_version = ++versions_;
  }
  ++tools_version_;
  ++health_version_;
}

}  // namespace hpdm
