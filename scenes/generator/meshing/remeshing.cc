#include "scenes/generator/meshing/remeshing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "engine/mesh/quadric.h"

namespace hpdm {
namespace {

double EdgeLength(const EditableMesh& mesh, int a, int b) {
  return (mesh.position(a) - mesh.position(b)).norm();
}

/// Calls visit(a, b) for every edge once, a < b, while the mesh may change under it.
template <typename Visit>
void ForEachEdge(const EditableMesh& mesh, Visit visit) {
  const int triangle_count = mesh.triangle_capacity();
  for (int t = 0; t < triangle_count; ++t) {
    for (int k = 0; k < 3; ++k) {
      if (!mesh.IsTriangle(t)) break;
      const int a = mesh.corners(t)[k], b = mesh.corners(t)[(k + 1) % 3];
      if (a < b) visit(a, b);
    }
  }
}

/// Returns the smallest angle (SmallestAngleMeasure) around v if it were at p; -1 if a triangle
/// would turn by more than 60 degrees or flip.
double StarMeasure(const EditableMesh& mesh, int v, const Vector3d& p) {
  double least = 1;
  for (const int t : mesh.star(v)) {
    std::array<Vector3d, 3> corner;
    for (int k = 0; k < 3; ++k) {
      corner[k] = mesh.corners(t)[k] == v ? p : mesh.position(mesh.corners(t)[k]);
    }
    const Vector3d before = mesh.AreaVector(t);
    const Vector3d after = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    if (before.dot(after) < 0.5 * before.norm() * after.norm()) return -1;
    least = std::min(least, SmallestAngleMeasure(corner[0], corner[1], corner[2]));
  }
  return least;
}

/// True if merging a and b at p turns no remaining triangle by more than 60 degrees.
bool CollapseKeepsNormals(const EditableMesh& mesh, int a, int b, const Vector3d& p) {
  for (const int v : {a, b}) {
    for (const int t : mesh.star(v)) {
      const std::array<int, 3>& c = mesh.corners(t);
      const bool has_a = c[0] == a || c[1] == a || c[2] == a;
      const bool has_b = c[0] == b || c[1] == b || c[2] == b;
      if (has_a && has_b) continue;
      std::array<Vector3d, 3> corner;
      for (int k = 0; k < 3; ++k) corner[k] = c[k] == v ? p : mesh.position(c[k]);
      const Vector3d before = mesh.AreaVector(t);
      const Vector3d after = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
      if (before.dot(after) <= 0.5 * before.norm() * after.norm()) return false;
    }
  }
  return true;
}

void SplitLongEdges(double longest, EditableMesh* mesh) {
  ForEachEdge(*mesh, [&](int a, int b) {
    if (EdgeLength(*mesh, a, b) <= longest) return;
    mesh->Split(a, b, 0.5 * (mesh->position(a) + mesh->position(b)));
  });
}

void CollapseShortEdges(double shortest, double longest, EditableMesh* mesh) {
  ForEachEdge(*mesh, [&](int a, int b) {
    if (EdgeLength(*mesh, a, b) >= shortest || !mesh->CanCollapse(a, b)) return;
    const Vector3d middle = 0.5 * (mesh->position(a) + mesh->position(b));
    for (const int v : {a, b}) {
      for (const int w : mesh->Neighbours(v)) {
        if ((mesh->position(w) - middle).norm() > longest) return;
      }
    }
    if (CollapseKeepsNormals(*mesh, a, b, middle)) mesh->Collapse(a, b, middle);
  });
}

/// Returns the unit field gradient at p.
Vector3d SurfaceNormal(const ImplicitShape& shape, const Vector3d& p) {
  const Vector3d gradient = shape.Sample(p).gradient;
  const double length = gradient.norm();
  return length > 0 ? Vector3d(gradient / length) : Vector3d::Zero();
}

/// Returns the corners of the two triangles that a flip of ab would create.
std::array<std::array<Vector3d, 3>, 2> Flipped(const EditableMesh& mesh, int a, int b) {
  const std::array<int, 2> opposite = mesh.OppositeVertices(a, b);
  const Vector3d &p = mesh.position(a), &q = mesh.position(b);
  const Vector3d &r = mesh.position(opposite[0]), &s = mesh.position(opposite[1]);
  return {{{p, s, r}, {q, r, s}}};
}

bool FlipKeepsNormals(const EditableMesh& mesh, int a, int b) {
  Vector3d mean = Vector3d::Zero();
  for (const int t : mesh.EdgeTriangles(a, b)) mean += mesh.AreaVector(t);
  for (const std::array<Vector3d, 3>& corner : Flipped(mesh, a, b)) {
    const Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    if (normal.dot(mean) <= 0.5 * normal.norm() * mean.norm()) return false;
  }
  return true;
}

void FlipTowardsValenceSix(EditableMesh* mesh) {
  ForEachEdge(*mesh, [&](int a, int b) {
    if (!mesh->CanFlip(a, b)) return;
    const std::array<int, 2> opposite = mesh->OppositeVertices(a, b);
    const auto excess = [mesh](int v, int change) {
      const int e = mesh->valence(v) + change - 6;
      return e * e;
    };
    const int before =
        excess(a, 0) + excess(b, 0) + excess(opposite[0], 0) + excess(opposite[1], 0);
    const int after =
        excess(a, -1) + excess(b, -1) + excess(opposite[0], 1) + excess(opposite[1], 1);
    if (after < before && FlipKeepsNormals(*mesh, a, b)) mesh->Flip(a, b);
  });
}

/// Area-weighted mean of the centroids of the triangles around v.
Vector3d StarCentroid(const EditableMesh& mesh, int v) {
  Vector3d sum = Vector3d::Zero();
  double weight = 0;
  for (const int t : mesh.star(v)) {
    const double area = mesh.AreaVector(t).norm();
    sum += area * mesh.Centroid(t);
    weight += area;
  }
  return weight > 0 ? Vector3d(sum / weight) : mesh.position(v);
}

void SmoothAlongSurface(const ImplicitShape& shape, double level, EditableMesh* mesh) {
  for (int v = 0; v < mesh->vertex_capacity(); ++v) {
    if (!mesh->IsVertex(v)) continue;
    const Vector3d p = mesh->position(v), normal = SurfaceNormal(shape, p);
    Vector3d move = StarCentroid(*mesh, v) - p;
    move -= normal.dot(move) * normal;
    const Vector3d target = ProjectToLevel(shape, p + move, level);
    if (StarMeasure(*mesh, v, target) > 0) mesh->set_position(v, target);
  }
}

/// Flips edges if the smallest angle grows and the new edge is as close to the surface.
void FlipTowardsWiderAngles(const ImplicitShape& shape, double level, EditableMesh* mesh) {
  ForEachEdge(*mesh, [&](int a, int b) {
    if (!mesh->CanFlip(a, b)) return;
    double before = 1, after = 1;
    for (const int t : mesh->EdgeTriangles(a, b)) {
      const std::array<int, 3>& c = mesh->corners(t);
      before = std::min(before, SmallestAngleMeasure(mesh->position(c[0]), mesh->position(c[1]),
                                                     mesh->position(c[2])));
    }
    for (const std::array<Vector3d, 3>& c : Flipped(*mesh, a, b)) {
      after = std::min(after, SmallestAngleMeasure(c[0], c[1], c[2]));
    }
    if (after <= 1.05 * before || !FlipKeepsNormals(*mesh, a, b)) return;
    const auto distance = [&](int p, int q) {
      const Vector3d middle = 0.5 * (mesh->position(p) + mesh->position(q));
      return std::abs(shape.Sample(middle).value - level);
    };
    const std::array<int, 2> opposite = mesh->OppositeVertices(a, b);
    const double allowance = 0.02 * EdgeLength(*mesh, a, b);
    if (distance(opposite[0], opposite[1]) > distance(a, b) + allowance) return;
    mesh->Flip(a, b);
  });
}

/// Returns the tangent planes of the surface near triangle t, at four points over it, weighted by
/// area.
Quadric TangentPlanes(const ImplicitShape& shape, double level, const EditableMesh& mesh, int t) {
  constexpr double kNear = 2.0 / 3, kFar = 1.0 / 6;
  const std::array<int, 3>& c = mesh.corners(t);
  const Vector3d &a = mesh.position(c[0]), &b = mesh.position(c[1]), &d = mesh.position(c[2]);
  const std::array<Vector3d, 4> samples = {(a + b + d) / 3, kNear * a + kFar * (b + d),
                                           kNear * b + kFar * (d + a), kNear * d + kFar * (a + b)};
  const double weight = mesh.AreaVector(t).norm() / samples.size();
  Quadric planes;
  for (const Vector3d& sample : samples) {
    const Vector3d foot = ProjectToLevel(shape, sample, level);
    planes.AddPlane(SurfaceNormal(shape, foot), foot, weight);
  }
  return planes;
}

void MoveToTangentPlanes(const ImplicitShape& shape, double level, EditableMesh* mesh) {
  // Weight of the pull to the middle of the star against the planes. It is small enough to leave a
  // vertex on a ridge, and large enough to even out flat directions.
  constexpr double kCentring = 0.02;
  std::vector<Quadric> planes(mesh->triangle_capacity());
  for (int t = 0; t < mesh->triangle_capacity(); ++t) {
    if (mesh->IsTriangle(t)) planes[t] = TangentPlanes(shape, level, *mesh, t);
  }
  for (int v = 0; v < mesh->vertex_capacity(); ++v) {
    if (!mesh->IsVertex(v)) continue;
    Quadric around;
    for (const int t : mesh->star(v)) around += planes[t];
    const Vector3d p = mesh->position(v);
    const Vector3d goal = around.Minimiser(StarCentroid(*mesh, v), kCentring);
    const double now = StarMeasure(*mesh, v, p);
    for (const double fraction : {1.0, 0.5, 0.25}) {
      const Vector3d target = ProjectToLevel(shape, p + fraction * (goal - p), level);
      // About 15 degrees suffice; beyond that the fit is favoured.
      const double then = StarMeasure(*mesh, v, target);
      if (then > std::min(now, 0.07)) {
        mesh->set_position(v, target);
        break;
      }
    }
  }
}

}  // namespace

void RemeshIsotropically(const ImplicitShape& shape, double level, double edge_length,
                         int iterations, EditableMesh* mesh) {
  const double longest = 4.0 / 3 * edge_length, shortest = 4.0 / 5 * edge_length;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    SplitLongEdges(longest, mesh);
    CollapseShortEdges(shortest, longest, mesh);
    FlipTowardsValenceSix(mesh);
    SmoothAlongSurface(shape, level, mesh);
  }
}

void RelaxOnSurface(const ImplicitShape& shape, double level, int iterations, EditableMesh* mesh) {
  for (int iteration = 0; iteration < iterations; ++iteration) {
    FlipTowardsWiderAngles(shape, level, mesh);
    MoveToTangentPlanes(shape, level, mesh);
  }
}

}  // namespace hpdm
