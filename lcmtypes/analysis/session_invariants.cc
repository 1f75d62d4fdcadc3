#include "lcmtypes/analysis/session_invariants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>

#include "engine/snapshots.h"
#include "lcmtypes/analysis/logged_session.h"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/message_schema.h"

namespace hpdm {
namespace {

// Bound of the guard's clamp and slew, which scale a vector to its limit with a few roundings.
constexpr double kLimitBound = 1 + 1e-12;
constexpr double kStoredBound = 1e-6;  // J
constexpr double kWorkBound = 0.02;    // W
constexpr double kWorkWindow = 1;      // s, at least
constexpr double kRestBound = 1e-6;    // m
// A step is written before its shape. If a tick had to use the step first, it is written up to a
// second later.
constexpr std::size_t kMaxPendingSteps = 1024;

constexpr double kNotEqual = std::numeric_limits<double>::quiet_NaN();

/// Accumulates the values of one invariant.
class Judge {
 public:
  Judge(const char* name, const char* what, const char* unit, double bound)
      : invariant_{.name = name, .what = what, .unit = unit, .bound = bound} {}

  /// Adds a value; `time`: s, session time.
  void Add(double value, double time) {
    if (invariant_.checked++ == 0 || !(value <= invariant_.worst)) invariant_.worst = value;
    if (value <= invariant_.bound) return;
    if (invariant_.broken++ == 0) invariant_.first = time;
  }

  const Invariant& invariant() const { return invariant_; }

 private:
  Invariant invariant_;
};

class TickJudges {
 public:
  TickJudges(const SessionLimits& limits, Nanoseconds period) : limits_(limits), period_(period) {}

  void Add(const LoggedTick& tick) {
    const HapticSample& sample = tick.sample;
    const double now = ToSeconds(sample.time_ns);
    ticks_.Add(static_cast<double>(tick.lost_before) + (tick.has_output ? 0 : 1), now);
    follows_ = follows_ && tick.lost_before == 0;
    if (tick.has_output) {
      for (int i = 0; i < sample.tool_count; ++i) {
        AddForce(static_cast<std::size_t>(i), sample.tools[i], now);
      }
      if (limits_.still) AddWork(sample, now);
      if (period_ > 0) AddRepeat(sample, now);
    }
    follows_ = tick.has_output;
  }

  void AddTo(std::vector<Invariant>* invariants) const {
    for (const Judge* judge : {&ticks_, &force_, &slew_}) invariants->push_back(judge->invariant());
    if (limits_.still) invariants->push_back(work_.invariant());
    if (period_ > 0) invariants->push_back(repeats_.invariant());
  }

 private:
  /// A tick of the second period, which the later ones repeat.
  struct Phase {
    Nanoseconds time = 0;  // since the period's start
    std::array<JointVector, kMaxInstruments> joints;
    std::array<Vector3d, kMaxInstruments> force_W;
  };

  void AddForce(std::size_t i, const ToolSample& tool, double now) {
    if (i >= limits_.tools.size()) return;
    const SessionLimits::Tool& limit = limits_.tools[i];
    force_.Add(tool.force_W.norm() / limit.max_force, now);
    if (follows_ && (tool.guard_flags & kGuardDisabled) == 0) {
      slew_.Add((tool.force_W - last_force_W_[i]).norm() / limit.slew, now);
    }
    last_force_W_[i] = tool.force_W;
  }

  void AddWork(const HapticSample& sample, double now) {
    double energy = 0;
    bool free = true;
    for (int i = 0; i < sample.tool_count; ++i) {
      const ToolSample& tool = sample.tools[i];
      energy += tool.energy;
      free = free && tool.kind == ContactKind::kNone;
      // The guard was off, so the observer starts over.
      if ((tool.guard_flags & kGuardDisabled) != 0) free_since_.reset();
    }
    if (!free) return;
    if (!free_since_) {
      free_since_ = {now, energy};
    } else if (now - free_since_->first >= kWorkWindow) {
      work_.Add((free_since_->second - energy) / (now - free_since_->first), now);
      free_since_ = {now, energy};
    }
  }

