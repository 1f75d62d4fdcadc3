#pragma once

#include "engine/mesh/surface_mesh.h"
#include "render/gl/texture.h"

namespace hpdm {

/// Returns the fine relief of a wet organ's surface as a tileable map: two octaves of periodic
/// value noise from fixed numbers, the same on every machine. Texels, linear: R, G the slope along
/// u and v; B their sum of squares; A the height.
///
/// The mipmaps average slopes and squares. The mean square minus the square of the mean is the
/// variance that the mipmaps lost. The shader adds it to the film's roughness (LEAN mapping, Olano
/// and Baker 2010, isotropic), so highlights widen with distance and do not sparkle.
Texels TissueDetail();

inline constexpr double kDetailTile = 0.064;  ///< m, side of the map on the tissue.
inline constexpr double kDetailSlope = 0.5;   ///< Slope at a texel of 255; 0 at 127.5.

/// Returns the mesh with texture coordinates. If it has none, each triangle is projected along the
/// axis nearest to its normal, in the vertices' frame; the coordinates are in metres.
SurfaceMesh WithCoordinates(const SurfaceMesh& mesh);

/// Returns metres on the surface per unit of the texture coordinates, averaged over the mesh.
/// Coordinates without area are a bug.
double MetresPerCoordinate(const SurfaceMesh& mesh);

}  // namespace hpdm
