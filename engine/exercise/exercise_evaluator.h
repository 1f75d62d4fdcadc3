#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "engine/exercise/duct_judge.h"
#include "engine/exercise/exercise_options.h"
#include "engine/snapshots.h"
#include "engine/step/jaw_closings.h"

namespace hpdm {

/// An error that a trainee made.
struct ExerciseError {
  int rule = 0;                         ///< Index in ExerciseOptions::errors.
  double time = 0;                      ///< s since the exercise began.
  int step = 0;                         ///< Step of the exercise.
  int hand = -1;                        ///< -1: none.
  int instrument_index = 0;             ///< Of that hand, as in ToolPose.
  int organ = -1;                       ///< -1: none.
  Vector3d place_W = Vector3d::Zero();  ///< m.
  double force = 0;       ///< N: of that hand on tissue; of kForce the largest until it is below.
  int duct = -1;          ///< -1: none.
  ClipFinding clip = {};  ///< Of a bad or a lost clip.
};

/// A bleeding that the teacher began.
struct ExerciseBleeding {
  double begin = 0;  ///< s since the exercise began.
  double end = 0;    ///< s, when a clip stopped it; until then, the time of the last step.
  bool stopped = false;
};

/// A return to the beginning of a step.
struct ExerciseRestart {
  int step = 0;          ///< That begins again.
  double time = 0;       ///< s since the exercise began: of the beginning of the step.
  double discarded = 0;  ///< s of the exercise's time after it that do not count any more.
  int errors = 0;        ///< That do not count any more.
};

/// The outcome of an exercise so far.
struct ExerciseResult {
  std::vector<double> step_times;  ///< s since the exercise began, of each step that is done.
  std::vector<ExerciseError> errors;
  std::vector<ExerciseBleeding> bleedings;  ///< In the order of their begins.
  std::vector<ExerciseRestart> restarts;    ///< In their order.
  double time = 0;      ///< s since the exercise began, up to its end, without `stood`.
  double stood = 0;     ///< s for which the time stood: pauses.
  bool ended = false;   ///< All steps are done, or the time is over.
  bool passed = false;  ///< All steps are done.
  double score = 0;     ///< 0..100.
};

/// Judges a session by its deformation steps. It reads nothing but logged fields of StepSample, so
/// the session, its replay and a report of its log find the same to the last bit:
///
///     session:  StepSample queue --> telemetry loop --> [evaluator] --> display, end
///     log:      HPDM_CONTACT ------------------------> [evaluator] --> report
///
/// Besides it takes the log's events kBleeding and kPerforated with their times. An event may come before or
/// after the steps of that time: the log writes a step once a tick has used it, so only times decide.
/// Each clip that holds a duct stops the oldest bleeding that began before its step. A perforation is
/// judged at the first step after its event.
///
/// Restart: a step of the log that has StepRecord::kept_step keeps the judgement so far, one that has
/// restarted_step returns to it, with its time, errors and score. The restarts stay in the result. Bleedings
/// that are open then are over.
///
/// The exercise begins with the first step. Its time stands in a step whose newest device reading is
/// older than kStandsAfter: a paused session reads no device. So a pause costs at most kStandsAfter, and
/// a session that has lost all its devices costs no time. Forces are those on tissue at the steps; a peak between
/// two steps is not seen. An error counts once until its condition has ended.
///
///     score = max(0, kStepPoints done / steps + kTimePoints share - sum of the errors' points)
///
/// with share = 1 up to the target time and from there linearly to 0 at the time limit, and 0 unless
/// all steps are done. One thread; a call allocates only when a step, an error, a bleeding, a clip or a cut
/// is added.
class ExerciseEvaluator {
 public:
  static constexpr double kStepPoints = 80;
  static constexpr double kTimePoints = 20;
  /// A force error ends below this share of its limit.
  static constexpr double kForceBelow = 0.8;
  /// A duct's stretch ends below this share of its limit.
  static constexpr double kStretchBelow = 0.95;
  /// s without inverted tissue until it counts again.
  static constexpr double kSoundAgain = 0.5;
  static constexpr std::size_t kMaxErrors = 1000;  ///< Later ones cost nothing.
  static constexpr Nanoseconds kStandsAfter = kNanosecondsPerSecond / 10;

