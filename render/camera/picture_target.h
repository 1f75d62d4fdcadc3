#pragma once

#include <cstdint>
#include <vector>

#include "render/camera/lens_pass.h"
#include "render/gl/gl_object.h"
#include "render/image/image_file.h"

namespace hpdm {

class Laparoscope;

/// A rectangle of a screen, px.
struct ScreenPlace {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// Returns the place of a picture on a screen of width x height pixels (sides up to 32,767):
/// centred, with its proportions, as large as fits.
ScreenPlace FitOnScreen(int picture_width, int picture_height, int width, int height);

/// Off-screen framebuffers of a picture: one with depth, resolved into a plain one, which is shown
/// and read back. Render thread only.
///
/// Jagged edges: a graphics card draws several samples a pixel. On a software renderer those would
/// cost more than all shading (15 of 28 ms of core time at 640 x 480), so the lens pass smooths
/// edges there (lens_pass.h).
///
///     Bind, draw the scene -> Resolve, draw flat things over it -> ShowOnScreen -> Read
///
/// The read-back is plain, not through pixel buffers in flight: those would hide the copy of a
/// graphics card (about 1 MB) at the price of showing every picture one frame, 33 ms, late.
class PictureTarget {
 public:
  /// `samples` a pixel, limited to the driver's maximum; 1: smoothed edges; 0: the better choice
  /// for the renderer. Throws MachineError if the driver refuses the size.
  PictureTarget(int width, int height, int samples);

  /// Directs drawing here, over the whole picture.
  void Bind() const;

  /// Resolves the scene that `scope` sees into the plain framebuffer, with the lens's distortion.
  /// Later drawing goes there, over the whole picture, without multisampling and depth.
  void Resolve(const Laparoscope& scope) const;

  /// Copies the resolved picture into the middle of the context's own framebuffer of width x height
  /// pixels, as large as fits; the rest is black.
  void ShowOnScreen(int width, int height) const;

  /// Waits until everything is drawn and copies the resolved picture into `image`, which is resized
  /// only if its size differs.
  void Read(Image* image);

  /// Copies the depth buffer of a picture with one sample a pixel, before Resolve(): 0 at the near
  /// plane to 1 at the far one, rows from the top down.
  void ReadDepth(std::vector<float>* depth) const;

  int width() const { return width_; }
  int height() const { return height_; }

 private:
  static int UsualSamples();

  int width_;
  int height_;
  bool multisampled_;
  GlObject drawn_{GlKind::kFramebuffer};  // unused with one sample, which goes into pinhole_
  GlObject drawn_colour_{GlKind::kRenderbuffer};
  GlObject drawn_depth_{GlKind::kRenderbuffer};
  GlObject pinhole_{GlKind::kFramebuffer};  // the scene before the lens pass
  GlObject pinhole_colour_{GlKind::kTexture};
  LensPass lens_;
  GlObject resolved_{GlKind::kFramebuffer};
  GlObject resolved_colour_{GlKind::kRenderbuffer};
  std::vector<std::uint8_t> rgba_;  // 4 width height bytes, rows from the bottom up
};

}  // namespace hpdm
