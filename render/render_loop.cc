#include "render/render_loop.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <system_error>
#include <thread>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/error.h"
#include "render/camera/picture_target.h"
#include "render/gl/egl_context.h"
#include "render/overlay/exercise_text.h"
#include "render/overlay/text_renderer.h"

namespace hpdm {
namespace {

// A triple buffer cannot wake its reader. Polling twice a millisecond adds a quarter of a
// millisecond to a picture's age and costs about 1 % of a core.
constexpr std::chrono::microseconds kPollPeriod(500);
constexpr Nanoseconds kPausedPeriod = kNanosecondsPerSecond / 5;
constexpr Nanoseconds kNoticeTime = 3 * kNanosecondsPerSecond;

double LargestDisplacement(const OrganSnapshot& organ, const PointsF& rest) {
  HPDM_CHECK(organ.vertices.rows() == rest.rows());
  float largest2 = 0;
  for (Eigen::Index v = 0; v < rest.rows(); ++v) {
    // std::max keeps its first argument when the second is not a number.
    largest2 = std::max(largest2, (organ.vertices.row(v) - rest.row(v)).squaredNorm());
  }
  return std::sqrt(static_cast<double>(largest2));
}

// Returns by how much the viewing axis has turned about the present shaft, rad. Axes along their shaft
// have not turned.
double OpticsTurn(const Laparoscope& before, const Laparoscope& now) {
  const Vector3d &shaft_W = now.ShaftAxis_W(), old_shaft_W = before.ShaftAxis_W();
  // The first axis, carried along with the shaft.
  const Vector3d carried_W =
      Eigen::Quaterniond::FromTwoVectors(old_shaft_W, shaft_W) * before.ViewingAxis_W();
  const Vector3d from_W = carried_W - carried_W.dot(shaft_W) * shaft_W;
  const Vector3d to_W = now.ViewingAxis_W() - now.ViewingAxis_W().dot(shaft_W) * shaft_W;
  constexpr double kAlong = 1e-3;
  if (from_W.norm() < kAlong || to_W.norm() < kAlong) return 0;
  return std::atan2(from_W.cross(to_W).dot(shaft_W), from_W.dot(to_W));
}

}  // namespace

double PressDepth(const SceneSnapshot& snapshot, const std::vector<PointsF>& rest) {
  double deepest = 0;
  for (int t = 0; t < snapshot.tool_count; ++t) {
    const SolvedContact& contact = snapshot.contacts[t];
    if (contact.kind != ContactKind::kPress || contact.organ < 0) continue;
    const auto organ = static_cast<std::size_t>(contact.organ);
    const double depth = contact.reaction == ReactionType::kLattice
                             ? contact.normal_W.dot(contact.p_original_W - contact.contact_W)
                             : LargestDisplacement(snapshot.organs[organ], rest[organ]);
    deepest = std::max(deepest, depth);
  }
  return deepest;
}

struct RenderLoop::Drawing {
  explicit Drawing(const RenderLoop& loop)
      : context(loop.make_context_()),
        target(loop.scope_.width(), loop.scope_.height(), loop.options_.samples),
        view(loop.organs_, loop.instruments_, loop.options_.background, {},
             loop.options_.attachments, loop.options_.ducts) {}

