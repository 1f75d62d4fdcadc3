#pragma once

#include <Eigen/Core>
#include <vector>

#include "render/overlay/glyph_atlas.h"
#include "render/overlay/palette.h"
#include "render/overlay/status_text.h"

namespace hpdm {

/// A rectangle of the picture (px, y down) to fill from one of the atlas (px), in one sRGB colour
/// (red, green, blue, opacity).
struct TextQuad {
  int x = 0, y = 0, width = 0, height = 0;
  int atlas_x = 0, atlas_y = 0, atlas_width = 0, atlas_height = 0;
  Eigen::Vector4f colour = Eigen::Vector4f::Ones();
};

/// Returns the text's size (px) on a picture of width x height pixels: a line of 34 characters fits
/// beside the circle's top at 4 : 3.
int TextPixels(int width, int height);

/// Lays the text out on a picture of width x height pixels, back to front: its blocks in the
/// corners, the banner on a dark panel over the middle. Characters that would cross the picture's
/// edge are omitted, rectangles are cut.
std::vector<TextQuad> LayOut(const StatusText& text, const GlyphAtlas& atlas, int width, int height,
                             Palette palette = Palette::kStandard);

}  // namespace hpdm
