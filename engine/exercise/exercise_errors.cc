// The errors that a step shows: the part of ExerciseEvaluator that judges each rule but those of clips
// and cuts.

#include <algorithm>

#include "engine/exercise/exercise_evaluator.h"
#include "engine/exercise/step_queries.h"

namespace hpdm {
namespace {

struct Pull {
  int hand = -1;
  SolvedContact contact;
};

// Returns the hand whose tip exerts most, with its contact.
Pull MostPulling(const StepSample& sample) {
  Pull most;
  for (int t = 0; t < sample.tool_count; ++t) {
    const SolvedContact& contact = sample.contacts[ToSize(t)];
    const double force = contact.force_on_tissue_W.norm();
    if (contact.organ < 0 || force < most.contact.force_on_tissue_W.norm()) continue;
    most = {t, contact};
  }
  return most;
}

// The contacts of a tip with the organ of a rule.
struct Touch {
  int organ = -1;
  double force = 0;  // N, the largest
  bool any = false;  // it touches an organ, this or another one
};

// `organ`: -1: any.
Touch TouchOf(const StepSample& sample, int hand, int organ) {
  Touch touch;
  VisitContacts(sample, hand, [&](const SolvedContact& contact) {
    if (!Touches(contact)) return;
    touch.any = true;
    if (organ >= 0 && contact.organ != organ) return;
    touch.organ = contact.organ;
    touch.force = std::max(touch.force, contact.force_on_tissue_W.norm());
  });
  return touch;
}

// True if a rule forbids to burn near ducts, not near a line in space.
bool OfDuct(const ExerciseErrorOptions& error) {
  return error.kind == ExerciseErrorKind::kNearBurn && error.path_W.empty();
}

// True if the hook's tip is where the rule forbids to burn.
bool IsWrongToBurn(const ExerciseErrorOptions& error, const StepSample& sample, int hand,
                   const Touch& touch) {
  const auto h = static_cast<std::size_t>(hand);
  if (OfDuct(error)) {
    const NearDuct& duct = sample.near_ducts[h];
    return duct.duct >= 0 && duct.gap <= error.within && Contains(error.ducts, duct.duct) &&
           sample.ducts[ToSize(duct.duct)].cuts == 0;
  }
  if (error.kind == ExerciseErrorKind::kNearBurn) {
    return DistanceTo(error.path_W, sample.tools[h].X_WT.translation()) <= error.within;
  }
  if (sample.layer_work[h].burning > 0) return false;  // a layer is burnt, not the wall
  return error.kind == ExerciseErrorKind::kBurn ? touch.organ >= 0 : !touch.any;
}

}  // namespace

void ExerciseEvaluator::FindErrors(const StepSample& sample, double dt) {
  for (std::size_t rule = 0; rule < options_.errors.size(); ++rule) {
    switch (options_.errors[rule].kind) {
      case ExerciseErrorKind::kForce:
        FindForce(sample, rule);
        break;
      case ExerciseErrorKind::kTear:
        FindTears(sample, rule);
        break;
      case ExerciseErrorKind::kBurn:
      case ExerciseErrorKind::kStrayBurn:
      case ExerciseErrorKind::kNearBurn:
        FindBurns(sample, rule, dt);
        break;
      case ExerciseErrorKind::kDrop:
        FindDrops(sample, rule);
        break;
      case ExerciseErrorKind::kInverted:
        FindInversion(sample, rule);
        break;
      case ExerciseErrorKind::kBadClip:
      case ExerciseErrorKind::kWrongClip:
      case ExerciseErrorKind::kLostClip:
      case ExerciseErrorKind::kEarlyClip:
      case ExerciseErrorKind::kEarlyCut:
      case ExerciseErrorKind::kBadCut:
        break;  // JudgeAction()
      case ExerciseErrorKind::kWrongCut:
        FindWrongCuts(sample, rule);
        break;
      case ExerciseErrorKind::kBleeding:
        FindBleedings(rule);
        break;
      case ExerciseErrorKind::kStretch:
        FindStretches(sample, rule);
        break;
      case ExerciseErrorKind::kPerforation:
        FindPerforations(sample, rule);
        break;
    }
  }
}

void ExerciseEvaluator::FindForce(const StepSample& sample, std::size_t rule) {
  const ExerciseErrorOptions& error = options_.errors[rule];
  for (int t = 0; t < sample.tool_count; ++t) {
    Watch& watch = watches_[rule][static_cast<std::size_t>(t)];
    double largest = 0;
    SolvedContact at;
    VisitContacts(sample, t, [&](const SolvedContact& contact) {
      const double force = contact.force_on_tissue_W.norm();
      if ((error.organ >= 0 && contact.organ != error.organ) || force <= largest) return;
      largest = force;
      at = contact;
    });
    if (watch.active) {
      if (largest < kForceBelow * error.limit) watch.active = false;
      ExerciseError& counted = result_.errors[watch.error];
      if (largest <= counted.force) continue;
      counted.force = largest;
      counted.place_W = at.contact_W;
    } else if (largest > error.limit && AddError(rule, t, at.organ, at.contact_W, largest)) {
      watch.active = true;
      watch.error = result_.errors.size() - 1;
    }
  }
}

// A tear belongs to the hand that pulls most.
void ExerciseEvaluator::FindTears(const StepSample& sample, std::size_t rule) {
  const ExerciseErrorOptions& error = options_.errors[rule];
  const double torn = TornArea(sample, error.attachment);
  if (torn - torn_[rule] < error.limit) return;
  torn_[rule] = torn;
  const auto [hand, most] = MostPulling(sample);
  AddError(rule, hand, most.organ, most.contact_W, most.force_on_tissue_W.norm());
}

// A stretch belongs to the hand that pulls most.
void ExerciseEvaluator::FindStretches(const StepSample& sample, std::size_t rule) {
  const ExerciseErrorOptions& error = options_.errors[rule];
  for (std::size_t d = 0; d < ToSize(sample.duct_count); ++d) {
    if (!error.ducts.empty() && !Contains(error.ducts, static_cast<int>(d))) continue;
    const double stretch = sample.ducts[d].length / first_lengths_[d];
    bool& active = stretched_[rule][d];
    if (active) {
      active = stretch >= kStretchBelow * error.limit;
      continue;
    }
    if (!(stretch > error.limit)) continue;
    const auto [hand, most] = MostPulling(sample);
    active = AddError(rule, hand, most.organ, most.contact_W, sample.ducts[d].tension,
                      static_cast<int>(d));
  }
}

void ExerciseEvaluator::FindBurns(const StepSample& sample, std::size_t rule, double dt) {
  const ExerciseErrorOptions& error = options_.errors[rule];
  for (int t = 0; t < sample.tool_count; ++t) {
    const auto h = static_cast<std::size_t>(t);
    Watch& watch = watches_[rule][h];
    const Touch touch = TouchOf(sample, t, error.organ);
    if (!IsHook(sample, t) || !sample.tools[h].pedal || !IsWrongToBurn(error, sample, t, touch)) {
      watch = {};
      continue;
    }
    watch.since += dt;
    if (watch.active || watch.since < error.limit) continue;
    watch.active = true;
    AddError(rule, t, touch.organ, sample.tools[h].X_WT.translation(), touch.force,
             OfDuct(error) ? sample.near_ducts[h].duct : -1);
  }
}

// The press may end as the jaws close.
void ExerciseEvaluator::FindWrongCuts(const StepSample& sample, std::size_t rule) {
  const int organ = options_.errors[rule].organ;
  if (options_.scissors.empty()) return;
  for (int t = 0; t < sample.tool_count; ++t) {
    const auto h = ToSize(t);
    if (jaw_closings_.ClosingFrom(h) == 0 ||
        !IsOneOf(options_.scissors, t, sample.tools[h].instrument_index)) {
      continue;
    }
    const SolvedContact& last = last_contacts_[h];
    const bool pressed = last.organ == organ && Touches(last);
    if (!pressed && !Presses(sample, t, organ)) continue;
    const SolvedContact& contact = pressed ? last : sample.contacts[h];
    AddError(rule, t, organ, contact.contact_W, contact.force_on_tissue_W.norm());
  }
}

void ExerciseEvaluator::FindDrops(const StepSample& sample, std::size_t rule) {
  const ExerciseErrorOptions& error = options_.errors[rule];
  for (int t = 0; t < sample.tool_count; ++t) {
    const auto h = static_cast<std::size_t>(t);
    const SolvedContact& before = last_contacts_[h];
    if (before.kind != ContactKind::kGrasp || before.organ < 0) continue;
    if (error.organ >= 0 && before.organ != error.organ) continue;
    const bool is_held = std::ranges::any_of(sample.contacts, [&](const SolvedContact& contact) {
      return contact.kind == ContactKind::kGrasp && contact.organ == before.organ;
    });
    if (is_held) continue;
    const bool in_place = error.path_W.empty()
                              ? LiftOf(before) <= error.limit
                              : DistanceTo(error.path_W, before.contact_W) <= error.within;
    if (in_place) continue;
    AddError(rule, t, before.organ, before.contact_W, before.force_on_tissue_W.norm());
  }
}

void ExerciseEvaluator::FindInversion(const StepSample& sample, std::size_t rule) {
  Watch& watch = watches_[rule][0];
  if ((sample.step.flags & kStepInverted) == 0) {
    if (result_.time - watch.last >= kSoundAgain) watch.active = false;
    return;
  }
  watch.last = result_.time;
  if (watch.active) return;
  watch.active = AddError(rule, -1, -1, Vector3d::Zero(), 0);
}

void ExerciseEvaluator::FindBleedings(std::size_t rule) {
  for (std::size_t b = 0; b < result_.bleedings.size(); ++b) {
    const ExerciseBleeding& bleeding = result_.bleedings[b];
    if (bleedings_counted_[rule][b] ||
        bleeding.end - bleeding.begin < options_.errors[rule].limit) {
      continue;
    }
    bleedings_counted_[rule][b] = AddError(rule, -1, -1, Vector3d::Zero(), 0);
  }
}

// A perforation belongs to the energised hook on the organ, or else to another tip on it, in this step
// or in the last: the wall is judged by the contacts of the last step.
void ExerciseEvaluator::FindPerforations(const StepSample& sample, std::size_t rule) {
  const int organ = options_.errors[rule].organ;
  std::size_t& judged = perforations_judged_[rule];
  for (; judged < perforations_.size(); ++judged) {
    const Perforation& perforation = perforations_[judged];
    if (perforation.time_ns >= sample.step.time_ns) break;
    if (organ >= 0 && perforation.organ != organ) continue;
    int hand = -1;
    bool burns = false;
    SolvedContact at;
    for (int t = 0; t < sample.tool_count; ++t) {
      const auto h = static_cast<std::size_t>(t);
      const bool hot = IsHook(sample, t) && sample.tools[h].pedal;
      for (const SolvedContact& contact : {sample.contacts[h], last_contacts_[h]}) {
        const bool presses =
            contact.organ == perforation.organ && contact.kind == ContactKind::kPress;
        if (!presses || (hand >= 0 && (burns || !hot))) continue;
        hand = t;
        burns = hot;
        at = contact;
      }
    }
    AddError(rule, hand, perforation.organ, at.contact_W, at.force_on_tissue_W.norm());
  }
}

}  // namespace hpdm
