#pragma once

#include <vector>

#include "engine/contact/half_space.h"
#include "engine/lattice/lattice.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/snapshots.h"
#include "lcmtypes/wire/mesh_codec.h"

namespace hpdm {

/// Adds what the functions of these grid indices move the vertices by.
inline void AddDisplacements(const OrientedBox& box, const LatticeOptions& options,
                             const std::vector<int>& indices, const Points& displacements,
                             const Points& rest, Points* vertices) {
  const Lattice lattice(box, options);
  std::vector<int> row(lattice.size(), -1);
  for (std::size_t a = 0; a < indices.size(); ++a) row[indices[a]] = static_cast<int>(a);
  for (Eigen::Index v = 0; v < rest.rows(); ++v) {
    lattice.ForEachFunction(rest.row(v).transpose(), [&](int index, double value) {
      if (row[index] >= 0) vertices->row(v) += value * displacements.row(row[index]);
    });
  }
}

/// An organ's surface as lcmtypes/README.md says, from the messages alone, with the engine's bases.
inline Points Rebuilt(const OrganDescription& organ, const OrganSnapshot& shape) {
  Points vertices = organ.vertices;
  const LatticeDescription& lattice = *organ.lattice;
  const OrientedBox box{lattice.origin_W, lattice.axes, lattice.lengths};
  LatticeOptions options;
  options.basis = lattice.basis;
  options.degree = lattice.degree;
  options.cells = lattice.cells;
  AddDisplacements(box, options, lattice.kept, shape.control_displacements, organ.vertices,
                   &vertices);
  for (int& cells : options.cells) cells *= lattice.local_refinement;
  AddDisplacements(box, options, shape.local_functions, shape.local_displacements, organ.vertices,
                   &vertices);
  Points normals;
  VertexNormals(organ.vertices, organ.triangles, &normals);
  for (int i = 0; i < shape.indentation_count; ++i) {
    const IndentationSnapshot& indentation = shape.indentations[i];
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
      if (normals.row(v).dot(indentation.normal_W) <= 0) continue;
      const double d = (organ.vertices.row(v).transpose() - indentation.p_rest_W).norm();
      vertices.row(v) += (IndentationProfile(d, indentation.radius, indentation.resolved_radius) *
                          indentation.amplitude_W)
                             .transpose();
    }
  }
  vertices.rowwise() += shape.offset_W.transpose();
  return vertices;
}

}  // namespace hpdm
