#include "engine/tissue/support.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/check.h"
#include "engine/base/error.h"
#include "engine/energy/mixed_dilatation.h"
#include "engine/tissue/tissue_cache.h"

namespace hpdm {
namespace {

bool Inside(const Vector3d& min, const Vector3d& max, const Vector3d& p) {
  return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
}

constexpr double kWeakSpring = 1e-3;
constexpr double kFixedPenalty = 256;
// Most cells along an axis of a support's region; more would only resolve rounding.
constexpr double kMaxRegionCells = 32;

ScalarStiffness FixedStiffness(const Lattice& lattice, const Quadrature& region, double stiffness) {
  const CoarserSplines splines(lattice, region);
  const Eigen::MatrixXd P = splines.Project(lattice.Weights(region.points));
  const Eigen::MatrixXd S = stiffness * P.transpose() * P;
  return S.sparseView();
}

}  // namespace

bool InRegion(const Region& region, const Box& bounds, const Vector3d& p_W) {
  if (const Box* box = std::get_if<Box>(&region)) return Inside(box->min, box->max, p_W);
  if (const Sphere* sphere = std::get_if<Sphere>(&region)) {
    return (p_W - sphere->centre).norm() <= sphere->radius;
  }
  const BoxFraction& fraction = std::get<BoxFraction>(region);
  const Vector3d size = bounds.max - bounds.min;
  return Inside(bounds.min + fraction.min.cwiseProduct(size),
                bounds.min + fraction.max.cwiseProduct(size), p_W);
}

Box AxisAlignedBounds(const Points& vertices) {
  return {vertices.colwise().minCoeff().transpose(), vertices.colwise().maxCoeff().transpose()};
}

Box BoundsOf(const Region& region, const Box& bounds) {
  Box around;
  if (const Box* box = std::get_if<Box>(&region)) {
    around = *box;
  } else if (const Sphere* sphere = std::get_if<Sphere>(&region)) {
    around = {sphere->centre.array() - sphere->radius, sphere->centre.array() + sphere->radius};
  } else {
    const BoxFraction& fraction = std::get<BoxFraction>(region);
    const Vector3d size = bounds.max - bounds.min;
    around = {bounds.min + fraction.min.cwiseProduct(size),
              bounds.min + fraction.max.cwiseProduct(size)};
  }
  return {around.min.cwiseMax(bounds.min), around.max.cwiseMin(bounds.max)};
}

Quadrature SampleSupport(const SurfaceMesh& rest_W, const SupportOptions& support,
                         const Box& bounds, double spacing) {
  const Box region = BoundsOf(support.region, bounds);
  const Vector3d size = region.max - region.min;
  Quadrature inside{Points(0, 3), Eigen::VectorXd(0)};
  if (!(size.array() > 0).all()) return inside;
  // The edge of a sphere is as sharp as its samples, so it gets finer cells.
  const bool is_sphere = std::holds_alternative<Sphere>(support.region);
  const double cell = is_sphere ? spacing / 4 : spacing;
  std::array<int, 3> cells;
  for (int d = 0; d < 3; ++d) {
    // The billionth keeps round-off from adding a cell to a region of whole cells.
    cells[d] = static_cast<int>(std::clamp(std::ceil(size[d] / cell - 1e-9), 1.0, kMaxRegionCells));
  }
  const OrientedBox box{region.min, Matrix3d::Identity(), size};
  TissueQuadrature sampled;
  try {
    sampled = CachedTissue(rest_W, box, cells, {.resolution = 64});
  } catch (const InputError&) {
    return inside;  // no tissue in the box
  }
  inside.points.resize(sampled.points.rows(), 3);
  inside.weights.resize(sampled.weights.size());
  Eigen::Index kept = 0;
  for (Eigen::Index q = 0; q < sampled.weights.size(); ++q) {
    // The points of a box lie in it, to within a sample's size.
    if (is_sphere && !InRegion(support.region, bounds, sampled.points.row(q).transpose())) continue;
    inside.points.row(kept) = sampled.points.row(q);
    inside.weights[kept++] = sampled.weights[q];
  }
  inside.points.conservativeResize(kept, 3);
  inside.weights.conservativeResize(kept);
  return inside;
}

double ControlPointSpacing(const Lattice& lattice) {
  double sum = 0;
  for (int d = 0; d < 3; ++d) sum += lattice.box().lengths[d] * lattice.basis().axis(d).spacing();
  return sum / 3;
}

double FixedSupport(const Lattice& lattice, double modulus) {
  const double h = ControlPointSpacing(lattice);
  return kFixedPenalty * modulus / (h * h);
}

double WeakSupport(const Lattice& lattice, double modulus) {
  const double length = lattice.box().lengths.mean();
  return kWeakSpring * modulus / (length * length);
}

ScalarStiffness SupportStiffness(const Lattice& lattice, const Quadrature& tissue,
                                 const std::vector<SupportOptions>& supports,
                                 const std::vector<Quadrature>& regions, double modulus) {
  HPDM_CHECK(regions.size() == supports.size());
  const auto springs = [&lattice](const Quadrature& region, double stiffness) {
    const WeightMatrix weights = lattice.Weights(region.points);
    return ScalarStiffness(stiffness * weights.transpose() * region.weights.asDiagonal() * weights);
  };
  if (supports.empty()) {
    return springs(tissue, WeakSupport(lattice, modulus));
  }
  ScalarStiffness sum(lattice.size(), lattice.size());
  for (std::size_t s = 0; s < supports.size(); ++s) {
    if (regions[s].weights.size() == 0) continue;
    sum += supports[s].stiffness
               ? springs(regions[s], *supports[s].stiffness)
               : FixedStiffness(lattice, regions[s], FixedSupport(lattice, modulus));
  }
  return sum;
}

}  // namespace hpdm
