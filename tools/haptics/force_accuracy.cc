#include "tools/haptics/force_accuracy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "engine/base/error.h"
#include "haptics/device/replay_device.h"
#include "tools/haptics/contact_reference.h"
#include "tools/session/lockstep.h"
#include "tools/session/session.h"

namespace hpdm {
namespace {

// One tick of the production run: what moved, and the input of the step.
struct RecordedTick {
  std::array<ToolSample, kMaxInstruments> samples;
  ToolState tools;
};

// A haptic and a deformation loop of their own on a session's organs.
struct LoopPair {
  LoopPair(const Session& session, std::vector<HapticInstrument> instruments,
           const std::vector<ToolOptions>& tools)
      : scenes(SizedSnapshot(session.organs(), static_cast<int>(tools.size()), false)),
        haptics(std::move(instruments), session.haptic_period_ns(),
                {tool_states, patches, samples}),
        deformation(session.organs(), tools, {tool_states, patches, unread_scenes, scenes}) {}

  // Returns the tick's sample.
  const HapticSample& Sample() {
    while (samples.Pop(&sample)) continue;
    return sample;
  }

  TripleBuffer<ToolState> tool_states;
  TripleBuffer<ContactPatch> patches;
  TripleBuffer<SceneSnapshot> scenes;
  TripleBuffer<SceneSnapshot> unread_scenes{scenes.Front()};
  SpscQueue<HapticSample> samples{4};
  HapticLoop haptics;
  DeformationLoop deformation;
  HapticSample sample;
};

// The scene's session and the recorded motion of its hands.
class Trial {
 public:
  Trial(const Scene& scene, double seconds)
      : session_(scene),
        ticks_(static_cast<std::size_t>(std::lround(seconds * scene.timing.haptic_hz))) {}

  const Session& session() const { return session_; }

  void RecordProduction(std::vector<ForceTimeSeries>* time_series) {
    LoopPair loops(session_, session_.HapticInstruments(), session_.DeformationTools());
    session_.EnableForces(true);
    RunLockstep(&loops, nullptr, [&](const HapticSample& sample) {
      motion_.push_back({sample.tools, loops.deformation.NewestTools()});
      for (std::size_t i = 0; i < time_series->size(); ++i) {
        (*time_series)[i].production.push_back(sample.tools[i].reaction_W);
        (*time_series)[i].depth.push_back(sample.tools[i].depth);
      }
    });
    session_.EnableForces(false);
  }

  // Makes a step before every tick. Its contacts come from the previous tick, its tools from this
  // tick.
  void PlayReference(ForceAccuracy* accuracy) {
    Hands hands = RecordedHands();
    LoopPair loops(session_, Instruments(&hands), session_.DeformationTools());
    for (std::size_t tick = 0; tick < ticks_; ++tick) {
      MoveTo(tick, &hands);
      ToolState tools = motion_[tick].tools;
      tools.contact_points = loops.deformation.NewestTools().contact_points;
      const Nanoseconds now = static_cast<Nanoseconds>(tick) * session_.haptic_period_ns();
      loops.deformation.Step(tools, now);
      loops.haptics.Tick(tick, now, {});
      const HapticSample& sample = loops.Sample();
      loops.scenes.Update();
      const SceneSnapshot& step = loops.scenes.Front();
      for (std::size_t i = 0; i < accuracy->time_series.size(); ++i) {
        ForceTimeSeries& series = accuracy->time_series[i];
        series.reference.push_back(-step.contacts[i].force_on_tissue_W);
        series.shaft_ticks += step.contacts[i].shaft_contact;
        series.reference_tick.push_back(sample.tools[i].reaction_W);
      }
      accuracy->residual = std::max(accuracy->residual, step.step.residual);
      if ((step.step.flags & kStepBudgetSpent) != 0) ++accuracy->unfinished_steps;
    }
  }

