#include "tools/haptics/tissue_tables.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "tools/haptics/tissue_hand.h"
#include "tools/haptics/tissue_law.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

constexpr double kDepth = 0.004, kAbove = 1e-4, kAmplitude = 2e-4, kDeepest = 0.005;  // m
constexpr double kStart = 0.1, kRamp = 0.5;                                           // s
constexpr double kMostGiven = 10;                                                     // mJ
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

struct NamedSeries {
  std::string name;
  PronySeries prony;
};

PronySeries Series(std::initializer_list<PronySeries::Term> terms) {
  PronySeries prony;
  for (const PronySeries::Term& term : terms) {
    prony.terms[static_cast<std::size_t>(prony.count++)] = term;
  }
  return prony;
}

std::vector<NamedSeries> AllSeries(bool quick) {
  std::vector<NamedSeries> series = {
      {"0.3 (20 ms), 0.2 (0.5 s), 0.25 (5 s)", Series({{0.3, 0.02}, {0.2, 0.5}, {0.25, 5}})}};
  if (quick) return series;
  series.push_back(
      {"0.3 (10 ms), 0.3 (0.1 s), 0.3 (1 s)", Series({{0.3, 0.01}, {0.3, 0.1}, {0.3, 1}})});
  series.push_back({"0.5 (0.3 s)", Series({{0.5, 0.3}})});
  series.push_back({"0.9 (1 s)", Series({{0.9, 1}})});
  return series;
}

struct PressCase {
  std::string name;
  TissuePress press;
};

// The place is beside the block's axis, between the vertices of its mesh.
std::vector<PressCase> AllPresses(bool quick) {
  std::vector<PressCase> cases;
  for (const auto& [name, prony] : AllSeries(quick)) {
    for (const int functions : {0, 27}) {
      if (functions > 0 && (quick || prony.count == 1)) continue;
      for (const double radius : {0.0025, 0.015}) {
        TissuePress press{.block = {.local_functions = functions, .squares = 16},
                          .prony = prony,
                          .tip_radius = radius,
                          .friction = 0.5,
                          .place_W = Vector3d(0.0113, 0.0071, 0)};
        cases.push_back({Format("R %.1f mm, %s%s", 1e3 * radius, name.c_str(),
                                functions > 0 ? ", local functions" : ""),
                         press});
      }
    }
  }
  return cases;
}

// What a hand that moves at one place feels, and what the law gives for the same motion.
struct FeltAndLaw {
  std::vector<double> felt, law;  // N, one value a tick
};

// Returns the largest error over the ticks from `from` to `to` s, of `scale` or, if that is 0, of
// the law's force in the tick.
double LargestError(const FeltAndLaw& force, double from, double to, double scale = 0) {
  double largest = 0;
  const auto first = static_cast<std::size_t>(std::lround(from / kTissuePeriod));
  const auto end =
      std::min(static_cast<std::size_t>(std::lround(to / kTissuePeriod)), force.law.size());
  for (std::size_t i = first; i < end; ++i) {
    const double error =
        std::abs(force.felt[i] - force.law[i]) / (scale > 0 ? scale : force.law[i]);
    if (!(error <= largest)) largest = error;
  }
  return largest;
}

// Takes the law of `law` instead of the tissue's own.
FeltAndLaw Follow(const TissuePress& press, const RelaxedPress& relaxed, const PronySeries& law,
                  const std::function<double(double time)>& depth, double seconds) {
  FeltAndLaw force{.felt = FeltForce(press, depth, seconds), .law = {}};
  std::vector<double> elastic;
  for (std::size_t i = 0; i < force.felt.size(); ++i) {
    elastic.push_back(relaxed.Force(depth(static_cast<double>(i) * kTissuePeriod)));
  }
  force.law = RelaxedForce(law, elastic, kTissuePeriod);
  return force;
}

struct LawTables {
  ContactTable hold, ratio, phase;
};

