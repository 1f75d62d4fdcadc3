#pragma once

#include <cstdint>
#include <vector>

#include "render/gl_object.h"
#include "render/image_file.h"

namespace hpdm {

/// Where a picture is drawn off screen: a multisampled framebuffer with depth, resolved into a
/// plain one and read back. Render thread only.
///
/// The read-back is plain, not through pixel buffers in flight: those would hide the copy of a
/// graphics card (about 1 MB) at the price of showing every picture one frame, 33 ms, late.
class PictureTarget {
 public:
  /// `samples` a pixel, at most what the driver offers; 1 is none. Throws MachineError when the
  /// driver refuses the size.
  PictureTarget(int width, int height, int samples);

  /// Directs drawing here, over the whole picture.
  void Bind() const;

  /// Waits until everything is drawn and copies it into `image`, resized only when it differs.
  void Read(Image* image);

 private:
  int width_;
  int height_;
  GlObject drawn_{GlKind::kFramebuffer};
  GlObject drawn_colour_{GlKind::kRenderbuffer};
  GlObject drawn_depth_{GlKind::kRenderbuffer};
  GlObject resolved_{GlKind::kFramebuffer};
  GlObject resolved_colour_{GlKind::kRenderbuffer};
  std::vector<std::uint8_t> rgba_;  // 4 width height bytes, rows from the bottom up
};

}  // namespace hpdm
