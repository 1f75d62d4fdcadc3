#pragma once

#include "engine/lattice/relocation.h"
#include "tools/chart/static_case_model.h"
#include "tools/shared/flat_subdivision.h"
#include "tools/shared/timing.h"

/// Times of relocation on a surface of one size, so that steps of different cases compare.
namespace hpdm {

/// Returns the first 15,000 vertices (V x 3, m) of the same surface in 30,000 triangles or more.
inline Points FineVertices(const SurfaceMesh& rest) {
  constexpr Eigen::Index kVertices = 15000;
  return FlatSubdividedTo(rest, kVertices).vertices.topRows(kVertices);
}

/// Times the motion of `vertices` (V x 3, m) with the control points or nodes of `weights` (V x n).
inline Timing TimeRelocation(const Points& vertices, const WeightMatrix& weights) {
  const Relocation relocation(vertices, weights);
  const Points U = Points::Random(weights.cols(), 3);
  Points moved = vertices;
  return Time([&] { relocation.Relocate(U, &moved); });
}

/// Times the relocation of `fine_vertices` with the lattice of `body` and the parts added at its
/// loads. `indentations` is the time of these parts for the `vertices` of the case's own surface.
inline Timing TimeFineRelocation(const StaticCaseModel& body, const Points& fine_vertices,
                                 const Timing& indentations, Eigen::Index vertices) {
  const Lattice& lattice = body.lattice_organ()->lattice_organ()->lattice();
  const Timing of_lattice = TimeRelocation(fine_vertices, lattice.Weights(fine_vertices));
  // Functions added at the loads cost the same per vertex.
  return Sum(of_lattice, indentations,
             static_cast<double>(fine_vertices.rows()) / static_cast<double>(vertices));
}

}  // namespace hpdm
