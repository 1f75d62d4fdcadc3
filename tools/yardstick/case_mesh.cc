#include "tools/yardstick/case_mesh.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "engine/tissue/support.h"
#include "tools/yardstick/cgal_mesher.h"

namespace hpdm {
namespace {

/// Distance from p to the border of a support's region, m.
double DistanceToBorder(const SupportOptions& support, const Box& bounds, const Vector3d& p) {
  if (const Sphere* sphere = std::get_if<Sphere>(&support.region)) {
    return std::abs((p - sphere->centre).norm() - sphere->radius);
  }
  Box box;
  if (const Box* given = std::get_if<Box>(&support.region)) {
    box = *given;
  } else {
    const BoxFraction& fraction = std::get<BoxFraction>(support.region);
    const Vector3d size = bounds.max - bounds.min;
    box = {bounds.min + fraction.min.cwiseProduct(size),
           bounds.min + fraction.max.cwiseProduct(size)};
  }
  const Vector3d below = box.min - p, above = p - box.max;
  const Vector3d outside = below.cwiseMax(above);  // negative: depth below each pair of faces
  return outside.maxCoeff() > 0 ? outside.cwiseMax(0.0).norm() : -outside.maxCoeff();
}

}  // namespace

TetraMesh MeshOf(const StaticCase& load_case, int nodes, Grading grading, double distance) {
  const Box bounds = AxisAlignedBounds(load_case.rest.vertices);
  const double length = (bounds.max - bounds.min).maxCoeff();
  double scale = 1;
  const auto size = [&](const Vector3d& p) {
    double least = length / 15;
    if (grading == Grading::kEven) return scale * least;
    for (const LoadOptions& load : load_case.scene.loads) {
      const double beyond = std::max(0.0, (p - load.p_centre_W).norm() - load.radius);
      least = std::min(least, load.radius / 3 + 0.25 * beyond);
    }
    if (grading == Grading::kLoadsAndSupports) {
      for (const SupportOptions& support : load_case.organ.supports) {
        least = std::min(least, length / 45 + 0.4 * DistanceToBorder(support, bounds, p));
      }
    }
    return scale * least;
  };
  TetraMesh mesh;
  for (int attempt = 0; attempt < 6; ++attempt) {
    mesh = FillWithTetrahedra(load_case.rest, size, distance * scale * length / 15);
    const double ratio = static_cast<double>(mesh.corners) / nodes;
    if (std::abs(ratio - 1) < 0.06) break;
    scale *= std::cbrt(ratio);
  }
  return mesh;
}

}  // namespace hpdm