LawTables EmptyLawTables(const std::vector<double>& frequencies) {
  LawTables tables;
  tables.hold = {
      "tissue_hold",
      "Tip that presses a viscoelastic block 200 mm wide 4 mm deep within one tick, or in 0.5 s, "
      "and stays for 2.4 s or more: largest error of the felt force of any tick, against the "
      "convolution of the relaxed tissue's force with the Prony terms (shares and times). The "
      "ramp's error is of its largest force, the others' of the law's force in the same tick.",
      Format("Target: at most %.0f %%.", 100 * kTissueForceError),
      {{"step, %", "step_percent", 2},
       {"ramp, %", "ramp_percent", 2},
       {"held, %", "hold_percent", 2}},
      {}};
  tables.ratio = {
      "tissue_sine_amplitude",
      "The same tip that moves up and down by 0.2 mm about a depth of 4 mm: amplitude of "
      "the felt force over the law's.",
      Format("Target: within %.0f %%.", 100 * kTissueForceError),
      {},
      {}};
  tables.phase = {"tissue_sine_phase",
                  "Phase of the same, degrees; negative: the force is late.",
                  Format("Target: within %.0f degrees.", kTissuePhaseError),
                  {},
                  {}};
  for (const double frequency : frequencies) {
    const std::string title = Format("%.3g Hz", frequency);
    tables.ratio.columns.push_back({title, Format("at_%.3g_Hz", frequency), 4});
    tables.phase.columns.push_back({title, Format("at_%.3g_Hz", frequency), 2});
  }
  return tables;
}

LawTables MeasureLaw(bool quick) {
  const std::vector<double> frequencies =
      quick ? std::vector{1.0, 10.0} : std::vector{0.1, 0.3, 1.0, 3.0, 10.0};
  LawTables tables = EmptyLawTables(frequencies);
  for (const auto& [name, press] : AllPresses(quick)) {
    const RelaxedPress relaxed(press, kDeepest);
    const HoldError hold = MeasureHold(press, relaxed, press.prony);
    const auto percent = [](double error) {
      return JudgedValue{100 * error, 0, 100 * kTissueForceError};
    };
    tables.hold.rows.push_back(
        {name, {percent(hold.step), percent(hold.ramp), percent(hold.hold)}});
    ContactTable::Row ratios{name, {}}, phases{name, {}};
    for (const double frequency : frequencies) {
      const SineError sine = MeasureSine(press, relaxed, press.prony, frequency);
      ratios.values.push_back({sine.ratio, 1 - kTissueForceError, 1 + kTissueForceError});
      phases.values.push_back({sine.phase, -kTissuePhaseError, kTissuePhaseError});
    }
    tables.ratio.rows.push_back(ratios);
    tables.phase.rows.push_back(phases);
  }
  return tables;
}

struct NamedScript {
  std::string name;
  HandScript script;
};

struct HandTables {
  ContactTable given, by_law, reversals;
};

HandTables EmptyHandTables(const std::vector<double>& times) {
  HandTables tables;
  tables.given = {"tissue_hand",
                  "Simulated hand on a simulated device, 10 s on an ellipsoid of 5 kPa in the long "
                  "term with one term of the given share and time: most energy that the motors had "
                  "given at any time, mJ.",
                  Format("Target: at most %.0f mJ.", kMostGiven),
                  {},
                  {}};
  tables.by_law = {"tissue_hand_law",
                   "The part of it that the tissue's law gives, before hold, delay and guard, mJ. "
                   "What the hold adds is below the passivity bound: the device's own friction and "
                   "damping dissipate it.",
                   Format("Target: at most %.0f mJ.", kMostGiven),
                   {},
                   {}};
  tables.reversals = {"tissue_hand_reversals",
                      "Reversals of the displayed force along the normal of the same hands, beyond "
                      "those on elastic tissue of the long-term modulus.",
                      "Target: none.",
                      {},
                      {}};
  for (const double time : times) {
    for (ContactTable* table : {&tables.given, &tables.by_law, &tables.reversals}) {
      table->columns.push_back({Format("%.3g s", time), Format("time_%.3g_s", time),
                                table == &tables.reversals ? 0 : 2});
    }
  }
  return tables;
}