  void AddRepeat(const HapticSample& sample, double now) {
    const Nanoseconds number = sample.time_ns / period_, phase = sample.time_ns % period_;
    if (number < 1) return;
    if (number == 1) {
      Phase& added = pattern_.emplace_back();
      added.time = phase;
      for (int i = 0; i < sample.tool_count; ++i) {
        added.joints[i] = sample.tools[i].joints;
        added.force_W[i] = sample.tools[i].force_W;
      }
      return;
    }
    const auto before = [](const Phase& a, Nanoseconds time) { return a.time < time; };
    const auto at = std::lower_bound(pattern_.begin(), pattern_.end(), phase, before);
    if (at == pattern_.end() || at->time != phase) return repeats_.Add(kNotEqual, now);
    double difference = 0;
    for (int i = 0; i < sample.tool_count; ++i) {
      const ToolSample& tool = sample.tools[i];
      if (tool.joints != at->joints[i]) return repeats_.Add(kNotEqual, now);
      if (tool.force_W == at->force_W[i]) continue;
      difference = std::max(difference, (tool.force_W - at->force_W[i]).norm());
    }
    repeats_.Add(difference, now);
  }

  const SessionLimits& limits_;
  Nanoseconds period_;
  bool follows_ = false;  // the previous tick and its output are known
  std::array<Vector3d, kMaxInstruments> last_force_W_;
  std::optional<std::pair<double, double>> free_since_;  // s, and energy (J) put in until then
  std::vector<Phase> pattern_;                           // by time
  Judge ticks_{"ticks", "periods neither in the log nor skipped with a cause, at a tick", "", 0};
  Judge force_{"force", "force on a hand over its limit", "", kLimitBound};
  Judge slew_{"slew", "change of a force in a tick over its limit", "", kLimitBound};
  Judge work_{"work", "mean power given to the hands between two contact-free moments", "W",
              kWorkBound};
  Judge repeats_{"repeats", "difference from the force in the second period", "N", 0};
};

// Returns the largest displacement of a shape from rest, m.
double Difference(const OrganSnapshot& shape, const Points& rest) {
  if (shape.control_displacements.rows() != rest.rows()) return kNotEqual;
  double difference = 0;
  const auto add = [&difference](const Points& rows) {
    if (rows.rows() > 0) difference = std::max(difference, rows.rowwise().norm().maxCoeff());
  };
  add(shape.control_displacements - rest);
  add(shape.local_displacements);
  for (int i = 0; i < shape.indentation_count; ++i) {
    const IndentationSnapshot& indentation = shape.indentations[i];
    difference = std::max(difference, indentation.amplitude_W.norm() / indentation.radius);
  }
  return difference;
}

class StepJudges {
 public:
  explicit StepJudges(const SessionLimits& limits) : limits_(limits) {}

  void Add(const StepSample& sample, std::int64_t visible_tick) {
    const StepRecord& step = sample.step;
    const auto input = static_cast<std::int64_t>(step.input_tick);
    bool in_order = step.number == last_step_ + 1 && input >= last_input_;
    if (visible_tick != kNeverVisible) {
      in_order = in_order && visible_tick > last_visible_ && visible_tick >= input;
      last_visible_ = visible_tick;
    }
    steps_.Add(in_order ? 0 : 1, ToSeconds(step.time_ns));
    last_input_ = input;
    AddStored(sample);
    NoteTouches(sample, step.number == last_step_ + 1);
    last_step_ = step.number;
  }

  void Add(std::uint64_t step, std::size_t organ, OrganSnapshot shape) {
    if (organ >= limits_.settles.size() || !limits_.settles[organ]) return;
    const auto at = std::find_if(judged_.begin(), judged_.end(),
                                 [&](const Touches& touches) { return touches.step == step; });
    if (at != judged_.end()) return AddRest(*at, organ, shape);
    waiting_.push_back({step, organ, std::move(shape)});
    if (waiting_.size() > kMaxPendingSteps) waiting_.pop_front();
  }

  void AddTo(std::vector<Invariant>* invariants) const {
    for (const Judge* judge : {&steps_, &stored_, &rest_}) {
      invariants->push_back(judge->invariant());
    }
  }

 private:
  /// A step, and the last time a tool was on each organ before it.
  struct Touches {
    std::uint64_t step = 0;
    double time = 0;  // s
    std::array<std::optional<double>, kMaxOrgans> last;
  };
  struct Waiting {
    std::uint64_t step;
    std::size_t organ;
    OrganSnapshot shape;
  };

  void AddStored(const StepSample& sample) {
    double stored = 0;
    bool has_lattice = false;
    for (int t = 0; t < sample.tool_count; ++t) {
      const SolvedContact& contact = sample.contacts[t];
      if (contact.organ < 0 || contact.reaction != ReactionType::kLattice) continue;
      has_lattice = true;
      stored += contact.force_on_tissue_W.dot(contact.contact_W - contact.p_original_W) / 2;
    }
    if (has_lattice) stored_.Add(0 - stored, ToSeconds(sample.step.time_ns));
  }

