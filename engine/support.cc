#include "engine/support.h"

namespace hpdm {
namespace {

bool Inside(const Vector3d& min, const Vector3d& max, const Vector3d& p) {
  return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
}

constexpr double kWeakSpring = 1e-3;
constexpr double kFixedPenalty = 1e4;

}  // namespace

bool InRegion(const SupportOptions& support, const Box& bounds, const Vector3d& p_W) {
  if (const Box* box = std::get_if<Box>(&support.region)) return Inside(box->min, box->max, p_W);
  if (const Sphere* sphere = std::get_if<Sphere>(&support.region)) {
    return (p_W - sphere->centre).norm() <= sphere->radius;
  }
  const BoxFraction& fraction = std::get<BoxFraction>(support.region);
  const Vector3d size = bounds.max - bounds.min;
  return Inside(bounds.min + fraction.min.cwiseProduct(size),
                bounds.min + fraction.max.cwiseProduct(size), p_W);
}

Box AxisAlignedBounds(const Points& vertices) {
  return {vertices.colwise().minCoeff().transpose(), vertices.colwise().maxCoeff().transpose()};
}

double FixedSupportStiffness(double modulus, double length) {
  return kFixedPenalty * modulus / (length * length);
}

ScalarStiffness SupportStiffness(const Lattice& lattice, const Quadrature& tissue,
                                 const std::vector<SupportOptions>& supports, const Box& bounds,
                                 double modulus, std::vector<double>* tissue_in_supports) {
  const double length = lattice.box().lengths.mean();
  Eigen::VectorXd spring = Eigen::VectorXd::Zero(tissue.weights.size());  // N/m at each point
  tissue_in_supports->assign(supports.size(), 0.0);
  for (std::size_t s = 0; s < supports.size(); ++s) {
    const double stiffness = supports[s].stiffness.value_or(FixedSupportStiffness(modulus, length));
    for (Eigen::Index q = 0; q < spring.size(); ++q) {
      if (!InRegion(supports[s], bounds, tissue.points.row(q).transpose())) continue;
      spring[q] += stiffness * tissue.weights[q];
      (*tissue_in_supports)[s] += tissue.weights[q];
    }
  }
  if (spring.maxCoeff() <= 0) {
    spring = kWeakSpring * modulus / (length * length) * tissue.weights;
  }
  const WeightMatrix weights = lattice.Weights(tissue.points);
  return ScalarStiffness(weights.transpose() * spring.asDiagonal() * weights);
}

}  // namespace hpdm
