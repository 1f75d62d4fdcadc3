#include "engine/baselines/press_volume.h"

#include <cmath>
#include <numbers>

#include "engine/base/check.h"
#include "engine/baselines/skin.h"
#include "engine/baselines/surface_error.h"

namespace hpdm {

Eigen::RowVectorXd PatchWeights(const SurfaceMesh& rest, const SurfacePoint& at, double radius) {
  Eigen::RowVectorXd weights = Eigen::RowVectorXd::Zero(rest.vertices.rows());
  const Vector3d centre = at.Position(rest.vertices, rest.triangles);
  const Eigen::VectorXd areas = VertexAreas(rest);
  for (Eigen::Index v = 0; v < weights.size(); ++v) {
    const double distance = (rest.vertices.row(v).transpose() - centre).norm();
    if (distance < radius)
      weights[v] = areas[v] * std::cos(std::numbers::pi * distance / (2 * radius));
  }
  if (weights.sum() > 0) return weights / weights.sum();
  for (int k = 0; k < 3; ++k) weights[rest.triangles(at.triangle, k)] += at.barycentric[k];
  return weights;
}

PressOutcome MeasurePress(const SurfaceMesh& rest, const WeightMatrix& weights,
                          const SurfacePress& press, int ramp, int hold, Relaxation* relaxation) {
  HPDM_CHECK(ramp >= 1 && hold >= 0 && weights.rows() == rest.vertices.rows());
  const Eigen::RowVectorXd patch = PatchWeights(rest, press.at, press.radius);
  Points normals;
  VertexNormals(rest.vertices, rest.triangles, &normals);
  const Vector3d normal = (patch * normals).normalized();
  const Vector3d p_rest = patch * rest.vertices;

  PressOutcome outcome;
  ContactConstraints contacts(static_cast<int>(weights.cols()));
  Points U = Points::Zero(weights.cols(), 3);
  for (int step = 1; step <= ramp + hold; ++step) {
    contacts.Clear();
    ContactConstraints::Row* row = contacts.Add();
    row->kind = ContactConstraints::RowKind::kGrasp;
    row->p_rest_W = p_rest;
    row->normal_W = normal;
    row->target_W = p_rest - std::min(1.0, static_cast<double>(step) / ramp) * press.depth * normal;
    contacts.WeightRow(0) = patch * weights;
    outcome.relaxed = relaxation->Relax(&contacts, &U);
  }
  outcome.force_W = contacts[0].force_W;
  outcome.vertices = rest.vertices + weights * U;
  outcome.volume_change = RelativeVolumeChange(rest, outcome.vertices - rest.vertices);
  return outcome;
}

}  // namespace hpdm