  std::unique_ptr<RenderContext> context;  // first: the others need it
  PictureTarget target;
  SceneRenderer view;
  TextRenderer text;
};

void FrameRate::Add(Nanoseconds now) {
  if (frames_++ == 0) begin_ = now;
  if (now - begin_ < kNanosecondsPerSecond) return;
  hz_ = (frames_ - 1) / ToSeconds(now - begin_);
  begin_ = now;
  frames_ = 1;
}

RenderLoop::RenderLoop(std::vector<OrganVisual> organs, std::vector<InstrumentVisual> instruments,
                       const LaparoscopeOptions& scope, const RenderOptions& options,
                       const Edges& edges, Clock clock, RenderContextFactory make_context)
    : organs_(std::move(organs)),
      instruments_(std::move(instruments)),
      scope_(scope, options.width, options.height),
      first_scope_(scope_),
      first_angle_(scope.angle),
      options_(options),
      edges_(edges),
      clock_(std::move(clock)),
      make_context_(std::move(make_context)) {
  if (!(options_.max_hz > 0)) {
    throw InputError("timing: render_hz = " + std::to_string(options_.max_hz) +
                     " draws nothing; give more than 0");
  }
  settings_.scope = scope;
  settings_.overlays = options.overlays;
  settings_.recording = !options_.frame_folder.empty();
  // In a window the user starts the recording.
  if (settings_.recording && edges_.settings == nullptr) {
    sink_.emplace(options_.frame_folder, options_.frame_fps);
  }
  for (const OrganVisual& organ : organs_) rest_.push_back(organ.rest->vertices.cast<float>());
}

RenderLoop::~RenderLoop() { EndOnThisThread(); }

void RenderLoop::StartOnThisThread() {
  if (drawing_) return;
  drawing_ = std::make_unique<Drawing>(*this);
  statistics_.renderer = drawing_->context->renderer();
  // Drivers finish their shaders at the first use, in up to a quarter of a second. Drawing the
  // buffer's initial value takes that time here instead of in the first frame.
  Image unused;
  drawing_->target.Bind();
  drawing_->view.Draw(edges_.snapshots.Front(), scope_);
  drawing_->target.Resolve(scope_);
  drawing_->target.Read(&unused);
}

bool RenderLoop::TryToStart() {
  if (!failure_.empty()) return false;
  try {
    StartOnThisThread();
  } catch (const MachineError& error) {
    failure_ = error.what();
  }
  return failure_.empty();
}

void RenderLoop::EndOnThisThread() {
  if (!drawing_) return;
  // Deleting OpenGL objects without a current context would crash, so they are leaked.
  if (!drawing_->context->MakeCurrent()) static_cast<void>(drawing_.release());
  drawing_.reset();
}

const std::string& RenderLoop::failure() const {
  return failure_.empty() ? file_failure_ : failure_;
}

bool RenderLoop::Frame() {
  if (!failure_.empty()) return false;
  if (!edges_.snapshots.Update()) return false;
  if (!TryToStart()) return false;
  TakeSettings();
  if (!failure_.empty()) return false;
  const SceneSnapshot& snapshot = edges_.snapshots.Front();
  const Nanoseconds start_ns = clock_();
  frame_rate_.Add(start_ns);
  try {
    DrawNewest(snapshot);
  } catch (const MachineError& error) {
    failure_ = error.what();
  }
  if (!failure_.empty()) return false;
  const Nanoseconds read_ns = clock_();
  CountDropped(snapshot.step.number);
  KeepDeepest(snapshot);
  KeepFiles(snapshot.step.time_ns);
  ++statistics_.drawn;
  if (edges_.frames != nullptr) {
    edges_.frames->Push({.time_ns = read_ns,
                         .device_time_ns = snapshot.step.device_time_ns,
                         .compute_ns = clock_() - start_ns});
  }
  return true;
}

void RenderLoop::TakeSettings() {
  if (edges_.settings == nullptr || !edges_.settings->Update()) return;
  settings_ = edges_.settings->Front();
  // A window that is minimised or still opening keeps the last size.
  const bool has_size = settings_.window_width >= Laparoscope::kMinSide &&
                        settings_.window_height >= Laparoscope::kMinSide;
  const int width = has_size ? settings_.window_width : scope_.width();
  const int height = has_size ? settings_.window_height : scope_.height();
  try {
    scope_ = Laparoscope(settings_.scope, width, height);
  } catch (const InputError&) {
    return;  // an impossible view: keep the last one
  }
  if (drawing_->target.width() != width || drawing_->target.height() != height) {
    try {
      drawing_->target = PictureTarget(width, height, options_.samples);
    } catch (const MachineError& error) {  // the driver refuses a picture of the window's size
      failure_ = error.what();
    }
  }
}

StatusText RenderLoop::TextOf(const SceneSnapshot& snapshot) {
  static const SessionHealth kUnknown;
  if (edges_.health != nullptr) edges_.health->Update();
  const SessionHealth& health = edges_.health != nullptr ? edges_.health->Front() : kUnknown;
  double error_scale = 0;
  for (const OrganVisual& organ : organs_) {
    if (organ.reference != nullptr) error_scale = std::max(error_scale, organ.error_scale);
  }
  ViewSettings shown = settings_;
  // Without a window nobody needs to know, and the words would stay in the film.
  shown.recording &= !options_.frame_folder.empty() && edges_.settings != nullptr;
  if (edges_.marks != nullptr) edges_.marks->Update();
  if (snapshot.step.time_ns > notice_end_ns_) screenshot_notice_.clear();
  Status status{shown,
                health,
                snapshot,
                frame_rate_.hz(),
                error_scale,
                options_.limits,
                scope_.X_WC(),
                screenshot_notice_,
                edges_.marks != nullptr ? &edges_.marks->Front() : nullptr};
  status.aspect = static_cast<double>(scope_.width()) / scope_.height();
  for (std::size_t t = 0; t < ToSize(snapshot.tool_count); ++t) {
    const Vector3d p = scope_.Project(snapshot.tools[t].X_WT.translation());
    status.outside[t] = true;
    if (!p.allFinite() || p.z() <= 0) continue;
    status.tips[t] = Eigen::Vector2d(p.x() / scope_.width(), p.y() / scope_.height());
    const Eigen::Vector2d from_middle =
        p.head<2>() - 0.5 * Eigen::Vector2d(scope_.width(), scope_.height());
    status.outside[t] = from_middle.norm() > scope_.circle_radius_px();
  }
  if (guide_) {
    status.to_free = guide_->attachments;
    status.nearest_to_free = guide_->nearest;
    status.tautness = guide_->tautness;
  }
  status.optics_turn = OpticsTurn(first_scope_, scope_);
  status.optics_changed = settings_.scope.angle - first_angle_;
  return MakeStatusText(status, options_.names);
}

// With the text overlay only: recorded pictures without it stay clean.
std::optional<FreeingGuide> RenderLoop::Guide(const SceneSnapshot& snapshot) const {
  const StatusNames& names = options_.names;
  const bool wanted = settings_.guidance && (settings_.overlays & kOverlayText) != 0;
  if (!wanted || edges_.health == nullptr) return std::nullopt;
  const ExerciseStatus& status = edges_.health->Front().exercise;
  const ExerciseStepOptions* present = PresentStep(status, names);
  if (status.ended || present == nullptr || present->frees.empty()) return std::nullopt;
  FreeingGuide guide{present->frees, ColourOf(Tone::kGood, options_.palette).head<3>()};
  for (std::size_t t = 0; t < ToSize(snapshot.tool_count) && t < names.frees_layers.size(); ++t) {
    const ToolPose& pose = snapshot.tools[t];
    const auto instrument = ToSize(pose.instrument_index);
    const std::vector<bool>& can_free = names.frees_layers[t];
    if (instrument < can_free.size() && can_free[instrument]) {
      guide.tips_W[t] = pose.X_WT.translation();
    }
  }
  return guide;
}

// Throws MachineError if the text cannot be drawn in a new size.
void RenderLoop::DrawNewest(const SceneSnapshot& snapshot) {
  burns_.store(std::ranges::find(snapshot.burns, true) != snapshot.burns.end(),
               std::memory_order_relaxed);
  std::string reason = drawing_->context->Failure();
  if (reason.empty()) {
    drawing_->target.Bind();
    drawn_settings_ = settings_;
    guide_ = Guide(snapshot);
    drawing_->view.Draw(snapshot, scope_, settings_.overlays, guide_ ? &*guide_ : nullptr);
    drawing_->target.Resolve(scope_);
    drawing_->view.DrawScales(settings_.overlays);
    // Without the text overlay the notices are for the screen alone, so that recorded pictures stay
    // clean. Else the read-back comes last, because the user waits for the picture and files do
    // not.
    const bool clean = (settings_.overlays & kOverlayText) == 0;
    if (clean) drawing_->target.Read(&image_);
    drawing_->text.Draw(TextOf(snapshot), scope_.width(), scope_.height(), options_.palette);
    drawing_->context->Present(drawing_->target, settings_.window_width, settings_.window_height);
    if (!clean) drawing_->target.Read(&image_);
    reason = drawing_->context->Failure();
  }
  if (!reason.empty()) {
    failure_ = "rendering ended: " + reason + "; the session continues without pictures";
  }
}

void RenderLoop::CountDropped(std::uint64_t number) {
  if (number > last_number_ + 1) statistics_.dropped += number - last_number_ - 1;
  last_number_ = number;
}

void RenderLoop::KeepDeepest(const SceneSnapshot& snapshot) {
  const double depth = PressDepth(snapshot, rest_);
  if (depth <= deepest_press_) return;
  deepest_press_ = depth;
  deepest_image_ = image_;
}

void RenderLoop::KeepFiles(Nanoseconds time_ns) {
  if (settings_.recording && !options_.frame_folder.empty()) {
    try {
      if (!sink_) sink_.emplace(options_.frame_folder, options_.frame_fps);
      sink_->Add(image_, time_ns);
      if (!sink_->failure().empty()) StopRecording(sink_->failure());
    } catch (const InputError& error) {
      StopRecording(error.what());
    }
  } else if (sink_) {
    sink_->Break();
  }
  if (settings_.screenshots > screenshots_asked_) WriteScreenshot(time_ns);
  screenshots_asked_ = settings_.screenshots;
}

void RenderLoop::StopRecording(const std::string& why) {
  options_.frame_folder.clear();
  file_failure_ = why;
  Report(EventSeverity::kWarning, "render.recording", why);
}

// Writes one file for any number of key presses since the last picture.
void RenderLoop::WriteScreenshot(Nanoseconds time_ns) {
  notice_end_ns_ = time_ns + kNoticeTime;
  std::error_code error;
  // Creates this folder only if its parent exists. A session folder that was renamed must not
  // appear again under its old name.
  std::filesystem::create_directory(options_.screenshot_folder, error);
  char name[40];
  std::snprintf(name, sizeof name, "screenshot_%04llu.png",
                static_cast<unsigned long long>(screenshots_written_ + 1));
  std::vector<std::uint8_t> bytes;
  EncodePng(image_, &bytes);
  std::string failure;
  // Renames the file once it is complete, so a partial picture never has the final name.
  const std::filesystem::path part = options_.screenshot_folder / "screenshot.part";
  if (WriteBytes(part, bytes, &failure)) {
    std::filesystem::rename(part, options_.screenshot_folder / name, error);
    ++screenshots_written_;
    screenshot_notice_ = std::string("saved ") + name;
    Report(EventSeverity::kInfo, "render.screenshot", name);
  } else {
    screenshot_notice_ = "screenshot not saved";
    if (!file_failure_.empty()) return;
    file_failure_ = failure;
    Report(EventSeverity::kWarning, "render.not_written", failure);
  }
}

void RenderLoop::Run(std::stop_token stop) {
  if (!TryToStart()) {
    Report(EventSeverity::kWarning, "render.ended", failure_);
    return;
  }
  // A frame may start up to half a period before its place in an even sequence. So steps that
  // arrive at max_hz with jitter are drawn immediately, while the mean rate stays within max_hz.
  const auto period_ns =
      static_cast<Nanoseconds>(static_cast<double>(kNanosecondsPerSecond) / options_.max_hz);
  Nanoseconds earliest_ns = clock_();
  while (!stop.stop_requested() && failure_.empty()) {
    const Nanoseconds now_ns = clock_();
    TakeSettings();
    // In a pause only what keys and the mouse ask for is drawn at once.
    const bool rests = settings_.paused && settings_ == drawn_settings_;
    const Nanoseconds rest_ns = rests ? std::max(kPausedPeriod - period_ns, Nanoseconds{0}) : 0;
    if (now_ns >= earliest_ns + rest_ns && Frame()) {
      earliest_ns = std::max(earliest_ns + period_ns, now_ns + period_ns / 2);
    } else {
      std::this_thread::sleep_for(kPollPeriod);
    }
  }
  if (!failure_.empty()) Report(EventSeverity::kWarning, "render.ended", failure_);
  EndOnThisThread();
}

void RenderLoop::Report(EventSeverity severity, const char* name, const std::string& text) {
  if (edges_.events != nullptr) edges_.events->Push(MakeLoopEvent(severity, name, text));
}

}  // namespace hpdm
