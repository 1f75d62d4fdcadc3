#pragma once

#include "render/image/image.h"

namespace hpdm {

/// Pixels of the committed picture.
inline constexpr int kAbdomenWidth = 1024;
inline constexpr int kAbdomenHeight = 768;

/// What surrounds the organs in an abdomen blown up with gas, as a laparoscope near the navel sees
/// it: the diaphragm's dome above, the peritoneal wall, bowel loops and the omentum's fat below; a
/// little out of focus and evenly lit, since it is a backdrop that the scene's own light falls on.
/// The same view at any size. The same bits on every run and x86-64 machine.
Image AbdomenPicture(int width, int height);

}  // namespace hpdm
