#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "engine/organ_options.h"

namespace hpdm {

/// A closed cavity inside an organ's tissue that a fluid fills.
struct Lumen {
  double volume = 0;                    ///< m^3.
  double bulk_modulus = 0;              ///< Pa, of the fluid.
  double pressure = 0;                  ///< Pa, at rest over the surroundings.
  double leak_resistance = 0;           ///< Pa s/m^3, once it is perforated.
  std::optional<double> perforated_at;  ///< s.
  std::vector<int> vertices;            ///< Of its wall.
  /// One row a vertex, m^2: the share of the wall's area, along its normal into the tissue. So the
  /// volume grows by the sum of areas_W . u for small displacements u of the vertices.
  Points areas_W;
};

/// Returns, for each triangle, whether it belongs to the wall of a closed cavity: a connected part
/// of the surface without border that faces inwards. O(F log F).
std::vector<bool> TrianglesOfLumens(const SurfaceMesh& rest);

/// Returns the filled lumens of an organ, in the order of their first triangles. A lumen is in a
/// region if all vertices of its wall are; where options overlap, the last ones count. Set-up only.
/// Throws InputError (organ's name, fault, remedy) if options find no closed lumen.
std::vector<Lumen> FilledLumens(const SurfaceMesh& rest, const OrganOptions& organ);

/// Returns the relative change of a lumen's volume, linear in the displacements of the organ's
/// vertices (V x 3, m). The fluid's pressure is -bulk_modulus times it.
double RelativeChange(const Lumen& lumen, const Points& displacements);

}  // namespace hpdm