  // Searches the contacts on the solved organs.
  void SearchReference(ForceAccuracy* accuracy) const {
    // A solution takes fifty times as long in finite strain.
    constexpr double kSpacing = 0.004, kFiniteSpacing = 0.008;    // m
    constexpr std::size_t kJudgedEvery = 20, kFiniteEvery = 100;  // ticks
    const bool finite =
        std::any_of(session_.organs().begin(), session_.organs().end(),
                    [](const OrganModel& organ) { return organ.finite_energy() != nullptr; });
    ContactReference reference(session_.organs(), session_.DeformationTools(),
                               finite ? kFiniteSpacing : kSpacing);
    const std::size_t every = finite ? kFiniteEvery : kJudgedEvery;
    for (ForceTimeSeries& series : accuracy->time_series) series.judged_every = every;
    for (std::size_t tick = 0; tick < ticks_; tick += every) {
      const auto& contacts = reference.Solve(motion_[tick].tools);
      for (std::size_t i = 0; i < accuracy->time_series.size(); ++i) {
        accuracy->time_series[i].independent.push_back(-contacts[i].force_on_tissue_W);
      }
    }
    accuracy->unsolved = reference.unsolved();
  }

  // Runs production with the springs of `options`, one entry per instrument.
  std::vector<ForceSignal> PlayPaper(const std::vector<ToolOptions>& options) {
    Hands hands = RecordedHands();
    LoopPair loops(session_, Instruments(&hands), options);
    std::vector<ForceSignal> forces(options.size());
    RunLockstep(&loops, &hands, [&](const HapticSample& sample) {
      for (std::size_t i = 0; i < forces.size(); ++i) {
        forces[i].push_back(sample.tools[i].reaction_W);
      }
    });
    return forces;
  }

 private:
  using Hands = std::vector<ReplayDevice>;  // one per instrument

  // `hands` move the instruments; without them the session's own hands do.
  void RunLockstep(LoopPair* loops, Hands* hands,
                   const std::function<void(const HapticSample&)>& keep) const {
    Lockstep clock(session_.scene().timing, &loops->haptics, &loops->deformation);
    while (clock.tick() < ticks_) {
      clock.StepIfDue();
      if (hands != nullptr) MoveTo(clock.tick(), hands);
      clock.Tick();
      keep(loops->Sample());
    }
  }

  Hands RecordedHands() const {
    Hands hands;
    for (const HapticInstrument& instrument : session_.HapticInstruments()) {
      hands.emplace_back(instrument.device->limits());
    }
    return hands;
  }
  void MoveTo(std::size_t tick, Hands* hands) const {
    for (std::size_t i = 0; i < hands->size(); ++i) (*hands)[i].Set(motion_[tick].samples[i]);
  }
  std::vector<HapticInstrument> Instruments(Hands* hands) const {
    std::vector<HapticInstrument> instruments = session_.HapticInstruments();
    for (std::size_t i = 0; i < hands->size(); ++i) instruments[i].device = &(*hands)[i];
    return instruments;
  }