HandTables MeasureHands(bool quick) {
  std::vector<NamedScript> scripts = {{"presses", HandScript::kPalpate},
                                      {"grasps and lifts", HandScript::kGraspLift}};
  if (!quick) {
    scripts.insert(scripts.end(), {{"grasps and pulls", HandScript::kGraspPull},
                                   {"taps", HandScript::kTap},
                                   {"slides", HandScript::kSlide}});
  }
  const std::vector<double> times =
      quick ? std::vector{0.1, 10.0} : std::vector{0.01, 0.1, 1.0, 10.0, 100.0};
  HandTables tables = EmptyHandTables(times);
  for (const auto& [name, script] : scripts) {
    const int elastic = Reversals(HandleTissue({}, script));
    for (const double share : {0.5, 0.9}) {
      if (quick && share < 0.9) continue;
      const std::string row = Format("%s, share %.1f", name.c_str(), share);
      ContactTable::Row given{row, {}}, by_law{row, {}}, reversals{row, {}};
      for (const double time : times) {
        const HandCourse course = HandleTissue(Series({{share, time}}), script);
        given.values.push_back({1e3 * MostGiven(course), 0, kMostGiven});
        by_law.values.push_back({1e3 * MostGivenByLaw(course), 0, kMostGiven});
        reversals.values.push_back(
            {static_cast<double>(Reversals(course) - elastic), -kUnbounded, 0});
      }
      tables.given.rows.push_back(given);
      tables.by_law.rows.push_back(by_law);
      tables.reversals.rows.push_back(reversals);
    }
  }
  return tables;
}

}  // namespace

HoldError MeasureHold(const TissuePress& press, const RelaxedPress& relaxed,
                      const PronySeries& law) {
  constexpr double kEnd = 3;  // s
  const auto at_once = [](double t) { return t < kStart - kTissuePeriod / 2 ? -kAbove : kDepth; };
  const auto slowly = [](double t) {
    return t < kStart ? -kAbove : std::min(kDepth, kDepth / kRamp * (t - kStart));
  };
  const FeltAndLaw step = Follow(press, relaxed, law, at_once, kEnd);
  const FeltAndLaw ramp = Follow(press, relaxed, law, slowly, kEnd);
  const double largest = *std::max_element(ramp.law.begin(), ramp.law.end());
  const double held = kStart + kRamp;
  return {LargestError(step, kStart, kEnd), LargestError(ramp, 0, held, largest),
          LargestError(ramp, held, kEnd)};
}

SineError MeasureSine(const TissuePress& press, const RelaxedPress& relaxed, const PronySeries& law,
                      double frequency) {
  constexpr double kDown = 0.3, kBegins = 0.5, kSwings = 1;  // s
  const auto depth = [&](double t) {
    const double mean = t < kDown ? -kAbove + (kDepth + kAbove) * t / kDown : kDepth;
    if (t < kBegins) return mean;
    return mean + kAmplitude * std::sin(2 * std::numbers::pi * frequency * (t - kBegins));
  };
  // Whole periods, one second or more of them.
  const double judged = std::max(1.0, std::round(frequency)) / frequency;
  const double seconds = kBegins + (frequency < 1 ? 0 : kSwings) + judged;
  const FeltAndLaw force = Follow(press, relaxed, law, depth, seconds);
  const auto count = static_cast<std::size_t>(std::lround(judged / kTissuePeriod));
  const Fundamental felt = FundamentalOf(force.felt, count, frequency, kTissuePeriod);
  const Fundamental meant = FundamentalOf(force.law, count, frequency, kTissuePeriod);
  const double ahead = std::remainder(felt.phase - meant.phase, 2 * std::numbers::pi);
  return {felt.amplitude / meant.amplitude, ahead * 180 / std::numbers::pi};
}

std::vector<ContactTable> MeasureTissue(bool quick,
                                        const std::function<void(const ContactTable&)>& done) {
  std::vector<ContactTable> tables;
  const auto add = [&](ContactTable table) {
    tables.push_back(std::move(table));
    done(tables.back());
  };
  LawTables law = MeasureLaw(quick);
  add(std::move(law.hold));
  add(std::move(law.ratio));
  add(std::move(law.phase));
  HandTables hands = MeasureHands(quick);
  add(std::move(hands.given));
  add(std::move(hands.by_law));
  add(std::move(hands.reversals));
  return tables;
}

}  // namespace hpdm