  void NoteTouches(const StepSample& sample, bool follows) {
    Touches now = judged_.empty() ? Touches() : judged_.back();
    now.step = sample.step.number;
    now.time = ToSeconds(sample.step.time_ns);
    if (!follows) now.last.fill(now.time);  // no earlier time is known
    for (int t = 0; t < sample.tool_count; ++t) {
      const SolvedContact& contact = sample.contacts[t];
      const bool known = contact.organ >= 0 && contact.organ < kMaxOrgans;
      const bool tip =
          known && (contact.kind == ContactKind::kGrasp || !contact.force_on_tissue_W.isZero(0));
      if (tip) now.last[static_cast<std::size_t>(contact.organ)] = now.time;
      if (contact.shaft_contact) now.last.fill(now.time);  // a shaft may touch any of them
    }
    judged_.push_back(now);
    if (judged_.size() > kMaxPendingSteps) judged_.pop_front();
    for (const Waiting& waiting : waiting_) {
      if (waiting.step == now.step) AddRest(now, waiting.organ, waiting.shape);
    }
    std::erase_if(waiting_, [&](const Waiting& waiting) { return waiting.step <= now.step; });
  }

  void AddRest(const Touches& touches, std::size_t organ, const OrganSnapshot& shape) {
    const std::optional<double> last = touches.last[organ];
    if (!last && !rest_shapes_[organ]) rest_shapes_[organ] = shape.control_displacements;
    if (!last || !rest_shapes_[organ]) return;
    if (touches.time <= *last || touches.time - *last < *limits_.settles[organ]) return;
    rest_.Add(Difference(shape, *rest_shapes_[organ]), touches.time);
  }

  const SessionLimits& limits_;
  std::uint64_t last_step_ = 0;
  std::int64_t last_input_ = -1, last_visible_ = -1;
  std::deque<Touches> judged_;
  std::deque<Waiting> waiting_;
  std::array<std::optional<Points>, kMaxOrgans> rest_shapes_;  // control displacements
  Judge steps_{"steps", "steps missing, or whose input or first use goes back in time", "", 0};
  Judge stored_{"stored", "energy that the lattice has given out", "J", kStoredBound};
  Judge rest_{"rest", "distance of an untouched organ from where it was before any touch", "m",
              kRestBound};
};

/// Counts the numbers of a message that are not finite.
class NotFinite : public MessageVisitor {
 public:
  void Value(const MessageValue& value) override {
    const double* number = std::get_if<double>(&value.value);
    if (number != nullptr && !std::isfinite(*number)) ++count;
  }
  int count = 0;
};

}  // namespace

std::vector<Invariant> CheckInvariants(const std::string& log, const SessionLimits& limits,
                                       Nanoseconds period) {
  const MessageSchemas& schemas = MessageSchemas::Hpdm();
  Judge finite("finite", "numbers in a message that are not finite", "", 0);
  TickJudges ticks(limits, period);
  StepJudges steps(limits);
  contact_t contact;
  organ_t organ;
  std::optional<double> begin;  // s since 1970
  const auto visit = [&](const LogEvent& event) {
    const LcmStruct* type = schemas.Find(event.data);
    if (type == nullptr) return;
    const double time = static_cast<double>(event.time_us) / 1e6;
    if (!begin) begin = time;
    NotFinite numbers;
    if (schemas.Decode(*type, event.data, &numbers)) {
      finite.Add(numbers.count, time - *begin);
    }
    if (event.channel == kContactChannel && DecodeMessage(event.data, &contact)) {
      StepSample sample;
      std::int64_t visible_tick = kNeverVisible;
      if (FromMessage(contact, &sample, &visible_tick)) steps.Add(sample, visible_tick);
    } else if (event.channel == kOrganChannel && DecodeMessage(event.data, &organ)) {
      OrganSnapshot shape;
      if (!FromMessage(organ, &shape)) return;
      steps.Add(static_cast<std::uint64_t>(organ.step), static_cast<std::size_t>(organ.organ),
                std::move(shape));
    }
  };
  TickReader reader(log, visit);
  for (LoggedTick tick; reader.Next(&tick);) ticks.Add(tick);

  std::vector<Invariant> invariants = {finite.invariant()};
  ticks.AddTo(&invariants);
  steps.AddTo(&invariants);
  return invariants;
}

}  // namespace hpdm
