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
// The aim is 0.01; a slide under patches that are 34 ms late gives back up to 0.023 (tools/stress/RESULTS.md).
constexpr double kEnergyBound = 0.03;
constexpr double kLeastWork = 1e-4;  // J put into a contact that is judged
constexpr double kReleased = 0.1;    // s after a contact the steps have released the tissue
constexpr double kWorkBound = 0.02;  // W
constexpr double kWorkWindow = 1;    // s, at least
constexpr double kRestBound = 1e-6;  // m
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

/// The energy of free organs over the steps, and how much of it they may have given to hands.
class BodyEnergy {
 public:
  /// A range of it, J. A tick displays a step that is up to kLag old.
  struct Range {
    double least = 0, most = 0;
  };

  void Add(const StepSample& sample) {
    double sum = 0;
    for (int o = 0; o < sample.organ_count; ++o) sum += sample.organs[o].body_energy;
    while (!steps_.empty() && steps_.front().first < sample.step.time_ns - kKept) {
      steps_.pop_front();
    }
    steps_.emplace_back(sample.step.time_ns, sum);
  }
  /// Returns the range of the steps that a tick at `time_ns` may display. Such steps have been added.
  Range At(Nanoseconds time_ns) const {
    std::optional<Range> range;
    for (const auto& [step_ns, energy] : steps_) {
      if (step_ns > time_ns || step_ns < time_ns - kLag) continue;
      if (!range) range = {energy, energy};
      range->least = std::min(range->least, energy);
      range->most = std::max(range->most, energy);
    }
    return range.value_or(Range());
  }

 private:
  static constexpr Nanoseconds kLag = kNanosecondsPerSecond / 10, kKept = 4 * kLag;
  std::deque<std::pair<Nanoseconds, double>> steps_;  // J, by time
};

class TickJudges {
 public:
  TickJudges(const SessionLimits& limits, const BodyEnergy& bodies, Nanoseconds period)
      : limits_(limits), bodies_(bodies), period_(period) {}

  void Add(const LoggedTick& tick) {
    const HapticSample& sample = tick.sample;
    const double now = ToSeconds(sample.time_ns);
    ticks_.Add(static_cast<double>(tick.lost_before) + (tick.output_lost ? 1 : 0), now);
    if (tick.lost_before > 0 || tick.output_lost) ticks_since_output_.reset();
    if (ticks_since_output_) ++*ticks_since_output_;
    if (tick.has_output) {
      for (int i = 0; i < sample.tool_count; ++i) {
        AddForce(static_cast<std::size_t>(i), sample.tools[i], now);
      }
      if (limits_.still) AddEnergy(sample, now);
      if (limits_.still) AddWork(sample, now);
      ticks_since_output_ = 0;
    }
    if (period_ > 0 && !tick.output_lost) AddRepeat(sample, tick.has_output, now);
  }

  void AddTo(std::vector<Invariant>* invariants) const {
    for (const Judge* judge : {&ticks_, &force_, &slew_}) invariants->push_back(judge->invariant());
    if (limits_.still) invariants->push_back(energy_.invariant());
    if (limits_.still) invariants->push_back(work_.invariant());
    if (period_ > 0) invariants->push_back(repeats_.invariant());
  }

 private:
  /// Energy of all hands since all tools were last free for kReleased, J.
  struct ContactWork {
    double last = 0;    // s, of a contact
    double put_in = 0;  // the positive part
    double bodies = 0;  // most energy of free organs before it
    double work = 0;
    bool judged = true;
  };
  /// A tick of the second period, which the later ones repeat.
  struct Phase {
    Nanoseconds time = 0;  // since the period's start
    bool has_forces = false;
    std::array<JointVector, kMaxInstruments> joints;
    std::array<Vector3d, kMaxInstruments> force_W;
  };

  void AddForce(std::size_t i, const ToolSample& tool, double now) {
    if (i >= limits_.tools.size()) return;
    const SessionLimits::Tool& limit = limits_.tools[i];
    force_.Add(tool.force_W.norm() / limit.max_force, now);
    if (ticks_since_output_ && (tool.guard_flags & kGuardDisabled) == 0) {
      slew_.Add((tool.force_W - last_force_W_[i]).norm() / (limit.slew * *ticks_since_output_),
                now);
    }
    last_force_W_[i] = tool.force_W;
  }

  // Sums the work of all hands by the trapezoidal rule, tick by tick.
  void AddEnergy(const HapticSample& sample, double now) {
    const bool follows = ticks_since_output_ == 1;  // the tick before has its output too
    bool free = true;
    const bool restarts = sample.restart.count != std::exchange(restarts_, sample.restart.count);
    contact_.judged =
        contact_.judged && follows && sample.skipped.Total() == 0 && !sample.paused && !restarts;
    for (int i = 0; i < sample.tool_count; ++i) {
      const ToolSample& tool = sample.tools[i];
      const ToolSample& last = last_tools_[i];
      const double work = -0.5 * (last.force_W + tool.force_W).dot(tool.p_tip_W - last.p_tip_W);
      if (follows) contact_.put_in += std::max(work, 0.0);
      if (follows) contact_.work += work;
      contact_.judged = contact_.judged && tool.kind != ContactKind::kGrasp;
      free = free && tool.kind == ContactKind::kNone;
    }
    std::copy_n(sample.tools.begin(), sample.tool_count, last_tools_.begin());
    if (!free) contact_.last = now;
    if (now - contact_.last < kReleased) return;
    const BodyEnergy::Range bodies = bodies_.At(sample.time_ns);
    if (contact_.judged && contact_.put_in >= kLeastWork) {
      const double given = std::max(contact_.bodies - bodies.least, 0.0);
      energy_.Add(0 - (contact_.work + given) / contact_.put_in, now);
    }
    contact_ = {.last = contact_.last, .bodies = bodies.most};
  }