  Session session_;
  std::size_t ticks_;
  std::vector<RecordedTick> motion_;
};

// Springs of Eq. 29 fitted to the reference by least squares over time. The force is linear in
// them: base + (k - k_base) . slopes, with k >= 0.
struct Springs {
  double k1 = 0;
  double k2 = 0;
};
Springs FittedSprings(const Springs& at, const ForceSignal& base, const ForceSignal& more_k1,
                      const ForceSignal& more_k2, double more, const ForceSignal& reference) {
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
  Eigen::Vector2d y = Eigen::Vector2d::Zero();
  for (std::size_t t = 0; t < base.size(); ++t) {
    Eigen::Matrix<double, 3, 2> slope;
    slope << (more_k1[t] - base[t]) / more, (more_k2[t] - base[t]) / more;
    A += slope.transpose() * slope;
    y += slope.transpose() * (reference[t] - base[t] + slope * Eigen::Vector2d(at.k1, at.k2));
  }
  // Best of: both springs, each alone, none. The score is |F - reference|^2 up to a constant.
  Eigen::Vector2d best = Eigen::Vector2d::Zero();
  const auto try_springs = [&](const Eigen::Vector2d& k) {
    const auto misfit = [&](const Eigen::Vector2d& v) { return v.dot(A * v) - 2 * y.dot(v); };
    if (k.allFinite() && k.minCoeff() >= 0 && misfit(k) < misfit(best)) best = k;
  };
  try_springs(A.ldlt().solve(y));
  try_springs({y[0] / A(0, 0), 0});
  try_springs({0, y[1] / A(1, 1)});
  return {best[0], best[1]};
}

void PlayPapers(Trial* trial, std::vector<ForceTimeSeries>* time_series,
                std::vector<Springs>* fitted) {
  constexpr double kMore = 10;  // N/m
  std::vector<ToolOptions> options = trial->session().DeformationTools();
  for (ToolOptions& tool : options) tool.reaction = ReactionType::kPaper;
  const auto play = [&](double more_k1, double more_k2) {
    std::vector<ToolOptions> stiffer = options;
    for (ToolOptions& tool : stiffer) {
      tool.k1 += more_k1;
      tool.k2 += more_k2;
    }
    return trial->PlayPaper(stiffer);
  };
  const std::vector<ForceSignal> paper = play(0, 0);
  const std::vector<ForceSignal> more_k1 = play(kMore, 0), more_k2 = play(0, kMore);
  for (std::size_t i = 0; i < options.size(); ++i) {
    fitted->push_back(FittedSprings({options[i].k1, options[i].k2}, paper[i], more_k1[i],
                                    more_k2[i], kMore, (*time_series)[i].reference));
    options[i].k1 = fitted->back().k1;
    options[i].k2 = fitted->back().k2;
  }
  const std::vector<ForceSignal> best = play(0, 0);
  for (std::size_t i = 0; i < options.size(); ++i) {
    (*time_series)[i].paper = paper[i];
    (*time_series)[i].paper_fitted = best[i];
  }
}

ForceSignal Magnitude(const ForceSignal& force) {
  ForceSignal magnitude;
  for (const Vector3d& f : force) magnitude.emplace_back(f.norm(), 0, 0);
  return magnitude;
}

// Compares production with the independent reference at the judged ticks.
void AddIndependent(const ForceTimeSeries& series, ForceResults* results) {
  ForceSignal production;
  for (std::size_t i = 0; i < series.independent.size(); ++i) {
    production.push_back(series.production[i * series.judged_every]);
    const bool acts = series.independent[i].squaredNorm() > 0;
    const bool felt = production.back().squaredNorm() > 0;
    results->independent_ticks += acts;
    results->independent_missed += acts && !felt;
    results->independent_false += felt && !acts;
  }
  results->independent_error = ContactError(production, series.independent);
}

ForceResults ResultsOf(const ForceTimeSeries& series, const TimingOptions& timing) {
  ForceResults results;
  results.peak = PeakForce(series.reference);
  results.shaft_ticks = series.shaft_ticks;
  for (std::size_t t = 0; t < series.reference.size(); ++t) {
    const bool acts = series.reference[t].squaredNorm() > 0;
    const bool felt = series.production[t].squaredNorm() > 0;
    results.contact_ticks += acts;
    results.missed_ticks += acts && !felt;
    results.false_ticks += felt && !acts;
    results.largest_tick_error = std::max(results.largest_tick_error,
                                          (series.reference_tick[t] - series.reference[t]).norm());
  }
  if (results.peak > 0) results.largest_tick_error /= results.peak;
  AddIndependent(series, &results);
  results.error = ContactError(series.production, series.reference);
  results.magnitude_error = ContactError(Magnitude(series.production), Magnitude(series.reference));
  results.comb = Comb(series.production, series.reference, timing.haptic_hz, timing.deformation_hz);
  results.largest_step = LargestStep(series.production);
  results.reference_largest_step = LargestStep(series.reference);
  results.tick_error = ContactError(series.reference_tick, series.reference);
  results.paper_error = ContactError(series.paper, series.reference);
  results.paper_fitted_error = ContactError(series.paper_fitted, series.reference);
  return results;
}

}  // namespace

ForceAccuracy MeasureForceAccuracy(const Scene& scene, double seconds) {
  if (scene.instruments.empty()) {
    throw InputError(scene.path.string() + ": no instrument to measure; add an [[instrument]]");
  }
  Trial trial(scene, seconds);
  ForceAccuracy accuracy;
  accuracy.rate_hz = scene.timing.haptic_hz;
  accuracy.time_series.resize(scene.instruments.size());
  trial.RecordProduction(&accuracy.time_series);
  trial.PlayReference(&accuracy);
  trial.SearchReference(&accuracy);
  std::vector<Springs> fitted;
  PlayPapers(&trial, &accuracy.time_series, &fitted);
  for (std::size_t i = 0; i < accuracy.time_series.size(); ++i) {
    accuracy.results.push_back(ResultsOf(accuracy.time_series[i], scene.timing));
    accuracy.results.back().instrument = scene.instruments[i].name;
    accuracy.results.back().script = scene.instruments[i].hand.script;
    accuracy.results.back().paper_fitted_k1 = fitted[i].k1;
    accuracy.results.back().paper_fitted_k2 = fitted[i].k2;
  }
  return accuracy;
}

}  // namespace hpdm
