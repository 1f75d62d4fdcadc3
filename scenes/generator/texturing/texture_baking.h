#pragma once

#include <functional>

#include "engine/mesh/surface_mesh.h"
#include "render/image/image.h"

namespace hpdm {

/// A surface's colour at a point of it (m, the mesh's frame): sRGB, each component 0..1.
using SurfaceColour = std::function<Vector3d(const Vector3d& p)>;

/// The texture of a mesh with texture coordinates: `size` x `size` pixels. Each texel takes the
/// mean colour of four points of the surface that it lies on. Texels beside a chart continue the
/// surface by up to one texel, so that no border shows, and what is left over takes the colours
/// around it, so that no lookup meets a background. As reproducible as `colour`.
Image BakeTexture(const SurfaceMesh& mesh, int size, const SurfaceColour& colour);

}  // namespace hpdm
