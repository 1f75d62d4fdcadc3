#pragma once

#include <cmath>
#include <cstdint>

#include "engine/snapshots.h"

/// Patches of known shape for the tests of the haptic loop.
namespace hpdm {

/// A grid of size x size points (size <= 8) over the square of the given half width (m) in the
/// plane z = 0, facing +z, with the same k1 (N/m) everywhere; as many triangles as a patch takes.
inline ToolPatch PlanePatch(int size, double half_width, double k1) {
  ToolPatch patch;
  patch.organ = 0;
  patch.kind = ContactKind::kPress;
  for (int j = 0; j < size; ++j) {
    for (int i = 0; i < size; ++i) {
      patch.nodes[patch.node_count++].k1 = k1;
      PatchPoint& point = patch.points[patch.point_count++];
      const double step = 2 * half_width / (size - 1);
      point.p_original_W = Vector3d(-half_width + i * step, -half_width + j * step, 0);
      point.normal_W = Vector3d::UnitZ();
    }
  }
  const auto add = [&](int a, int b, int c) {
    if (patch.triangle_count == ToolPatch::kMaxTriangles) return;
    patch.mesh_triangles[patch.triangle_count] = patch.triangle_count;
    patch.triangles[patch.triangle_count++] = {
        static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b), static_cast<std::uint8_t>(c)};
  };
  for (int j = 0; j + 1 < size; ++j) {
    for (int i = 0; i + 1 < size; ++i) {
      const int a = j * size + i;
      add(a, a + 1, a + size + 1);
      add(a, a + size + 1, a + size);
    }
  }
  patch.Pack();
  return patch;
}

/// PlanePatch projected from the centre (0, 0, -radius) on the sphere of that radius, so that its
/// pole is the origin; exact normals.
inline ToolPatch SpherePatch(int size, double half_width, double radius, double k1) {
  ToolPatch patch = PlanePatch(size, half_width, k1);
  const Vector3d centre(0, 0, -radius);
  for (int i = 0; i < patch.point_count; ++i) {
    PatchPoint& point = patch.points[i];
    point.normal_W = (point.p_original_W - centre).normalized();
    point.p_original_W = centre + radius * point.normal_W;
  }
  patch.Pack();
  return patch;
}

}  // namespace hpdm
