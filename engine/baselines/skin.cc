#include "engine/baselines/skin.h"

#include <cmath>
#include <numbers>

#include "engine/base/error.h"
#include "engine/tissue/support.h"

namespace hpdm {
namespace {

constexpr double kMinAreaShare = 1e-3;
constexpr double kFixedPenalty = 1e4;  // times modulus / length^2: holds a vertex, well conditioned
constexpr double kWeakSpring = 1e-3;   // as in SupportStiffness for an organ without supports

}  // namespace

Eigen::VectorXd VertexAreas(const SurfaceMesh& mesh) {
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(mesh.vertices.rows());
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Vector3d a = mesh.vertices.row(mesh.triangles(t, 0));
    const Vector3d b = mesh.vertices.row(mesh.triangles(t, 1));
    const Vector3d c = mesh.vertices.row(mesh.triangles(t, 2));
    const double area = (b - a).cross(c - a).norm() / 2;
    for (int k = 0; k < 3; ++k) areas[mesh.triangles(t, k)] += area / 3;
  }
  return areas;
}

Skin MeasureSkin(const SurfaceMesh& rest, const std::string& name) {
  Skin skin;
  skin.areas = VertexAreas(rest);
  const double volume = EnclosedVolume(rest.vertices, rest.triangles);
  // A sphere has the largest volume, area^1.5 / (6 sqrt(pi)). A millionth of that counts as none.
  if (!(volume > 1e-6 * std::pow(skin.areas.sum(), 1.5) / (6 * std::sqrt(std::numbers::pi)))) {
    throw InputError("organ \"" + name +
                     "\": its surface encloses no volume; close it, turn it outwards or use "
                     "model = \"hpdm\"");
  }
  skin.areas = skin.areas.cwiseMax(kMinAreaShare * skin.areas.mean());
  skin.area = skin.areas.sum();
  skin.thickness = volume / skin.area;
  return skin;
}

Eigen::VectorXd GroundSprings(const SurfaceMesh& rest, const Skin& skin,
                              const std::vector<SupportOptions>& supports, double modulus,
                              const std::string& name) {
  const Box bounds = AxisAlignedBounds(rest.vertices);
  const double length = (bounds.max - bounds.min).mean();
  const Eigen::VectorXd volumes = skin.Volumes();
  if (supports.empty()) return kWeakSpring * modulus / (length * length) * volumes;
  Eigen::VectorXd springs = Eigen::VectorXd::Zero(volumes.size());
  for (std::size_t s = 0; s < supports.size(); ++s) {
    const double stiffness =
        supports[s].stiffness.value_or(kFixedPenalty * modulus / (length * length));
    int held = 0;
    for (Eigen::Index v = 0; v < springs.size(); ++v) {
      if (!InRegion(supports[s].region, bounds, rest.vertices.row(v).transpose())) continue;
      springs[v] += stiffness * volumes[v];
      ++held;
    }
    if (held > 0) continue;
    const std::string key = "support[" + std::to_string(s) + "]";
    throw InputError(
        "organ \"" + name + "\": " + key + " holds no vertex; move or enlarge its region",
        {"organ", name, key});
  }
  return springs;
}

WeightMatrix VertexWeights(Eigen::Index vertex_count) {
  WeightMatrix identity(vertex_count, vertex_count);
  identity.setIdentity();
  return identity;
}

}  // namespace hpdm