  explicit ExerciseEvaluator(ExerciseOptions options);

  /// Takes the next deformation step. After the end it does nothing.
  void Add(const StepSample& sample);

  /// A bleeding begins at this session time. Times do not decrease; no step more than the newest one
  /// before it has been added.
  void AddBleeding(Nanoseconds time_ns);
  /// Number of the bleedings that were stopped or ended by a restart.
  int BleedingsOver() const;
  /// A lumen of this organ begins to leak at this session time. Times as of AddBleeding.
  void AddPerforation(Nanoseconds time_ns, int organ);

  const ExerciseOptions& options() const { return options_; }
  const ExerciseResult& result() const { return result_; }
  ExerciseStatus Status() const;
  ExerciseProgress Progress() const;

 private:
  // The state of one rule, for each hand.
  struct Watch {
    bool active = false;    // the error was counted and its condition has not ended
    double since = 0;       // s that the condition has lasted
    std::size_t error = 0;  // index of the error counted
    double last = 0;        // s, when the condition last held
  };

  void Keep(int step);
  void Restart(int step, Nanoseconds now_ns);
  void ForgetOpenBleedings();
  void AdvanceStep(const StepSample& sample);
  bool Holds(const ExerciseStepOptions& step, const StepSample& sample) const;
  void FindErrors(const StepSample& sample, double dt);
  void JudgeAction(const StepSample& sample, int hand);
  void FindForce(const StepSample& sample, std::size_t rule);
  void FindTears(const StepSample& sample, std::size_t rule);
  void FindStretches(const StepSample& sample, std::size_t rule);
  void FindBurns(const StepSample& sample, std::size_t rule, double dt);
  void FindWrongCuts(const StepSample& sample, std::size_t rule);
  void FindDrops(const StepSample& sample, std::size_t rule);
  void FindInversion(const StepSample& sample, std::size_t rule);
  void AdvanceBleedings(const StepSample& sample);
  void FindBleedings(std::size_t rule);
  void FindPerforations(const StepSample& sample, std::size_t rule);
  bool AddError(std::size_t rule, int hand, int organ, const Vector3d& place_W, double force,
                int duct = -1, const ClipFinding& clip = {});
  double ProgressOf(const ExerciseStepOptions& step, const StepSample& sample) const;
  bool IsHook(const StepSample& sample, int hand) const;
  double Score() const;
  double AdvanceTime(const StepRecord& step);

  ExerciseOptions options_;
  ExerciseResult result_;
  bool begun_ = false;
  Nanoseconds start_ns_ = 0, last_ns_ = 0;
  Nanoseconds stood_ns_ = 0;
  double held_ = 0;  // s that the present step's conditions have held
  bool holding_ = false;
  double progress_ = 0;                                      // of the present step, 0..1
  double points_ = 0;                                        // that errors cost
  std::vector<std::array<Watch, kMaxInstruments>> watches_;  // of each rule
  DuctJudge judge_;
  std::vector<double> torn_;                          // of each rule, m^2: counted so far
  std::vector<Nanoseconds> bleedings_ns_;             // begins, session time
  std::vector<std::vector<bool>> bleedings_counted_;  // of each rule, each bleeding
  struct Perforation {
    Nanoseconds time_ns = 0;  // session time
    int organ = -1;
  };
  std::vector<Perforation> perforations_;
  std::vector<std::size_t> perforations_judged_;        // of each rule, their number
  std::array<double, kMaxDucts> first_lengths_{};       // of the ducts in the first step, m
  std::vector<std::array<bool, kMaxDucts>> stretched_;  // of each rule, each duct
  std::array<SolvedContact, kMaxInstruments> last_contacts_;
  std::array<int, kMaxInstruments> instruments_{};  // that the hands hold, as in ToolPose
  JawClosings jaw_closings_;
  int bleedings_forgotten_ = 0;  // by restarts
  std::vector<std::shared_ptr<const ExerciseEvaluator>>
      kept_;  // at the beginning of each step, or null
};

}  // namespace hpdm
