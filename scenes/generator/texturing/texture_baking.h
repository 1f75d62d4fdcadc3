#pragma once

#include <functional>

#include "engine/mesh/surface_mesh.h"
#include "render/image/image.h"

namespace hpdm {

/// A surface's colour at a point of it (m, the mesh's frame): sRGB, each component 0..1.
using SurfaceColour = std::function<Vector3d(const Vector3d& p)>;

/// Returns the texture of a mesh with texture coordinates: `size` x `size` pixels. A texel is the
/// mean colour of four points of its surface. Texels beside a chart extend the surface by up to one
/// texel, so that no border shows. The rest takes surrounding colours, so that no lookup meets a
/// background. As reproducible as `colour`.
Image BakeTexture(const SurfaceMesh& mesh, int size, const SurfaceColour& colour);

}  // namespace hpdm
