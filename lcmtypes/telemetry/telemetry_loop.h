#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "engine/snapshots.h"
#include "engine/threads/histogram.h"
#include "engine/threads/loop_event.h"
#include "engine/threads/spsc_queue.h"
#include "engine/threads/triple_buffer.h"
#include "lcmtypes/live/network.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/telemetry/session_statistics.h"
#include "lcmtypes/telemetry/timeline.h"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/mesh_codec.h"

namespace lcm {
class LCM;
}

namespace hpdm {

struct TelemetryOptions {
  bool live = false;           ///< Publish over LCM too, on NetworkUrl().
  bool forces_linked = false;  ///< A DeviceLink publishes HPDM_FORCE; it is only logged here.
  std::int64_t epoch_us = 0;   ///< Wall time of the session's start, microseconds since 1970, for
                               ///< the log's time stamps; 0 in the lockstep clock.
  std::string timeline_path;   ///< Of timeline.csv; empty: none.
  Nanoseconds timeline_interval = 10'000'000;           ///< 100 Hz.
  Nanoseconds haptic_period = 1'000'000;                ///< 1 / haptic_hz.
  Nanoseconds mesh_repeat = 3 * kNanosecondsPerSecond;  ///< Between two live repeats.
  SpscQueue<FrameRecord>* frames = nullptr;  ///< Of the render loop; null in the lockstep clock.
  /// Of the render loop and of the device link, each the queue's producer.
  std::vector<SpscQueue<LoopEvent>*> events = {};
  /// Receives one line for the user at each warning and error outside the haptic path (files,
  /// pictures, network). Called at once on the telemetry thread; it may block.
  std::function<void(const std::string&)> tell = nullptr;
  TripleBuffer<SessionHealth>* health = nullptr;  ///< For the render loop, 10 times a second.
  Histogram baseline = {};                        ///< Wake-ups of an empty loop before the session.
  /// Returns the CPU steal time so far (stolen_time.h). Called once a second; null in the lockstep
  /// clock.
  std::function<Nanoseconds()> stolen_time = nullptr;
};

/// Parts of a session, by index.
struct SessionInfo {
  std::vector<std::string> instruments;
  std::vector<std::vector<std::string>> held;  ///< Names by instrument and
                                               ///< ToolPose::instrument_index.
  std::vector<OrganDescription> organs;
};

/// Text of the event "session.start".
std::string SessionStartText(const SessionInfo& info);

struct TelemetrySummary {
  SessionSummary session;
  LogState log;
  std::uint64_t queue_overflows = 0;  ///< Ticks that found the sample queue full.
  std::uint64_t step_overflows = 0;   ///< Steps that found the step queue full.
  bool live = false;                  ///< Publishing was requested.
  std::uint64_t live_messages = 0;    ///< Published.
  std::uint64_t live_errors = 0;      ///< Refused by the network.
  std::string timeline_failure;       ///< Why rows are missing in timeline.csv; empty if none are.
};

/// Reads the haptic loop's samples, the deformation loop's steps and its snapshots (displacements,
/// not vertices). Writes every one to the session log, thins the samples into the time line, keeps
/// the statistics, and publishes live if options.live.
///
///     HapticSample queue (every tick) --> Drain --> session.lcmlog, timeline.csv
///     StepSample queue (every step) ---->   |
///     SceneSnapshot (latest value) ----->   '-----> LCM, only with options.live
///     FrameRecord, LoopEvent queues ---->   '--SessionHealth (latest value) --> render loop
///
/// 1. Everything but the constructor runs on one thread: its own (Run, real clock) or the thread
///    that runs everything (Drain, Finish; lockstep clock).
/// 2. The haptic and the deformation loop never wait for it. If a disk or a network delays it, the
///    queues overflow, which is counted.
/// 3. It logs nothing that it measures itself: the same samples, drained in the same portions, give
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

 private:
  void HandleSample(const HapticSample& sample);
  void ReportDevices(const HapticSample& sample);
  void ReportControl(const HapticSample& sample);
  void HandleStep(const StepSample& sample);
  void ReportOrgans(const StepSample& sample);
  void ReportShedding(int level);
  void HandleShapes(const SceneSnapshot& scene);
  void ResolveVisible(std::uint64_t patch_number, std::uint64_t tick);
  void WriteContact(contact_t* message, std::int64_t visible_tick);
  void AdvanceTo(Nanoseconds time, Nanoseconds patience);
  void CloseInterval(Nanoseconds end);
  void CountStolenTime();
  void PublishHealth();
  void PublishMeshPart();
  void ReportFailures();
  void ReportOnce(bool* reported, EventSeverity severity, const char* name,
                  const std::string& text);
  template <typename Message>
  void Send(const char* channel, Nanoseconds time, const Message& message, bool publish = true);
  void Publish(const char* channel, std::span<const std::uint8_t> bytes);

  SpscQueue<HapticSample>* samples_;
  SpscQueue<StepSample>* steps_;
  TripleBuffer<SceneSnapshot>* scenes_;
  TelemetryOptions options_;
  std::unique_ptr<lcm::LCM> live_;  // absent unless asked for
  SessionLog log_;
  std::optional<Timeline> timeline_;
  SessionStatistics statistics_;
  bool finished_ = false;
  bool log_failure_reported_ = false;
  bool log_move_reported_ = false;
  bool timeline_failure_reported_ = false;
  bool live_failure_reported_ = false;
  std::uint64_t overflows_reported_ = 0;
  std::vector<std::string> instruments_;
  std::array<bool, kMaxInstruments> device_lost_{};
  std::vector<std::vector<std::string>> held_;
  SessionControl control_;  // as the last sample had it
  std::vector<std::string> organs_;
  std::array<bool, kMaxOrgans> organ_unsound_{};
  int shed_level_ = 0;                                        // of the last step
  std::array<Nanoseconds, kMaxOrgans> organ_unsound_last_{};  // session time of the last such step
  struct SentShape {
    std::uint64_t version;  // OrganSnapshot's
    Vector3d offset_W;      // m
    Nanoseconds time;       // of the session
  };
  std::array<std::optional<SentShape>, kMaxOrgans> sent_;
  std::uint64_t live_messages_ = 0;
  std::uint64_t live_errors_ = 0;

  Nanoseconds now_ = 0;              // newest session time seen
  Nanoseconds stolen_ = 0;           // total when last asked
  std::uint64_t frames_missed_ = 0;  // total when last asked
  Nanoseconds last_flush_ = 0;
  SessionHealth health_;

  // Steps that wait for the tick that first uses their patch, and such ticks that wait for their
  // step: whichever crosses its queue first.
  std::deque<contact_t> waiting_;
  std::deque<std::pair<std::uint64_t, std::uint64_t>> first_uses_;  // patch number, tick
  std::uint64_t newest_used_ = 0;                                   // patch number

  std::vector<mesh_t> mesh_parts_;  // for the live repeats
  std::size_t next_part_ = 0;
  Nanoseconds next_repeat_ = 0;
  std::int64_t mesh_sequence_ = 0;

  // Reused, so that a steady session allocates nothing here. Sequence numbers count in them.
  tool_t tool_{};
  force_t force_{};
  organ_t organ_{};
  stats_t stats_{};
  event_t event_{};
  std::int64_t contact_sequence_ = 0;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace hpdm
