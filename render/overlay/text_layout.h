#pragma once

#include <Eigen/Core>
#include <vector>

#include "render/overlay/glyph_atlas.h"
#include "render/overlay/status_text.h"

namespace hpdm {

/// A rectangle to draw: of the picture (px, y down) from one of the atlas (px), in one colour (red,
/// green, blue, opacity, as on a screen).
struct TextQuad {
  int x = 0, y = 0, width = 0, height = 0;
  int atlas_x = 0, atlas_y = 0, atlas_width = 0, atlas_height = 0;
  Eigen::Vector4f colour = Eigen::Vector4f::Ones();
};

/// Size of the text (px) on a picture of width x height pixels: a line of 34 characters fits beside
/// the circle's top at 4 : 3.
int TextPixels(int width, int height);

/// Where the text goes on a picture of width x height pixels: its blocks in the corners, longest
/// lines outermost where a block's order lets them, so that the circle in the middle stays free;
/// the banner on a dark panel over the middle. Back to front. Text that would leave the picture is
/// cut at its edge.
std::vector<TextQuad> LayOut(const StatusText& text, const GlyphAtlas& atlas, int width,
                             int height);

}  // namespace hpdm
