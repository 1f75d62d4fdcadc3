#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Texels on a side of the textures that an atlas is laid out for.
inline constexpr int kTextureSize = 512;
/// Texels around each chart that belong to it alone: enough for bilinear lookups down to the second
/// mip level.
inline constexpr int kTextureGutter = 3;

/// Texture coordinates (3F x 2) that show every part of a surface at a place of its own in the unit
/// square: charts (texture_charts.h), all at one scale in texels a metre, laid out one after the
/// other on the lowest place that each finds (the horizon of Levy, Petitjean, Ray and Maillot
/// 2002, "Least squares conformal maps for automatic texture atlas generation"), at the largest
/// scale at which they fit. Triangles from `first_hidden` on, a cavity's, get a quarter of that
/// scale. The same bits on every x86-64 machine.
TextureCoordinates MakeTextureAtlas(const SurfaceMesh& mesh, Eigen::Index first_hidden);

}  // namespace hpdm
