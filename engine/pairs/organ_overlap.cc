#include "engine/pairs/organ_overlap.h"

#include <limits>
#include <optional>
#include <vector>

#include "engine/contact/surface_kernel.h"
#include "engine/mesh/collision.h"
#include "engine/mesh/winding_number.h"
#include "engine/pairs/contact_cells.h"

namespace hpdm {
namespace {

// Improves `overlap` by the points of one surface against the other.
void Measure(const SurfaceMesh& points, const SurfaceMesh& body, OrganOverlap* overlap) {
  const SurfaceTree tree(body.vertices, body.triangles);
  const WindingNumber winding(body);
  const Vector3d low = body.vertices.colwise().minCoeff(),
                 high = body.vertices.colwise().maxCoeff();
  const auto measure = [&](const Vector3d& p) {
    const bool inside =
        (p.array() > low.array()).all() && (p.array() < high.array()).all() && winding.At(p) > 0.5;
    if (!inside) {
      if (overlap->depth > 0) return;
      const SurfaceHit hit = tree.Closest(p, overlap->distance);
      if (hit.at.triangle >= 0 && hit.distance < overlap->distance) {
        *overlap = {0, hit.distance, p};
      }
      return;
    }
    const double depth = tree.Closest(p, std::numeric_limits<double>::infinity()).distance;
    if (depth > overlap->depth) *overlap = {depth, 0, p};
  };
  for (Eigen::Index v = 0; v < points.vertices.rows(); ++v) measure(points.vertices.row(v));
  for (const SurfaceSample& sample :
       SurfaceInRegion(points, std::nullopt, {}, ContactCells::kLongestSide)) {
    measure(AtSample(sample, points.triangles, points.vertices));
  }
}

}  // namespace

OrganOverlap MeasureOverlap(const SurfaceMesh& a, const SurfaceMesh& b) {
  OrganOverlap overlap;
  overlap.distance = std::numeric_limits<double>::infinity();
  Measure(a, b, &overlap);
  Measure(b, a, &overlap);
  return overlap;
}

}  // namespace hpdm
