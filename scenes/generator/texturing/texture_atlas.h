#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Texels on a side of the textures that an atlas is laid out for.
inline constexpr int kTextureSize = 512;
/// Texels around each chart that no other chart uses: enough for bilinear lookups down to the
/// second mip level.
inline constexpr int kTextureGutter = 3;

/// Returns texture coordinates (3F x 2) in which no two triangles overlap in the unit square. The
/// same bits on every x86-64 machine.
///
///   charts   texture_charts.h, all at one scale in texels per metre, the largest that fits
///   layout   each chart in turn at the lowest free place (the horizon of Levy, Petitjean, Ray and
///            Maillot 2002, "Least squares conformal maps for automatic texture atlas generation")
///   cavity   triangles from number `first_hidden` have a quarter of that scale
TextureCoordinates MakeTextureAtlas(const SurfaceMesh& mesh, Eigen::Index first_hidden);

}  // namespace hpdm
