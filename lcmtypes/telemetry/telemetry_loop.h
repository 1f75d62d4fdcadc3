#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "engine/exercise/exercise_evaluator.h"
#include "engine/snapshots.h"
#include "engine/threads/histogram.h"
#include "engine/threads/loop_event.h"
#include "engine/threads/spsc_queue.h"
#include "engine/threads/triple_buffer.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/telemetry/event_reporter.h"
#include "lcmtypes/telemetry/health_publisher.h"
#include "lcmtypes/telemetry/live_publisher.h"
#include "lcmtypes/telemetry/log_writer.h"
#include "lcmtypes/telemetry/output_thinning.h"
#include "lcmtypes/telemetry/session_info.h"
#include "lcmtypes/telemetry/session_statistics.h"
#include "lcmtypes/telemetry/step_matcher.h"
#include "lcmtypes/wire/codec.h"

namespace hpdm {

struct TelemetryOptions {
  bool live = false;           ///< Publish over LCM too, on NetworkUrl().
  bool forces_linked = false;  ///< A DeviceLink publishes HPDM_FORCE; it is only logged here.
  std::int64_t epoch_us = 0;   ///< Wall time of the session's start, microseconds since 1970, for
                               ///< the log's time stamps; 0 in the lockstep clock.
  std::string timeline_path;   ///< Of timeline.csv; empty: none.
  Nanoseconds timeline_interval = 10'000'000;  ///< 100 Hz.
  Nanoseconds haptic_period = 1'000'000;       ///< 1 / haptic_hz.
  /// Ticks, at least 1. Above 1 the log holds the outputs (HPDM_FORCE, HPDM_ORGAN) of one tick in so
  /// many and those that OutputThinning adds. The network and the statistics still get every one.
  int output_interval = 1;
  Nanoseconds mesh_repeat = 3 * kNanosecondsPerSecond;  ///< Between two live repeats.
  SpscQueue<FrameRecord>* frames = nullptr;  ///< Of the render loop; null in the lockstep clock.
  /// Of the render loop and of the device link, each the queue's producer.
  std::vector<SpscQueue<LoopEvent>*> events = {};
  /// Receives one line for the user when a device is lost or back, and at each warning and error
  /// outside the haptic path (files, pictures, network). Called at once on the telemetry thread; it may block.
  std::function<void(const std::string&)> tell = nullptr;
  TripleBuffer<SessionHealth>* health = nullptr;  ///< For the render loop, 10 times a second.
  /// For the deformation loop's checkpoints, after every step of a scene with an exercise; may be null.
  TripleBuffer<ExerciseProgress>* progress = nullptr;
  Histogram baseline = {};  ///< Wake-ups of an empty loop before the session.
  /// Returns the CPU steal time so far (stolen_time.h). Called once a second; null in the lockstep
  /// clock.
  std::function<Nanoseconds()> stolen_time = nullptr;
};

struct TelemetrySummary {
  SessionSummary session;
  LogState log;
  std::uint64_t queue_overflows = 0;       ///< Ticks that found the sample queue full.
  std::uint64_t step_overflows = 0;        ///< Steps that found the step queue full.
  bool live = false;                       ///< Publishing was requested.
  std::uint64_t live_messages = 0;         ///< Published.
  std::uint64_t live_errors = 0;           ///< Refused by the network.
  std::optional<ExerciseResult> exercise;  ///< Of a scene with one.
  std::string timeline_failure;  ///< Why rows are missing in timeline.csv; empty if none are.
};

/// Reads the haptic loop's samples, the deformation loop's steps and its snapshots (displacements,
/// not vertices), and connects the parts that record them:
///
///     HapticSample queue (every tick) --> TelemetryLoop --> LogWriter: session.lcmlog, timeline
///     StepSample queue (every step) ---->  |  |  |  |  '--> LivePublisher: LCM, if options.live
///     SceneSnapshot (latest value) ----->  |  |  |  '-----> HealthPublisher --> render loop
///     FrameRecord, LoopEvent queues ---->  |  |  '--------> EventReporter: what happened
///                                          |  '-----------> SessionStatistics: counts and times
///                                          '--------------> StepMatcher: first use of each step
///
/// 1. Everything but the constructor runs on one thread: its own (Run, real clock) or the thread
///    that runs everything (Drain, Finish; lockstep clock).
/// 2. The haptic and the deformation loop never wait for it. If a disk or a network delays it, the
///    queues overflow, which is counted.
/// 3. The log always holds every input (HPDM_TOOL, HPDM_CONTACT), so that it can be replayed.
/// 4. It logs nothing that it measures itself: the same samples, drained in the same portions, give
///    the same bytes.
class TelemetryLoop {
 public:
  /// Writes the meshes and the session's first event into the log. The edges outlive the loop.
  /// Throws InputError if a file cannot be created, and MachineError if options.live and the
  /// network cannot be opened. Without options.live no socket is opened.
  TelemetryLoop(SpscQueue<HapticSample>* samples, SpscQueue<StepSample>* steps,
                TripleBuffer<SceneSnapshot>* scenes, const std::string& log_path,
                const TelemetryOptions& options, const SessionInfo& info);
  ~TelemetryLoop();
  TelemetryLoop(const TelemetryLoop&) = delete;
  TelemetryLoop& operator=(const TelemetryLoop&) = delete;

