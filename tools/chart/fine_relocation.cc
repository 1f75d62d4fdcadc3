#include "tools/chart/fine_relocation.h"

#include "tools/shared/flat_subdivision.h"

namespace hpdm {
namespace {

constexpr Eigen::Index kFineVertices = 15000;  // of a surface of 30,000 triangles

}  // namespace

Points FineVertices(const SurfaceMesh& rest) {
  return FlatSubdividedTo(rest, kFineVertices).vertices.topRows(kFineVertices);
}

Timing TimeRelocation(const Points& vertices, const WeightMatrix& weights) {
  const Relocation relocation(vertices, weights);
  const Points U = Points::Random(weights.cols(), 3);
  Points moved = vertices;
  return Time([&] { relocation.Relocate(U, &moved); });
}

Timing TimeFineRelocation(const StaticCaseModel& body, const Points& fine_vertices,
                          const Timing& indentations, Eigen::Index vertices) {
  const Lattice& lattice = body.lattice_organ()->lattice_organ()->lattice();
  const Timing of_lattice = TimeRelocation(fine_vertices, lattice.Weights(fine_vertices));
  // Functions added at the loads cost the same per vertex.
  return Sum(of_lattice, indentations,
             static_cast<double>(fine_vertices.rows()) / static_cast<double>(vertices));
}

}  // namespace hpdm
