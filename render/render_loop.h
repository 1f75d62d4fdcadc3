#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/handling_limits.h"
#include "engine/snapshots.h"
#include "engine/threads/loop_event.h"
#include "engine/threads/spsc_queue.h"
#include "engine/threads/triple_buffer.h"
#include "render/camera/laparoscope.h"
#include "render/gl/egl_context.h"
#include "render/gl/render_context.h"
#include "render/image/frame_sink.h"
#include "render/image/image_file.h"
#include "render/overlay/palette.h"
#include "render/overlay/status_text.h"
#include "render/overlay/view_settings.h"
#include "render/scene_renderer.h"

namespace hpdm {

struct RenderOptions {
  int width = 640;                            ///< px.
  int height = 480;                           ///< px.
  int samples = 0;                            ///< Samples a pixel, see PictureTarget.
  double max_hz = 30;                         ///< Maximum frames per second, in Run.
  std::filesystem::path frame_folder;         ///< PNG frames go here; empty: none are written.
  double frame_fps = 30;                      ///< Rate of the PNG frames, in session time.
  std::filesystem::path screenshot_folder;    ///< A window's screenshots; made with the first one.
  StatusNames names;                          ///< Names in the status text.
  HandlingLimits limits;                      ///< The status text has an alarm above them.
  Palette palette = Palette::kStandard;       ///< Of the status text.
  std::uint32_t overlays = kOverlayNone;      ///< Or-ed; a window's ViewSettings replace them.
  std::vector<AttachmentVisual> attachments;  ///< Layers between the organs.
  std::vector<DuctVisual> ducts;
  const Image* background = nullptr;  ///< Picture on the cavity's wall (cavity_renderer.h). Must
                                      ///< outlive the loop. Null: a bare wall.
};

/// Counts of the loop. Written by the render thread; others read it after the loop has ended.
struct RenderStatistics {
  std::uint64_t drawn = 0;    ///< Frames.
  std::uint64_t dropped = 0;  ///< Steps that a newer one replaced before they were drawn.
  std::string renderer;       ///< The OpenGL renderer; empty before the start.
};

/// Returns the depth of the deepest press in a snapshot, m; 0 if no tip presses.
///   kLattice  the contact point below the organ's released surface, along its normal;
///   kPaper    the largest displacement of the pressed organ's vertices, since the step does not
///             know the released surface.
/// `rest`: per organ, V x 3, m.
double PressDepth(const SceneSnapshot& snapshot, const std::vector<PointsF>& rest);

/// Measures frames per second over the last second. One thread.
class FrameRate {
 public:
  /// Counts a frame at session time `now`.
  void Add(Nanoseconds now);
  // Frames per second; 0 during the first second and while time is stopped.
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
/// One thread owns the OpenGL context from StartOnThisThread to EndOnThisThread. It is a thread of
/// its own that calls Run (real clock), or the session's only thread, which calls Frame after each
/// step (lockstep clock). Other threads may read the rest before the start and after the end.
///
/// Frames are dropped, never queued: after a slow frame comes the newest step. A fault after the
/// start neither throws nor stops the session: the loop ends and failure() gives the reason.
class RenderLoop {
 public:
  using Clock = std::function<Nanoseconds()>;

  /// Channels of the loop. It reads the triple buffers and writes the queues; a full queue drops
  /// and counts the item.
  struct Edges {
    TripleBuffer<SceneSnapshot>& snapshots;          ///< Every slot holds every visual's organ.
    SpscQueue<FrameRecord>* frames = nullptr;        ///< Real clock: the times of every frame.
    TripleBuffer<ViewSettings>* settings = nullptr;  ///< A window's settings.
    TripleBuffer<SessionHealth>* health = nullptr;   ///< Figures of the status text.
    SpscQueue<LoopEvent>* events = nullptr;          ///< Receives events for the log: screenshots,
                                                     ///< the loop's end.
    TripleBuffer<PictureMarks>* marks = nullptr;     ///< A teacher's marks.
  };

