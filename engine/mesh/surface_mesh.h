#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// A triangle surface. Closed and oriented outwards when it bounds an organ's tissue; nothing in
/// the type enforces that (mesh_facts.h tells).
struct SurfaceMesh {
  Points vertices;      ///< V x 3, m.
  Triangles triangles;  ///< F x 3.
  /// 3F x 2: row 3t + c belongs to corner c of triangle t, so that a texture may have seams where
  /// the surface has none. (0, 0) is the picture's lower left corner, (1, 1) its upper right one. 0
  /// x 2 when the mesh has none.
  TextureCoordinates texture_coordinates;
};

/// Unit normals of the vertices, V x 3: the area-weighted mean of the triangles around each one.
/// A vertex without area gets a zero row. `normals` is resized only when its size differs, so a
/// caller that keeps it allocates nothing.
void VertexNormals(const Points& vertices, const Triangles& triangles, Points* normals);

/// Volume enclosed by a closed surface, m^3 (divergence theorem); negative when it faces inwards.
double EnclosedVolume(const Points& vertices, const Triangles& triangles);

/// Centre of that volume, m; of a surface that encloses some.
Vector3d EnclosedCentre(const Points& vertices, const Triangles& triangles);

}  // namespace hpdm
