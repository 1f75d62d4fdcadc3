#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "engine/snapshots.h"
#include "engine/threads/loop_event.h"
#include "engine/threads/spsc_queue.h"
#include "engine/threads/triple_buffer.h"
#include "render/camera/laparoscope.h"
#include "render/gl/egl_context.h"
#include "render/gl/render_context.h"
#include "render/image/frame_sink.h"
#include "render/image/image_file.h"
#include "render/overlay/status_text.h"
#include "render/overlay/view_settings.h"
#include "render/scene_renderer.h"

namespace hpdm {

struct RenderOptions {
  int width = 640;                          ///< px.
  int height = 480;                         ///< px.
  int samples = 0;                          ///< As PictureTarget takes them.
  double max_hz = 30;                       ///< Frames a second at most, in Run.
  std::filesystem::path frame_folder;       ///< PNG frames go here; empty: none are written.
  double frame_fps = 30;                    ///< Of the PNG frames, in session time.
  std::filesystem::path screenshot_folder;  ///< Of a window's; made with the first one.
  StatusNames names;                        ///< For the text.
  std::uint32_t overlays = kOverlayNone;    ///< Or-ed; a window's ViewSettings replace them.
  const Image* background = nullptr;  ///< On the cavity's wall (cavity_renderer.h); must outlive
                                      ///< the loop. Null: a bare wall.
};

/// What the loop did. Written by the render thread; others read it after the loop has ended.
struct RenderStatistics {
  std::uint64_t drawn = 0;    ///< Frames.
  std::uint64_t dropped = 0;  ///< Steps that were replaced by a newer one before being drawn.
  std::string renderer;       ///< The OpenGL renderer; empty before the start.
};

/// Frames a second over the last second. One thread.
class FrameRate {
 public:
  /// Counts a frame at session time `now`.
  void Add(Nanoseconds now);
  /// 0 before the first second is over, and where time stands still.
  double hz() const { return hz_; }

 private:
  Nanoseconds begin_ = 0;
  int frames_ = 0;
  double hz_ = 0;
};

/// The render loop: draws the newest SceneSnapshot through the laparoscope and keeps the picture.
///
///     deformation loop --SceneSnapshot--> [ draw -> show -> read back -> keep ] -> image()
///     window --ViewSettings---------------->                      |          \-> PNG frames
///                             telemetry loop <--FrameRecord queue-'
///
/// Everything from StartOnThisThread to EndOnThisThread happens on one thread, which owns the
/// OpenGL context: either a thread of its own that calls Run (real clock), or the session's only
/// thread that calls Frame after each step (lockstep clock). The rest may be read before the start
/// and after the end.
///
/// Frames are dropped, never queued: a slow frame is followed by the newest step. Nothing that
/// goes wrong after the start is thrown or stops the session: the loop ends and failure() says why.
class RenderLoop {
 public:
  using Clock = std::function<Nanoseconds()>;

  /// What the loop is wired to: reader of the triple buffers, producer of the queues, which lose
  /// and count what finds them full.
  struct Edges {
    TripleBuffer<SceneSnapshot>& snapshots;          ///< Every slot holds an organ for each view.
    SpscQueue<FrameRecord>* frames = nullptr;        ///< Real clock: the times of every frame.
    TripleBuffer<ViewSettings>* settings = nullptr;  ///< Of a window: what it shows, from now on.
    TripleBuffer<SessionHealth>* health = nullptr;   ///< For the text.
    SpscQueue<LoopEvent>* events = nullptr;          ///< For the log: screenshots, the loop's end.
  };

  /// Set-up, any thread; touches no OpenGL. The meshes that the views point to, and the edges, must
  /// outlive the loop. `clock` tells session time (ns), the scale of the snapshots' times. Throws
  /// InputError for options that cannot be met.
  RenderLoop(std::vector<OrganVisual> organs, std::vector<InstrumentVisual> instruments,
             const LaparoscopeOptions& scope, const RenderOptions& options, const Edges& edges,
             Clock clock, RenderContextFactory make_context = HeadlessContext);
  /// Ends on this thread when that was not done.
  ~RenderLoop();
  RenderLoop(const RenderLoop&) = delete;
  RenderLoop& operator=(const RenderLoop&) = delete;

  /// Makes the calling thread the render thread: creates the context, shaders and meshes. Throws
  /// MachineError when the machine cannot draw. A second call does nothing. A program that wants
  /// to know early whether Run will find a context makes one and drops it.
  void StartOnThisThread();

  /// The same for a session that goes on without pictures: false where drawing cannot start, and
  /// failure() says why. Run and Frame call it first.
  bool TryToStart();

  /// Draws the newest snapshot if it has not been drawn yet; true when image() is a new picture.
  /// Starts on this thread if need be (then a machine that cannot draw ends in failure()).
  bool Frame();

  /// Frame() whenever a snapshot arrives, on average at most max_hz times a second, until a stop
  /// is asked for or drawing fails. Starts and ends on the calling thread.
  void Run(std::stop_token stop);

  /// Frees everything that belongs to OpenGL. The thread that started. The pictures stay.
  void EndOnThisThread();

  /// The last picture; empty before the first.
  const Image& image() const { return image_; }
  /// The picture at the deepest contact so far: the largest displacement of an organ's vertex
  /// from rest; empty before the first frame.
  const Image& deepest_image() const { return deepest_image_; }
  double deepest_displacement() const { return deepest_displacement_; }  ///< m.

  const RenderStatistics& statistics() const { return statistics_; }
  std::uint64_t frames_written() const { return sink_ ? sink_->written() : 0; }
  std::uint64_t screenshots_written() const { return screenshots_written_; }
  const Laparoscope& scope() const { return scope_; }

  /// Why drawing ended, or else why a picture could not be written: one line. Empty while all is
  /// well.
  const std::string& failure() const;
  /// Why a picture could not be written, whether or not drawing went on: the first.
  const std::string& file_failure() const { return file_failure_; }

 private:
  struct Drawing;  // what lives on the graphics card

  void TakeSettings();
  void DrawText(const SceneSnapshot& snapshot);
  void DrawNewest(const SceneSnapshot& snapshot);
  void KeepDeepest(const SceneSnapshot& snapshot);
  void KeepFiles(Nanoseconds time_ns);
  void StopRecording(const std::string& why);
  void WriteScreenshot();
  void Report(EventSeverity severity, const char* name, const std::string& text);
  void CountDropped(std::uint64_t number);

  std::vector<OrganVisual> organs_;
  std::vector<InstrumentVisual> instruments_;
  Laparoscope scope_;
  RenderOptions options_;
  Edges edges_;
  Clock clock_;
  RenderContextFactory make_context_;
  ViewSettings settings_;
  std::vector<PointsF> rest_;  // per organ, V x 3
  // Per organ, OrganSnapshot::version and its largest displacement, m.
  std::vector<std::pair<std::optional<std::uint64_t>, double>> displacements_;
  std::unique_ptr<Drawing> drawing_;
  FrameRate frame_rate_;
  std::optional<FrameSink> sink_;
  Image image_;
  Image deepest_image_;
  double deepest_displacement_ = -1;
  std::uint64_t last_number_ = 0;
  std::uint64_t screenshots_asked_ = 0;  // and answered, if only with a failure
  std::uint64_t screenshots_written_ = 0;
  RenderStatistics statistics_;
  std::string failure_;
  std::string file_failure_;  // the first
};

}  // namespace hpdm
