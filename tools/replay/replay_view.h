#pragma once

#include <string>
#include <vector>

#include "engine/snapshots.h"
#include "render/camera/laparoscope_options.h"
#include "render/render_loop.h"
#include "tools/replay/log_replay.h"
#include "tools/session/session.h"

namespace hpdm {

/// How a replayed session is shown.
struct ReplayViewOptions {
  std::string view = "laparoscope";
  std::string size = "640x480";
  std::vector<std::string> overlays;  ///< Words of OverlayNames(), except "error".
};

/// Returns the camera of a value of --view. Throws InputError for any other value, and for a
/// position at the target.
///
///     laparoscope            the scene's
///     front, behind          all organs, seen along the world's y axis, from -y or +y
///     left, right            along x, from -x or +x
///     below, above           along z, from -z or +z
///     X,Y,Z,X,Y,Z            a position and the point in the picture's middle, m; the field of view
///                            of the scene's laparoscope
LaparoscopeOptions ParseView(const std::string& view, const Session& session);

/// Draws the steps of a replay. One thread.
class PictureViewer : public ReplayViewer {
 public:
  /// `settings`: a window's, or null. Set-up; nothing is drawn yet. The session must outlive this.
  PictureViewer(const LaparoscopeOptions& camera, const RenderOptions& options,
                TripleBuffer<ViewSettings>* settings, RenderContextFactory make_context,
                Session* session);

  /// Passes the tick's forces on to the text in the picture.
  void OnTick(const HapticSample& replayed) override;

 protected:
  /// Draws the newest step if it is not drawn yet. Throws MachineError if drawing fails, InputError
  /// if a frame cannot be written.
  void Draw();
  /// Draws the newest step, drawn or not, for a window whose view has changed.
  void DrawAgain();

  Session& session_;
  RenderLoop render_;

 private:
  SessionHealth health_;
};

}  // namespace hpdm