  /// Set-up, any thread; makes no OpenGL call. The visuals' meshes and the edges must outlive the
  /// loop. `clock` returns session time (ns), the scale of the snapshots' times. Throws InputError
  /// for impossible options.
  RenderLoop(std::vector<OrganVisual> organs, std::vector<InstrumentVisual> instruments,
             const LaparoscopeOptions& scope, const RenderOptions& options, const Edges& edges,
             Clock clock, RenderContextFactory make_context = HeadlessContext);
  /// Calls EndOnThisThread.
  ~RenderLoop();
  RenderLoop(const RenderLoop&) = delete;
  RenderLoop& operator=(const RenderLoop&) = delete;

  /// Makes the calling thread the render thread: creates the context, shaders and meshes. Throws
  /// MachineError if the machine cannot draw. A second call does nothing. To check early whether
  /// Run will find a context, create one and drop it.
  void StartOnThisThread();

  /// Starts on this thread; returns false with the reason in failure() if drawing cannot start.
  /// Run and Frame call it first.
  bool TryToStart();

  /// Draws the newest snapshot if it has not been drawn yet; true if image() is a new picture.
  /// Starts on this thread if necessary.
  bool Frame();

  /// Calls Frame() whenever a snapshot arrives, on average at most max_hz times a second, until a
  /// stop request or a failure. In a pause it draws five times a second, and at once what keys or the mouse
  /// change. Starts and ends on the calling thread.
  void Run(std::stop_token stop);

  /// Frees all OpenGL objects, on the thread that started. The pictures stay.
  void EndOnThisThread();

  /// The last picture; empty before the first.
  const Image& image() const { return image_; }
  /// The picture of the deepest press of a tip so far (PressDepth); empty before the first press.
  /// Grasps and lifts do not count.
  const Image& deepest_image() const { return deepest_image_; }
  double deepest_press() const { return deepest_press_; }  ///< m; 0 before the first press.

  const RenderStatistics& statistics() const { return statistics_; }
  std::uint64_t frames_written() const { return sink_ ? sink_->written() : 0; }
  std::uint64_t screenshots_written() const { return screenshots_written_; }
  const Laparoscope& scope() const { return scope_; }
  /// True if a hook's pedal is pressed in the newest picture. Any thread.
  bool burns() const { return burns_.load(std::memory_order_relaxed); }

  /// One line: the reason why drawing ended, or else file_failure(). Empty without a failure.
  const std::string& failure() const;
  /// The first reason why a picture could not be written; drawing may continue after it.
  const std::string& file_failure() const { return file_failure_; }

 private:
  struct Drawing;  // the objects on the graphics card

  void TakeSettings();
  StatusText TextOf(const SceneSnapshot& snapshot);
  std::optional<FreeingGuide> Guide(const SceneSnapshot& snapshot) const;
  void DrawNewest(const SceneSnapshot& snapshot);
  void KeepDeepest(const SceneSnapshot& snapshot);
  void KeepFiles(Nanoseconds time_ns);
  void StopRecording(const std::string& why);
  void WriteScreenshot(Nanoseconds time_ns);
  void Report(EventSeverity severity, const char* name, const std::string& text);
  void CountDropped(std::uint64_t number);

  std::vector<OrganVisual> organs_;
  std::vector<InstrumentVisual> instruments_;
  Laparoscope scope_;
  Laparoscope first_scope_;
  double first_angle_;  // rad, of the optics
  RenderOptions options_;
  Edges edges_;
  Clock clock_;
  RenderContextFactory make_context_;
  ViewSettings settings_, drawn_settings_;  // the newest, and those of the last picture
  std::vector<PointsF> rest_;               // per organ, V x 3
  std::unique_ptr<Drawing> drawing_;
  std::optional<FreeingGuide> guide_;  // of the newest picture
  FrameRate frame_rate_;
  std::optional<FrameSink> sink_;
  Image image_;
  Image deepest_image_;
  double deepest_press_ = 0;
  std::uint64_t last_number_ = 0;
  std::atomic<bool> burns_ = false;
  std::uint64_t screenshots_asked_ = 0;  // requests handled, with success or not
  std::uint64_t screenshots_written_ = 0;
  std::string screenshot_notice_;
  Nanoseconds notice_end_ns_ = 0;  // in the steps' time
  RenderStatistics statistics_;
  std::string failure_;
  std::string file_failure_;  // the first
};

}  // namespace hpdm
