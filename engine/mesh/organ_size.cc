#include "engine/mesh/organ_size.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace hpdm {
namespace {

constexpr double kUsualAcross = 0.15;  // m, an abdominal organ

/// Returns the unit in which `across` units of a file are nearest to a usual organ.
std::string LikelyUnit(double across) {
  constexpr std::pair<const char*, double> kUnits[] = {{"m", 1}, {"mm", 1e-3}, {"0.01", 1e-2}};
  std::string likely = "m";
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [name, metres] : kUnits) {
    const double factor = std::abs(std::log(across * metres / kUsualAcross));
    if (!(factor < least)) continue;
    least = factor;
    likely = name;
  }
  return likely;
}

}  // namespace

bool OrganSize::IsOrgan() const {
  return across >= kMinAcross && across <= kMaxAcross && volume <= kMaxVolume;
}

std::string OrganSize::Text() const {
  char text[128];
  std::snprintf(text, sizeof text,
                "%.3g m across, %.3g m^3; an organ is %g to %g m across and at most %g m^3", across,
                volume, kMinAcross, kMaxAcross, kMaxVolume);
  return text;
}

OrganSize SizeOfOrgan(const SurfaceMesh& mesh, double unit_m) {
  const Eigen::RowVector3d sides =
      mesh.vertices.colwise().maxCoeff() - mesh.vertices.colwise().minCoeff();
  OrganSize size;
  size.across = sides.maxCoeff();
  // The estimate for an open surface may exceed its box.
  size.volume = std::min(std::abs(EnclosedVolume(mesh.vertices, mesh.triangles)), sides.prod());
  size.likely_unit = LikelyUnit(size.across / unit_m);
  return size;
}

}  // namespace hpdm
