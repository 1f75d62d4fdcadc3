#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "engine/exercise/exercise_evaluator.h"
#include "engine/snapshots.h"
#include "engine/threads/histogram.h"
#include "engine/threads/loop_event.h"
#include "lcmtypes/analysis/slip_counter.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/telemetry/session_info.h"

namespace hpdm {

/// Turns samples, steps and counters into events of the session. Each change is one event.
///
/// Thread: that of its owner. Guarantee: equal calls give equal events, since it reads no clock and
/// no file; it allocates only when something happens.
class EventReporter {
 public:
  /// Receives an event. `name` is short and stable ("log.failed"), `text` one sentence.
  using Sink = std::function<void(EventSeverity, const std::string& name, const std::string& text)>;
  /// Receives one line for the user. May be null.
  using Tell = std::function<void(const std::string&)>;

  EventReporter(const SessionInfo& info, Sink sink, Tell tell);

  /// Sends the events of a copy elsewhere.
  void SetSink(Sink sink) { sink_ = std::move(sink); }

  /// Reports the session's start, and the wake-ups of an empty loop before it, if there are any.
  void ReportStart(const Histogram& baseline);
  void ReportEnd();

  /// Reports devices that connected, were lost or are back, pauses, instruments that a hand took,
  /// and tissue that begins to slip through jaws.
  /// The user is told about each device at most once a second. A device that has not given a pose
  /// yet is not lost.
  void Add(const HapticSample& sample);
  /// Reports organs that invert or recover, attachments that are damaged, tear and are torn through,
  /// layers beyond their strength, and steps that change their quality.
  void Add(const StepSample& sample);
  /// Reports an exercise's steps, errors, restarts and end. `exercise`: after the newest step.
  void Add(const ExerciseEvaluator& exercise);
  /// Publishes a loop's own event. Prints warnings and errors for the user.
  void Add(const LoopEvent& event);

  /// Reports the losses of an interval. `overflows`: ticks that found the sample queue full, since
  /// the session began. `steps_lost`: steps that found theirs full, in the interval.
  void AddLosses(std::uint64_t overflows, std::int64_t steps_lost);

  /// Reports each kind of failure once and tells the user. `timeline` is Timeline::Explain().
  void AddFailures(const LogState& log, const std::string& timeline, std::uint64_t live_errors);

 private:
  void AddDevices(const HapticSample& sample);
  void TellOfDevice(std::size_t instrument, Nanoseconds now);
  void AddControl(const HapticSample& sample);
  void AddSlips(const HapticSample& sample);
  void AddOrgans(const StepSample& sample);
  void AddAttachments(const StepSample& sample);
  void AddLayers(const StepSample& sample);
  void AddLumens(const StepSample& sample);
  void AddDucts(const StepSample& sample);
  void AddShedding(int level);
  void AddRestarts(const ExerciseEvaluator& exercise);
  void AddOnce(bool* reported, EventSeverity severity, const char* name, const std::string& text);

  /// State of a device that was last printed for the user.
  struct ToldDevice {
    bool awaited = false;  ///< The last line said that it is awaited.
    bool lost = false;
    Nanoseconds at = -kNanosecondsPerSecond;  ///< Session time when the user was told.
  };

  Sink sink_;
  Tell tell_;
  std::vector<std::string> instruments_;
  std::vector<std::vector<std::string>> held_;
  std::vector<std::string> organs_;
  std::vector<AttachmentDescription> attachments_;
  std::vector<LayerDescription> layers_;
  std::vector<std::string> lumens_;
  std::vector<std::string> ducts_;
  bool left_handed_ = false;

  SessionControl control_;  // as the last sample had it
  std::array<bool, kMaxInstruments> device_lost_{};
  std::array<bool, kMaxInstruments> device_seen_{};  // it has given a pose
  std::array<ToldDevice, kMaxInstruments> told_devices_{};
  std::array<SlipCounter, kMaxInstruments> slips_{};
  std::array<bool, kMaxOrgans> organ_unsound_{};
  std::array<Nanoseconds, kMaxOrgans> organ_unsound_last_{};  // session time of the last such step
  std::array<AttachmentOutcome, kMaxAttachments> outcomes_;   // of the last step
  std::array<bool, kMaxLayers> layer_overloaded_{};
  std::array<bool, kMaxLumens> perforated_{};
  std::array<DuctOutcome, kMaxDucts> duct_outcomes_{};    // of the last step
  std::size_t exercise_steps_ = 0, exercise_errors_ = 0;  // reported so far
  int bleedings_over_ = 0;                                // the same
  std::size_t exercise_restarts_ = 0;                     // the same
  bool exercise_ended_ = false;
  int shed_level_ = 0;           // of the last step
  std::uint64_t overflows_ = 0;  // reported so far
  bool log_failure_reported_ = false;
  bool log_move_reported_ = false;
  bool timeline_failure_reported_ = false;
  bool live_failure_reported_ = false;
};

}  // namespace hpdm
