#include "render/instrument/capsule_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "engine/base/check.h"

namespace hpdm {
namespace {

struct Ring {
  double radius;
  double z;
};

/// Returns the outline from just above the tip's pole to the shaft's end.
std::vector<Ring> Outline(double tip_radius, double shaft_radius, double length, int arcs) {
  // Angle from the pole (-z) at which the sphere meets the shaft, at most its equator.
  const double meet = shaft_radius < tip_radius
                          ? std::numbers::pi - std::asin(shaft_radius / tip_radius)
                          : std::numbers::pi / 2;
  std::vector<Ring> rings;
  for (int a = 1; a <= arcs; ++a) {
    const double angle = meet * a / arcs;
    rings.push_back({tip_radius * std::sin(angle), -tip_radius * std::cos(angle)});
  }
  if (shaft_radius > tip_radius) rings.push_back({shaft_radius, shaft_radius});
  // Rings along the shaft keep its triangles from becoming needles.
  constexpr int kShaftRings = 6;
  const double start = rings.back().z;
  for (int s = 1; s <= kShaftRings; ++s) {
    rings.push_back({shaft_radius, start + (length - start) * s / kShaftRings});
  }
  return rings;
}

}  // namespace

SurfaceMesh CapsuleMesh(double tip_radius, double shaft_radius, double length, int segments) {
  HPDM_CHECK(tip_radius > 0 && shaft_radius > 0 && segments >= 8);
  HPDM_CHECK(length > 3 * std::max(tip_radius, shaft_radius));
  const std::vector<Ring> rings = Outline(tip_radius, shaft_radius, length, segments / 2);
  const int ring_count = static_cast<int>(rings.size());
  const int first_pole = ring_count * segments;

  SurfaceMesh mesh;
  mesh.vertices.resize(first_pole + 2, 3);
  for (int r = 0; r < ring_count; ++r) {
    for (int s = 0; s < segments; ++s) {
      const double angle = 2 * std::numbers::pi * s / segments;
      mesh.vertices.row(r * segments + s) << rings[r].radius * std::cos(angle),
          rings[r].radius * std::sin(angle), rings[r].z;
    }
  }
  mesh.vertices.row(first_pole) << 0, 0, -tip_radius;
  mesh.vertices.row(first_pole + 1) << 0, 0, length;

  mesh.triangles.resize(2 * segments * ring_count, 3);
  int t = 0;
  for (int s = 0; s < segments; ++s) {
    const int next = (s + 1) % segments;
    mesh.triangles.row(t++) << first_pole, next, s;
    for (int r = 0; r + 1 < ring_count; ++r) {
      const int below = r * segments, above = below + segments;
      mesh.triangles.row(t++) << below + s, below + next, above + next;
      mesh.triangles.row(t++) << below + s, above + next, above + s;
    }
    const int last = (ring_count - 1) * segments;
    mesh.triangles.row(t++) << first_pole + 1, last + s, last + next;
  }
  return mesh;
}

}  // namespace hpdm