  void AddWork(const HapticSample& sample, double now) {
    double energy = 0;  // put in by the hands
    bool free = true;
    for (int i = 0; i < sample.tool_count; ++i) {
      const ToolSample& tool = sample.tools[i];
      energy += tool.energy;
      free = free && tool.kind == ContactKind::kNone;
      // The guard was off, so the observer starts over.
      if ((tool.guard_flags & kGuardDisabled) != 0) free_since_.reset();
    }
    if (!free) return;
    if (free_since_ && now - free_since_->time < kWorkWindow) return;
    const BodyEnergy::Range bodies = bodies_.At(sample.time_ns);
    if (free_since_) {
      const double given = std::max(free_since_->bodies - bodies.least, 0.0);
      work_.Add((free_since_->put_in - energy - given) / (now - free_since_->time), now);
    }
    free_since_ = {now, energy, bodies.most};
  }

  void AddRepeat(const HapticSample& sample, bool has_forces, double now) {
    const Nanoseconds number = sample.time_ns / period_, phase = sample.time_ns % period_;
    if (number < 1) return;
    if (number == 1) {
      Phase& added = pattern_.emplace_back();
      added.time = phase;
      added.has_forces = has_forces;
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
    if (has_forces && at->has_forces) repeats_.Add(difference, now);
  }

  const SessionLimits& limits_;
  const BodyEnergy& bodies_;
  Nanoseconds period_;
  std::optional<int> ticks_since_output_;  // none if the last output or a tick since is lost
  std::array<Vector3d, kMaxInstruments> last_force_W_;
  std::array<ToolSample, kMaxInstruments> last_tools_;
  int restarts_ = 0;  // requests so far
  ContactWork contact_;
  /// A tick without a contact.
  struct FreeTick {
    double time = 0;    // s
    double put_in = 0;  // J, by the hands until then
    double bodies = 0;  // J: most energy of free organs
  };
  std::optional<FreeTick> free_since_;
  std::vector<Phase> pattern_;  // by time
  Judge ticks_{"ticks", "periods neither in the log nor skipped with a cause, at a tick", "", 0};
  Judge force_{"force", "force on a hand over its limit", "", kLimitBound};
  Judge slew_{"slew",
              "change of a force in a tick, on average since the last output, over its limit", "",
              kLimitBound};
  Judge energy_{"energy", "work got back from a contact beyond that put in, over the latter", "",
                kEnergyBound};
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
    AddDamage(sample);
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
    for (const Judge* judge : {&steps_, &rest_}) {
      invariants->push_back(judge->invariant());
    }
    if (damage_.invariant().checked > 0) invariants->push_back(damage_.invariant());
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

  void AddDamage(const StepSample& sample) {
    for (int a = 0; a < sample.attachment_count; ++a) {
      const AttachmentOutcome& now = sample.attachments[a];
      AttachmentOutcome& last = last_outcomes_[a];
      // The tissue of a restarted exercise is that of an earlier step.
      if (sample.step.restarted_step >= 0) last = {};
      const auto fall = [](double before, double after) {
        return after >= before ? 0 : (before - after) / before;
      };
      damage_.Add(
          std::max({fall(last.largest_damage, now.largest_damage),
                    fall(last.freed_area, now.freed_area), fall(last.dissipated, now.dissipated)}),
          ToSeconds(sample.step.time_ns));
      last = now;
    }
  }

  // The first of the organs that can push `organ`.
  std::size_t FirstPushing(std::size_t organ) const {
    return organ < limits_.pushing.size() ? limits_.pushing[organ] : organ;
  }

  void NoteTouch(int organ, Touches* now) const {
    if (organ < 0 || organ >= kMaxOrgans) return;
    const std::size_t first = FirstPushing(static_cast<std::size_t>(organ));
    for (std::size_t other = 0; other < now->last.size(); ++other) {
      if (FirstPushing(other) == first) now->last[other] = now->time;
    }
  }

  void NoteTouches(const StepSample& sample, bool follows) {
    Touches now = judged_.empty() ? Touches() : judged_.back();
    now.step = sample.step.number;
    now.time = ToSeconds(sample.step.time_ns);
    const bool restarts = sample.step.restarted_step >= 0;
    if (!follows || restarts) now.last.fill(now.time);  // no earlier time is known
    for (int t = 0; t < sample.tool_count; ++t) {
      const SolvedContact& contact = sample.contacts[t];
      if (contact.kind == ContactKind::kGrasp || !contact.force_on_tissue_W.isZero(0)) {
        NoteTouch(contact.organ, &now);
      }
      for (const SolvedContact& beside : sample.beside[t]) {
        if (!beside.force_on_tissue_W.isZero(0)) NoteTouch(beside.organ, &now);
      }
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
  std::array<AttachmentOutcome, kMaxAttachments> last_outcomes_;
  Judge steps_{"steps", "steps missing, or whose input or first use goes back in time", "", 0};
  Judge damage_{"damage", "fall of an attachment's damage, freed area or dissipated energy", "", 0};
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
  BodyEnergy bodies;
  TickJudges ticks(limits, bodies, period);
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
      if (!FromMessage(contact, &sample, &visible_tick)) return;
      steps.Add(sample, visible_tick);
      bodies.Add(sample);
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
