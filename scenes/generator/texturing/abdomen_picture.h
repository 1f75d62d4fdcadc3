#pragma once

#include "render/image/image.h"

namespace hpdm {

/// Pixels of the committed picture.
inline constexpr int kAbdomenWidth = 1024;
inline constexpr int kAbdomenHeight = 768;

/// Draws the surroundings of the organs in an insufflated abdomen, as a laparoscope near the navel
/// sees them: the diaphragm's dome above, the peritoneal wall, bowel loops and the omentum's fat
/// below. It is slightly out of focus and evenly lit, because the scene's own light falls on it.
/// The same view at any size; the same bits on every run and x86-64 machine.
Image AbdomenPicture(int width, int height);

}  // namespace hpdm
