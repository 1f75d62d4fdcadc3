#include "scenes/generator/shapes/solid_builder.h"

#include <cstddef>

#include "engine/base/check.h"

namespace hpdm {

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

SolidBuilder::Ring SolidBuilder::Circle(const Vector3d& centre, const Vector3d& u,
                                        const Vector3d& v, double radius, int count,
                                        bool half_step) {
  Ring ring{.points = {}, .half_step = half_step};
  for (int i = 0; i < count; ++i) {
    const std::array<double, 2> angle = CosineSine((i + (half_step ? 0.5 : 0.0)) / count);
    ring.points.push_back(centre + radius * angle[0] * u + radius * angle[1] * v);
  }
  return ring;
}

int SolidBuilder::AddVertex(const Vector3d& p) {
  vertices_.push_back(p);
  return static_cast<int>(vertices_.size()) - 1;
}

std::vector<int> SolidBuilder::AddVertices(const std::vector<Vector3d>& points) {
  std::vector<int> added;
  for (const Vector3d& p : points) added.push_back(AddVertex(p));
  return added;
}

void SolidBuilder::Zip(const Side& a, const Side& b) {
  // Walks along both sides; the one behind advances.
  const std::size_t end_a = a.vertices.size() - 1, end_b = b.vertices.size() - 1;
  for (std::size_t i = 0, j = 0; i < end_a || j < end_b;) {
    if (j == end_b || (i < end_a && a.along[i + 1] <= b.along[j + 1])) {
      triangles_.push_back({a.vertices[i], a.vertices[i + 1], b.vertices[j]});
      ++i;
    } else {
      triangles_.push_back({a.vertices[i], b.vertices[j + 1], b.vertices[j]});
      ++j;
    }
  }
}

void SolidBuilder::AddTube(const std::vector<Ring>& rings, const Vector3d& near_end,
                           const Vector3d& far_end) {
  HPDM_CHECK(!rings.empty());
  std::vector<Side> sides;
  for (const Ring& ring : rings) {
    Side& side = sides.emplace_back();
    side.vertices = AddVertices(ring.points);
    side.vertices.push_back(side.vertices.front());
    for (std::size_t i = 0; i < side.vertices.size(); ++i) {
      side.along.push_back((static_cast<double>(i) + (ring.half_step ? 0.5 : 0.0)) /
                           static_cast<double>(ring.points.size()));
    }
  }
  const int near_pole = AddVertex(near_end), far_pole = AddVertex(far_end);
  const std::vector<int>& first = sides.front().vertices;
  for (std::size_t i = 0; i + 1 < first.size(); ++i) {
    triangles_.push_back({near_pole, first[i + 1], first[i]});
  }
  for (std::size_t r = 0; r + 1 < sides.size(); ++r) Zip(sides[r], sides[r + 1]);
  const std::vector<int>& last = sides.back().vertices;
  for (std::size_t i = 0; i + 1 < last.size(); ++i) {
    triangles_.push_back({far_pole, last[i], last[i + 1]});
  }
}

void SolidBuilder::AddBar(const std::vector<std::vector<Vector3d>>& lines) {
  std::vector<Side> sides;
  for (const std::vector<Vector3d>& line : lines) {
    Side& side = sides.emplace_back();
    side.vertices = AddVertices(line);
    for (const Vector3d& p : line) side.along.push_back(p.z());
  }
  for (std::size_t k = 0; k < sides.size(); ++k) Zip(sides[(k + 1) % sides.size()], sides[k]);
  for (std::size_t k = 1; k + 1 < sides.size(); ++k) {
    triangles_.push_back(
        {sides[0].vertices.front(), sides[k + 1].vertices.front(), sides[k].vertices.front()});
    triangles_.push_back(
        {sides[0].vertices.back(), sides[k].vertices.back(), sides[k + 1].vertices.back()});
  }
}

SurfaceMesh SolidBuilder::Mesh() const {
  SurfaceMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(vertices_.size()), 3);
  for (std::size_t v = 0; v < vertices_.size(); ++v) mesh.vertices.row(v) = vertices_[v];
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles_.size()), 3);
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (int k = 0; k < 3; ++k) mesh.triangles(t, k) = triangles_[t][k];
  }
  return mesh;
}

}  // namespace hpdm
