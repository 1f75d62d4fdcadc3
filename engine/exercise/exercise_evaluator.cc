#include "engine/exercise/exercise_evaluator.h"

#include <algorithm>
#include <utility>

#include "engine/exercise/step_queries.h"

namespace hpdm {

ExerciseEvaluator::ExerciseEvaluator(ExerciseOptions options)
    : options_(std::move(options)),
      watches_(options_.errors.size()),
      judge_(options_.ducts, options_.clips_that_stay),
      torn_(options_.errors.size(), 0),
      bleedings_counted_(options_.errors.size()),
      perforations_judged_(options_.errors.size(), 0),
      stretched_(options_.errors.size()),
      kept_(options_.steps.size()) {}

void ExerciseEvaluator::Add(const StepSample& sample) {
  if (result_.ended) return;
  if (sample.step.restarted_step >= 0) Restart(sample.step.restarted_step, sample.step.time_ns);
  if (sample.step.kept_step >= 0) Keep(sample.step.kept_step);
  if (!begun_) {
    std::ranges::transform(sample.ducts, first_lengths_.begin(), &DuctOutcome::length);
  }
  const double dt = AdvanceTime(sample.step);
  for (std::size_t t = 0; t < instruments_.size(); ++t) {
    instruments_[t] = sample.tools[t].instrument_index;
  }
  jaw_closings_.Follow(sample.tools, sample.tool_count);
  AdvanceBleedings(sample);
  FindErrors(sample, dt);
  for (int t = 0; t < sample.tool_count; ++t) JudgeAction(sample, t);
  AdvanceStep(sample);
  last_contacts_ = sample.contacts;
  if (result_.time >= options_.time_limit) {
    result_.time = options_.time_limit;
    result_.ended = true;
  }
  result_.score = Score();
}

void ExerciseEvaluator::Keep(int step) {
  if (ToSize(step) >= kept_.size()) return;
  auto kept = std::exchange(kept_, {});
  kept[ToSize(step)] = std::make_shared<const ExerciseEvaluator>(*this);
  kept_ = std::move(kept);
}

void ExerciseEvaluator::Restart(int step, Nanoseconds now_ns) {
  if (ToSize(step) >= kept_.size() || kept_[ToSize(step)] == nullptr) return;
  std::vector<ExerciseRestart> restarts = std::move(result_.restarts);
  const ExerciseResult& then = kept_[ToSize(step)]->result_;
  restarts.push_back({.step = step,
                      .time = then.time,
                      .discarded = result_.time - then.time,
                      .errors = static_cast<int>(result_.errors.size() - then.errors.size())});
  const std::size_t begun = ToSize(bleedings_forgotten_) + bleedings_ns_.size();
  auto kept = std::move(kept_);
  const JawClosings jaws = jaw_closings_;
  *this = *kept[ToSize(step)];
  kept_ = std::move(kept);
  jaw_closings_ = jaws;  // the hands continue, as in DeformationLoop::ReturnTo
  result_.restarts = std::move(restarts);
  // All hands have let go.
  last_contacts_.fill({});
  for (auto& of_hands : watches_) of_hands.fill({});
  ForgetOpenBleedings();
  bleedings_forgotten_ = static_cast<int>(begun - bleedings_ns_.size());
  // The exercise's time continues where it was then.
  start_ns_ += now_ns - last_ns_;
  last_ns_ = now_ns;
}

// Returns the exercise's time since the last step, s.
double ExerciseEvaluator::AdvanceTime(const StepRecord& step) {
  if (!begun_) start_ns_ = last_ns_ = step.time_ns;
  begun_ = true;
  const Nanoseconds passed_ns = step.time_ns - last_ns_;
  last_ns_ = step.time_ns;
  const bool stands = step.time_ns - step.device_time_ns > kStandsAfter;
  if (stands) stood_ns_ += passed_ns;
  result_.stood = ToSeconds(stood_ns_);
  result_.time = ToSeconds(step.time_ns - start_ns_ - stood_ns_);
  return stands ? 0 : ToSeconds(passed_ns);
}

void ExerciseEvaluator::AdvanceStep(const StepSample& sample) {
  const std::size_t at = result_.step_times.size();
  if (at >= options_.steps.size()) return;
  const ExerciseStepOptions& step = options_.steps[at];
  const bool holds = Holds(step, sample);
  // The first step in which the conditions hold begins the time.
  if (!holds) {
    holding_ = false;
  } else if (!holding_) {
    holding_ = true;
    held_ = result_.time;
  }
  const double lasted = holding_ ? result_.time - held_ : 0;
  progress_ = step.time > 0 ? std::min(1.0, lasted / step.time) : 0;
  if (!holds || step.lift > 0) progress_ = ProgressOf(step, sample);
  if (!holds || lasted < step.time) return;
  result_.step_times.push_back(result_.time);
  holding_ = false;
  progress_ = 0;
  result_.passed = result_.ended = result_.step_times.size() == options_.steps.size();
}

// Returns how far a step is by what it asks for, without the time for which it must hold.
double ExerciseEvaluator::ProgressOf(const ExerciseStepOptions& step,
                                     const StepSample& sample) const {
  if (!step.frees.empty()) {
    return std::clamp(FreedArea(sample, step.frees) / step.freed_area, 0.0, 1.0);
  }
  if (step.holds && step.lift > 0) {
    double most = 0;  // m
    for (int t = 0; t < sample.tool_count; ++t) {
      const int held = sample.tools[static_cast<std::size_t>(t)].instrument_index;
      VisitContacts(sample, t, [&](const SolvedContact& contact) {
        if (IsHold(*step.holds, contact, t, held)) most = std::max(most, LiftOf(contact));
      });
    }
    return std::min(1.0, most / step.lift);
  }
  double progress = step.clips.empty() ? 0 : 1;
  for (const int duct : step.clips) {
    progress = std::min(progress, static_cast<double>(judge_.GoodClips(duct)) / step.clip_count);
  }
  return progress;
}

bool ExerciseEvaluator::Holds(const ExerciseStepOptions& step, const StepSample& sample) const {
  bool holds = !step.holds, touches = !step.touches, released = true, gentle = true;
  for (int t = 0; t < sample.tool_count; ++t) {
    const int held = sample.tools[static_cast<std::size_t>(t)].instrument_index;
    VisitContacts(sample, t, [&](const SolvedContact& contact) {
      const double force = contact.force_on_tissue_W.norm();
      gentle = gentle && !(step.force && force > *step.force);
      const bool in_place = !step.at_W || (contact.contact_W - *step.at_W).norm() <= step.within;
      if (contact.kind == ContactKind::kGrasp) {
        released = released && !(step.releases && contact.organ == *step.releases);
        holds = holds || (IsHold(*step.holds, contact, t, held) && LiftOf(contact) >= step.lift &&
                          (step.touches || in_place));
      } else if (step.touches && contact.organ == step.touches->organ && Touches(contact) &&
                 IsOneOf(step.touches->with, t, held)) {
        touches = touches || in_place;
      }
    });
  }
  const bool freed = step.frees.empty() || FreedArea(sample, step.frees) >= step.freed_area;
  const bool clipped = std::ranges::all_of(
      step.clips, [&](int duct) { return judge_.GoodClips(duct) >= step.clip_count; });
  const bool cut = std::ranges::all_of(step.cuts, [&](int duct) { return judge_.IsCutWell(duct); });
  return holds && touches && released && gentle && freed && clipped && cut;
}

// Judges a hand's clip or cut, and keeps it.
void ExerciseEvaluator::JudgeAction(const StepSample& sample, int hand) {
  const DuctAction& action = sample.duct_actions[static_cast<std::size_t>(hand)];
  if (action.kind == DuctActionKind::kNone) return;
  const bool clip = action.kind == DuctActionKind::kClip;
  const bool good = clip && judge_.IsGood(action, ClipAngleOf(options_, action.duct));
  const bool lost = action.kind == DuctActionKind::kLostClip;
  // A clip that falls as its applier presses an organ is one on a wrong organ if a rule names that.
  const auto is_wrong_organ = [&](const ExerciseErrorOptions& error) {
    return lost && error.kind == ExerciseErrorKind::kWrongClip && error.organ >= 0 &&
           Presses(sample, hand, error.organ);
  };
  const bool on_wrong_organ = std::ranges::any_of(options_.errors, is_wrong_organ);
  const DuctJudge earlier = judge_;
  judge_.Keep(action, good);
  for (std::size_t rule = 0; rule < options_.errors.size(); ++rule) {
    const ExerciseErrorOptions& error = options_.errors[rule];
    const bool is_meant = Means(error, action.duct);
    const bool early = static_cast<int>(result_.step_times.size()) <= error.before;
    bool is_error = false;
    switch (error.kind) {
      case ExerciseErrorKind::kBadClip:
        is_error = clip && is_meant && !earlier.IsGood(action, error.limit);
        break;
      case ExerciseErrorKind::kWrongClip:
        is_error = (clip && !is_meant) || is_wrong_organ(error);
        break;
      case ExerciseErrorKind::kLostClip:
        is_error = lost && !on_wrong_organ;
        break;
      case ExerciseErrorKind::kEarlyClip:
        is_error = clip && is_meant && early;
        break;
      case ExerciseErrorKind::kEarlyCut:
        is_error = action.kind == DuctActionKind::kCut && is_meant && early;
        break;
      case ExerciseErrorKind::kBadCut:
        is_error =
            action.kind == DuctActionKind::kCut && is_meant && !judge_.IsCutWell(action.duct);
        break;
      default:
        break;
    }
    if (!is_error) continue;
    ClipFinding finding;
    if (error.kind == ExerciseErrorKind::kBadClip) finding = earlier.Examine(action, error.limit);
    if (error.kind == ExerciseErrorKind::kLostClip) {
      finding.faults = action.duct < 0 ? kClipOnNothing : kClipRefused;
    }
    const SolvedContact& contact = sample.contacts[static_cast<std::size_t>(hand)];
    AddError(rule, hand, contact.organ, action.place_W, contact.force_on_tissue_W.norm(),
             action.duct < std::ssize(options_.ducts) ? action.duct : -1, finding);
  }
}

void ExerciseEvaluator::AddBleeding(Nanoseconds time_ns) {
  if (bleedings_ns_.size() >= kMaxErrors) return;
  bleedings_ns_.push_back(time_ns);
  for (std::vector<bool>& counted : bleedings_counted_) counted.push_back(false);
}

int ExerciseEvaluator::BleedingsOver() const {
  return bleedings_forgotten_ +
         static_cast<int>(std::ranges::count(result_.bleedings, true, &ExerciseBleeding::stopped));
}

void ExerciseEvaluator::ForgetOpenBleedings() {
  for (std::size_t b = bleedings_ns_.size(); b-- > 0;) {
    const bool listed = b < result_.bleedings.size();
    if (listed && result_.bleedings[b].stopped) continue;
    const auto at = static_cast<std::ptrdiff_t>(b);
    bleedings_ns_.erase(bleedings_ns_.begin() + at);
    if (listed) result_.bleedings.erase(result_.bleedings.begin() + at);
    for (std::vector<bool>& counted : bleedings_counted_) counted.erase(counted.begin() + at);
  }
}

// Lists the bleedings that have begun, and lets each clip stop the oldest one.
void ExerciseEvaluator::AdvanceBleedings(const StepSample& sample) {
  std::vector<ExerciseBleeding>& bleedings = result_.bleedings;
  while (bleedings.size() < bleedings_ns_.size() &&
         bleedings_ns_[bleedings.size()] < sample.step.time_ns) {
    // One that begins while the time stands begins at the time that stands.
    const double begin = std::clamp(
        ToSeconds(bleedings_ns_[bleedings.size()] - start_ns_ - stood_ns_), 0.0, result_.time);
    bleedings.push_back({begin, begin});
  }
  for (ExerciseBleeding& bleeding : bleedings) {
    if (!bleeding.stopped) bleeding.end = result_.time;
  }
  for (int t = 0; t < sample.tool_count; ++t) {
    if (sample.duct_actions[static_cast<std::size_t>(t)].kind != DuctActionKind::kClip) continue;
    const auto open = std::ranges::find(bleedings, false, &ExerciseBleeding::stopped);
    if (open != bleedings.end()) open->stopped = true;
  }
}

void ExerciseEvaluator::AddPerforation(Nanoseconds time_ns, int organ) {
  if (perforations_.size() < kMaxErrors) perforations_.push_back({time_ns, organ});
}

bool ExerciseEvaluator::AddError(std::size_t rule, int hand, int organ, const Vector3d& place_W,
                                 double force, int duct, const ClipFinding& clip) {
  if (result_.errors.size() >= kMaxErrors) return false;
  result_.errors.push_back(
      {.rule = static_cast<int>(rule),
       .time = result_.time,
       .step = static_cast<int>(result_.step_times.size()),
       .hand = hand,
       .instrument_index = hand < 0 ? 0 : instruments_[static_cast<std::size_t>(hand)],
       .organ = organ,
       .place_W = place_W,
       .force = force,
       .duct = duct,
       .clip = clip});
  points_ += options_.errors[rule].points;
  return true;
}

bool ExerciseEvaluator::IsHook(const StepSample& sample, int hand) const {
  const int held = sample.tools[static_cast<std::size_t>(hand)].instrument_index;
  return !options_.hooks.empty() && IsOneOf(options_.hooks, hand, held);
}

double ExerciseEvaluator::Score() const {
  const double done =
      static_cast<double>(result_.step_times.size()) / static_cast<double>(options_.steps.size());
  double score = kStepPoints * done - points_;
  if (result_.passed) {
    const double late = result_.time - options_.target_time;
    const double most = options_.time_limit - options_.target_time;
    score += kTimePoints * (1 - std::clamp(late / most, 0.0, 1.0));
  }
  return std::max(0.0, score);
}

ExerciseProgress ExerciseEvaluator::Progress() const {
  return {.step = static_cast<int>(result_.step_times.size()),
          .restarts = static_cast<int>(result_.restarts.size())};
}

ExerciseStatus ExerciseEvaluator::Status() const {
  ExerciseStatus status;
  status.present = true;
  status.step = static_cast<int>(result_.step_times.size());
  status.progress = progress_;
  status.time = result_.time;
  status.time_left = options_.time_limit - result_.time;
  status.errors = static_cast<int>(result_.errors.size());
  if (!result_.errors.empty()) {
    status.last_error = result_.errors.back().rule;
    status.last_error_time = result_.errors.back().time;
    status.last_error_force = result_.errors.back().force;
    status.last_error_clip = result_.errors.back().clip;
    status.last_error_duct = result_.errors.back().duct;
  }
  for (const ExerciseError& error : result_.errors) {
    if (ToSize(error.rule) < kShownRules) ++status.error_counts[ToSize(error.rule)];
  }
  for (std::size_t s = 0; s < std::min(kShownSteps, result_.step_times.size()); ++s) {
    status.step_times[s] = static_cast<float>(result_.step_times[s]);
  }
  status.score = result_.score;
  status.ended = result_.ended;
  status.passed = result_.passed;
  status.restarts = static_cast<int>(result_.restarts.size());
  if (!result_.restarts.empty()) status.restarted = result_.restarts.back().time;
  return status;
}

}  // namespace hpdm
