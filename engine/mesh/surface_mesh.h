#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// A triangle surface. It is closed and faces outwards if it bounds an organ's tissue; the type
/// does not enforce that (mesh_facts.h measures it).
struct SurfaceMesh {
  Points vertices;      ///< V x 3, m.
  Triangles triangles;  ///< F x 3.
  /// 3F x 2, or 0 x 2 without a texture. Row 3t + c belongs to corner c of triangle t, so a texture
  /// may have seams where the surface has none. (0, 0) is the picture's lower left corner, (1, 1)
  /// its upper right one.
  TextureCoordinates texture_coordinates;
};

/// Returns the normal of triangle t; its length is twice the triangle's area.
inline Vector3d TwiceAreaNormal(const Points& vertices, const Triangles& triangles,
                                Eigen::Index t) {
  const Vector3d a = vertices.row(triangles(t, 0));
  const Vector3d b = vertices.row(triangles(t, 1));
  const Vector3d c = vertices.row(triangles(t, 2));
  return (b - a).cross(c - a);
}

/// Computes the unit normals of the vertices, V x 3: the area-weighted mean of the normals of the
/// triangles around each one. A vertex without area gets a zero row. `normals` is resized only if
/// its size differs, so a caller that keeps it allocates nothing.
void VertexNormals(const Points& vertices, const Triangles& triangles, Points* normals);

/// Returns the volume (m^3) enclosed by a closed surface (divergence theorem); negative if the
/// surface faces inwards.
double EnclosedVolume(const Points& vertices, const Triangles& triangles);

/// Returns the centroid (m) of the enclosed volume, which must not be zero.
Vector3d EnclosedCentre(const Points& vertices, const Triangles& triangles);

}  // namespace hpdm
