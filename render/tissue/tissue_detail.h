#pragma once

#include "engine/mesh/surface_mesh.h"
#include "render/gl/texture.h"

namespace hpdm {

/// The fine relief of a wet organ's surface as a tileable map: two octaves of periodic value noise,
/// made from fixed numbers, so the same on every machine. Texels, linear: R, G the slope along u
/// and v; B their sum of squares; A the height.
///
/// Slopes and squares are averaged by the mipmaps, and the mean square exceeds the square of the
/// mean by what the mips lost: the shader adds it to the film's roughness (LEAN mapping, Olano and
/// Baker 2010, isotropic), so highlights widen with distance and do not sparkle.
Texels TissueDetail();

inline constexpr double kDetailTile = 0.064;  ///< m, side of the map on the tissue.
inline constexpr double kDetailSlope = 0.5;   ///< Slope at a texel of 255; 0 at 127.5.

/// The mesh with coordinates in metres where it has none: each triangle is projected along the axis
/// that its normal is nearest to. The frame is the vertices' own.
SurfaceMesh WithCoordinates(const SurfaceMesh& mesh);

/// Metres on the surface to one unit of the texture coordinates, averaged over the mesh. A mesh
/// whose coordinates cover no area is a bug.
double MetresPerCoordinate(const SurfaceMesh& mesh);

namespace glsl {
/// DetailAt() looks the map up, Raised() turns a normal by its slope; for fragment stages. Declares
/// the sampler `tissue_detail`.
extern const char* const kTissueDetail;
}  // namespace glsl

}  // namespace hpdm
