#include "scenes/instrument_mesh.h"

#include <array>
#include <vector>

#include "engine/check.h"

namespace hpdm {
namespace {

constexpr double kRadius = 2.5e-3, kShaftLength = 0.3;
constexpr int kSegments = 16;

/// Vertices spread evenly over a circle about the z axis.
struct Ring {
  int count;
  double radius, z;  ///< m.
  bool half_step;    ///< Starts half a segment past the x axis.
};

/// {cosine, sine} of a fraction of a full turn, by Taylor series after halving the angle three
/// times: the bits do not depend on a mathematics library.
std::array<double, 2> CosineSine(double turns) {
  constexpr double kFullTurn = 6.283185307179586476925;
  const double x = turns * kFullTurn / 8, x2 = x * x;
  double cosine = 1, sine = x, cosine_term = 1, sine_term = x;
  for (int k = 1; k <= 10; ++k) {
    cosine_term *= -x2 / ((2 * k - 1) * (2 * k));
    sine_term *= -x2 / ((2 * k) * (2 * k + 1));
    cosine += cosine_term;
    sine += sine_term;
  }
  for (int doubling = 0; doubling < 3; ++doubling) {
    const double c = cosine * cosine - sine * sine;
    sine = 2 * cosine * sine;
    cosine = c;
  }
  return {cosine, sine};
}

/// 281 vertices in rings from the tip to the end: with a pole at both ends, 562 triangles.
std::vector<Ring> Rings() {
  std::vector<Ring> rings;
  // Latitudes of the tip, as fractions of a turn from the pole. A ring of nine makes the total.
  const auto add_latitude = [&rings](int count, double turns, bool half_step) {
    const std::array<double, 2> latitude = CosineSine(turns);
    rings.push_back({count, kRadius * latitude[1], -kRadius * latitude[0], half_step});
  };
  add_latitude(9, 26.0 / 360, false);
  add_latitude(kSegments, 48.0 / 360, false);
  add_latitude(kSegments, 69.0 / 360, true);
  // Along the shaft: the first rings as far apart as the triangles are wide, then ever farther.
  constexpr int kShaftRings = 15;
  double z = 0, step = 0.9e-3;
  for (int i = 0; i + 1 < kShaftRings; ++i) {
    rings.push_back({kSegments, kRadius, z, i % 2 == 1});
    z += step;
    step *= 1.4;
  }
  HPDM_CHECK(z < kShaftLength);
  rings.push_back({kSegments, kRadius, kShaftLength, true});
  return rings;
}

/// Angle of vertex i of a ring, in turns.
double Turns(const Ring& ring, int i) { return (i + (ring.half_step ? 0.5 : 0.0)) / ring.count; }

}  // namespace

SurfaceMesh ProbeMesh() {
  const std::vector<Ring> rings = Rings();
  std::vector<Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> first;  // Vertex of each ring.
  for (const Ring& ring : rings) {
    first.push_back(static_cast<int>(vertices.size()));
    for (int i = 0; i < ring.count; ++i) {
      const std::array<double, 2> angle = CosineSine(Turns(ring, i));
      vertices.emplace_back(ring.radius * angle[0], ring.radius * angle[1], ring.z);
    }
  }
  const int tip = static_cast<int>(vertices.size()), end = tip + 1;
  vertices.emplace_back(0, 0, -kRadius);
  vertices.emplace_back(0, 0, kShaftLength);

  const auto vertex = [&](std::size_t r, int i) { return first[r] + i % rings[r].count; };
  for (int i = 0; i < rings[0].count; ++i)
    triangles.push_back({tip, vertex(0, i + 1), vertex(0, i)});
  for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
    // Walk around both rings; the one that lags behind advances.
    const Ring &low = rings[r], &high = rings[r + 1];
    for (int i = 0, j = 0; i < low.count || j < high.count;) {
      if (j == high.count || (i < low.count && Turns(low, i + 1) <= Turns(high, j + 1))) {
        triangles.push_back({vertex(r, i), vertex(r, i + 1), vertex(r + 1, j)});
        ++i;
      } else {
        triangles.push_back({vertex(r, i), vertex(r + 1, j + 1), vertex(r + 1, j)});
        ++j;
      }
    }
  }
  const std::size_t last = rings.size() - 1;
  for (int i = 0; i < rings[last].count; ++i) {
    triangles.push_back({end, vertex(last, i), vertex(last, i + 1)});
  }

  SurfaceMesh mesh;
  mesh.vertices.resize(vertices.size(), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v) mesh.vertices.row(v) = vertices[v];
  mesh.triangles.resize(triangles.size(), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) mesh.triangles(t, k) = triangles[t][k];
  }
  return mesh;
}

}  // namespace hpdm