  /// Handles everything that is queued, and the newest snapshot. Never throws.
  void Drain() noexcept;

  /// Drains every 5 ms until a stop is requested, then once more, and finishes. Stop the
  /// writing loops before this one.
  void Run(std::stop_token stop) noexcept;

  /// Drains, closes the last interval and the files. Later calls of Drain and Finish do nothing.
  void Finish() noexcept;

  /// Logs and publishes an event at the newest time seen. `name` is short and stable
  /// ("log.failed"), `text` one sentence. Events of the lockstep clock must hold nothing measured.
  void AddEvent(EventSeverity severity, const std::string& name, const std::string& text) noexcept;

  TelemetrySummary Summary() const;

  /// True once the scene's exercise has ended. Any thread.
  bool ExerciseEnded() const { return exercise_ended_.load(std::memory_order_acquire); }
  /// Number of the exercise's bleedings that were stopped. Any thread.
  int BleedingsOver() const { return bleedings_over_.load(std::memory_order_acquire); }

 private:
  /// Messages of a channel whose outputs the log may leave out.
  struct OutputCounts {
    std::int64_t logged = 0, published = 0;
  };
  /// The shape of one organ that the log or the network got last.
  class SentShape {
   public:
    /// `interval`: ns of session time that have one shape at most; 0: any number.
    explicit SentShape(Nanoseconds interval) : interval_(interval) {}
    /// True if the shape is to be sent: it is new or a second old, and the first of its interval.
    bool Update(const OrganSnapshot& organ, const StepRecord& step);

   private:
    struct Shape {
      std::uint64_t version;  // OrganSnapshot's
      Vector3d offset_W;      // m
      Nanoseconds time;       // of the session
    };
    Nanoseconds interval_;
    std::optional<Shape> last_;
  };

  void SendExercise(Nanoseconds time);
  void SendProgress();
  void WriteMeshes(const std::vector<OrganDescription>& organs);
  void Handle(const HapticSample& sample);
  void Handle(const StepSample& sample);
  void Handle(const SceneSnapshot& scene);
  void AdvanceTo(Nanoseconds time, Nanoseconds patience);
  void CloseInterval(Nanoseconds end);
  void CountStolenTime();
  void ReportFailures();
  template <typename Message>
  void Send(const char* channel, Nanoseconds time, const Message& message);
  template <typename Message>
  void SendOutput(const char* channel, Nanoseconds time, bool log, bool publish,
                  OutputCounts* counts, Message* message);

  SpscQueue<HapticSample>* samples_;
  SpscQueue<StepSample>* steps_;
  TripleBuffer<SceneSnapshot>* scenes_;
  TelemetryOptions options_;
  LivePublisher live_;
  LogWriter log_;
  EventReporter events_;
  StepMatcher matcher_;
  SessionStatistics statistics_;
  HealthPublisher health_;
  std::optional<ExerciseEvaluator> exercise_;
  std::atomic<bool> exercise_ended_ = false;
  std::atomic<int> bleedings_over_ = 0;

  bool finished_ = false;
  Nanoseconds now_ = 0;              // newest session time seen
  Nanoseconds stolen_ = 0;           // total when last asked
  std::uint64_t frames_missed_ = 0;  // total when last asked
  OutputThinning thinning_;
  OutputCounts forces_, shapes_;
  std::vector<SentShape> logged_shapes_, published_shapes_;  // by organ

  // Reused, so that a steady session allocates nothing here. Sequence numbers count in them, but
  // for forces_ and shapes_.
  std::vector<std::uint8_t> live_buffer_;
  tool_t tool_{};
  force_t force_{};
  organ_t organ_{};
  stats_t stats_{};
  event_t event_{};
  exercise_t exercise_message_{};
  std::int64_t contact_sequence_ = 0;
};

}  // namespace hpdm
