#pragma once

#include "scenes/generator/shapes/implicit_shapes.h"
#include "scenes/generator/texturing/texture_baking.h"

/// The organs' colours as functions of the point in their own frame (implicit_shapes.h), so that
/// every mesh of an organ has the same colours at the same place. The shader adds the wet sheen.
/// The same bits on every x86-64 machine.
namespace hpdm {

/// Returns `a` at t = 0, `b` at 1.
inline Vector3d Mix(const Vector3d& a, const Vector3d& b, double t) { return a + (b - a) * t; }

/// Fat: yellow lobules a few millimetres wide that run softly into each other.
Vector3d FatColour(const Vector3d& p);

/// Dark reddish brown with a fine speckle of lobules, paler where the border is thin, a few faint
/// vessels in the capsule.
SurfaceColour LiverColour();

/// Pale pink serosa with branching vessels from both curvatures and fat along them.
SurfaceColour StomachColour();

/// Grey-green to blue with fine vessels and some fat at the neck.
SurfaceColour GallbladderColour();

/// The same for another gallbladder. `neck`: the middle of its neck, m, in the shape's frame.
SurfaceColour GallbladderColour(const ImplicitShape& shape, const Vector3d& neck);

/// Walls with fine vessels: yellow-green (a bile duct), red (an artery), tan (a lymph node).
SurfaceColour DuctColour();
SurfaceColour ArteryColour();
SurfaceColour NodeColour();

}  // namespace hpdm
