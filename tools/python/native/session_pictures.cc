#include "tools/python/native/session_pictures.h"

#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "engine/base/error.h"
#include "render/camera/picture_target.h"
#include "render/gl/egl_context.h"
#include "render/scene_renderer.h"

namespace hpdm {
namespace {

constexpr int kOneSample = 1;  // depth has one value a pixel
// Two steps of a depth buffer of 24 bits.
constexpr float kSameDepth = 2.5e-7f;

// Returns the distance along the viewing axis of a value of the depth buffer, m.
float Metres(float depth) {
  if (depth <= 0 || depth >= 1) return std::numeric_limits<float>::infinity();
  const double n = Laparoscope::kNear, f = Laparoscope::kFar;
  return static_cast<float>(2 * f * n / (f + n - (2.0 * depth - 1) * (f - n)));
}

}  // namespace

struct SessionPictures::Drawing {
  explicit Drawing(const SessionModel& model)
      : view(model.OrganVisuals(), model.InstrumentVisuals(), model.Background(), {},
             model.AttachmentVisuals(), model.DuctVisuals()) {}

  PictureTarget& TargetOf(int width, int height) {
    return targets.try_emplace({width, height}, width, height, kOneSample).first->second;
  }

  EglContext context;  // first: the others need it
  SceneRenderer view;
  std::map<std::pair<int, int>, PictureTarget> targets;
  std::vector<float> depth, organ_depth;
};

SessionPictures::SessionPictures(std::shared_ptr<const SessionModel> model)
    : model_(std::move(model)),
      scene_(SizedSnapshot(model_->organs(), static_cast<int>(model_->scene().instruments.size()),
                           true, model_->beds(), model_->ducts())),
      thread_([this] { Run(); }) {
  try {
    Do([this] { drawing_ = std::make_unique<Drawing>(*model_); });
  } catch (...) {
    {
      const std::lock_guard lock(mutex_);
      stops_ = true;
    }
    changed_.notify_all();
    thread_.join();
    throw;
  }
}

SessionPictures::~SessionPictures() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void SessionPictures::Run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stops_ || work_ != nullptr; });
    if (stops_) break;
    try {
      (*work_)();
    } catch (...) {
      failure_ = std::current_exception();
    }
    work_ = nullptr;
    done_ = true;
    changed_.notify_all();
  }
  drawing_.reset();
}

// Has the thread do the work and waits for it.
void SessionPictures::Do(const std::function<void()>& work) {
  std::unique_lock lock(mutex_);
  failure_ = nullptr;
  done_ = false;
  work_ = &work;
  changed_.notify_all();
  changed_.wait(lock, [this] { return done_; });
  if (failure_ != nullptr) std::rethrow_exception(failure_);
}

void SessionPictures::Draw(const LockstepSession& session, const PictureWish& wish,
                           SessionPicture* picture) {
  const std::lock_guard lock(call_);
  const Laparoscope scope(model_->scene().laparoscope, wish.width, wish.height);
  // Versions of several sessions are not comparable: every shape counts as new.
  for (OrganSnapshot& organ : scene_.organs) {
    organ.version = std::numeric_limits<std::uint64_t>::max();
  }
  session.Show(&scene_);
  ++version_;
  for (OrganSnapshot& organ : scene_.organs) organ.version = version_;
  Do([&] { DrawHere(scope, wish, picture); });
}

void SessionPictures::DrawHere(const Laparoscope& scope, const PictureWish& wish,
                               SessionPicture* picture) {
  Drawing& drawing = *drawing_;
  PictureTarget& target = drawing.TargetOf(wish.width, wish.height);
  target.Bind();
  drawing.view.Draw(scene_, scope);
  if (wish.depth || wish.organs) target.ReadDepth(&drawing.depth);
  if (wish.depth) {
    picture->depth.resize(drawing.depth.size());
    for (std::size_t i = 0; i < drawing.depth.size(); ++i) {
      picture->depth[i] = Metres(drawing.depth[i]);
    }
  }
  target.Resolve(scope);
  target.Read(&picture->image);
  if (wish.organs) {
    picture->organs.assign(drawing.depth.size(), -1);
    for (std::size_t o = 0; o < model_->organs().size(); ++o) {
      target.Bind();
      drawing.view.DrawDepthOf(o);
      target.ReadDepth(&drawing.organ_depth);
      for (std::size_t i = 0; i < drawing.depth.size(); ++i) {
        const float depth = drawing.organ_depth[i];
        if (depth < 1 && std::abs(depth - drawing.depth[i]) <= kSameDepth) {
          picture->organs[i] = static_cast<std::int32_t>(o);
        }
      }
    }
  }
  const std::string failure = drawing.context.Failure();
  if (!failure.empty()) throw MachineError("drawing failed: " + failure);
}

}  // namespace hpdm
