#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "engine/snapshots.h"
#include "render/camera/laparoscope.h"
#include "render/image/image.h"
#include "tools/session/lockstep_session.h"

namespace hpdm {

/// What a picture shall hold besides colours.
struct PictureWish {
  int width = 640;
  int height = 480;
  bool depth = false;
  bool organs = false;
};

struct SessionPicture {
  Image image;
  std::vector<float> depth;  ///< m along the viewing axis, rows from the top; infinite where
                             ///< nothing is drawn and outside the circle.
  std::vector<std::int32_t> organs;  ///< Index of the organ of each pixel, -1: none.
};

/// Draws the sessions of one model through the scene's laparoscope. A thread of its own owns the
/// OpenGL context, so any thread may ask, one at a time.
class SessionPictures {
 public:
  /// Throws MachineError if the machine cannot draw.
  explicit SessionPictures(std::shared_ptr<const SessionModel> model);
  ~SessionPictures();
  SessionPictures(const SessionPictures&) = delete;
  SessionPictures& operator=(const SessionPictures&) = delete;

  /// Draws the session, which is of the model or of one with other stiffnesses. Throws InputError
  /// for an impossible size and MachineError if drawing fails.
  void Draw(const LockstepSession& session, const PictureWish& wish, SessionPicture* picture);

 private:
  struct Drawing;
  void Do(const std::function<void()>& work);
  void Run();
  void DrawHere(const Laparoscope& scope, const PictureWish& wish, SessionPicture* picture);

  std::shared_ptr<const SessionModel> model_;
  SceneSnapshot scene_;
  std::uint64_t version_ = 0;         // of the newest shape on the card
  std::unique_ptr<Drawing> drawing_;  // the thread's

  std::mutex call_;  // one caller at a time
  std::mutex mutex_;
  std::condition_variable changed_;
  const std::function<void()>* work_ = nullptr;
  bool done_ = false;
  bool stops_ = false;
  std::exception_ptr failure_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace hpdm
