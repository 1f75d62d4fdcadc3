#include "engine/mesh/curved_surface.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

namespace hpdm {
namespace {

// Sweeps of Gauss-Seidel's method over the vertices, and the weight that holds a normal at its mean of
// the faces, of its edges' squared lengths. Normals that turn to and fro from vertex to vertex are
// perpendicular to no worse: without the weight an edge of 45 degrees made ripples of 6 degrees five
// triangles away.
constexpr int kSweeps = 20;
constexpr double kHold = 0.05;

// Largest change of a unit normal.
constexpr double kMostTurn = 0.2;

// True if no face around a vertex with the unit `normal` makes an edge there.
bool IsSmooth(const SurfaceMesh& mesh, const SurfaceTopology& topology, int vertex,
              const Vector3d& normal) {
  for (const int t : topology.TrianglesAround(vertex)) {
    const Vector3d a = mesh.vertices.row(mesh.triangles(t, 0));
    const Vector3d b = mesh.vertices.row(mesh.triangles(t, 1));
    const Vector3d c = mesh.vertices.row(mesh.triangles(t, 2));
    const Vector3d area = (b - a).cross(c - a);
    if (normal.dot(area) < kSmoothCosine * area.norm()) return false;
  }
  return true;
}

// Turns a normal to the least sum of ((n_i + n_j) . e_ij)^2 over the edges to smooth vertices, and of
// its change from `mean` with the weight kHold.
void TurnToEdges(const SurfaceMesh& mesh, const SurfaceTopology& topology,
                 const std::vector<bool>& smooth, int vertex, const Vector3d& mean,
                 Points* normals) {
  const Vector3d p = mesh.vertices.row(vertex), n = normals->row(vertex);
  Matrix3d A = Matrix3d::Zero();
  Vector3d off = Vector3d::Zero();
  for (const int t : topology.TrianglesAround(vertex)) {
    const Eigen::RowVector3i corners = mesh.triangles.row(t);
    const int k = corners[0] == vertex ? 0 : corners[1] == vertex ? 1 : 2;
    const int other = corners[(k + 1) % 3];
    if (!smooth[static_cast<std::size_t>(other)]) continue;
    const Vector3d e = Vector3d(mesh.vertices.row(other)) - p;
    A += e * e.transpose();
    off += (n + Vector3d(normals->row(other))).dot(e) * e;
  }
  const double size = A.trace();
  if (!(size > 0)) return;
  off += kHold * size * (n - mean);
  const Vector3d turn = (A + kHold * size * Matrix3d::Identity()).ldlt().solve(off);
  Vector3d change = n - (turn - n.dot(turn) * n) - mean;
  change *= std::min(1.0, kMostTurn / std::max(change.norm(), 1e-300));
  normals->row(vertex) = (mean + change).stableNormalized();
}

}  // namespace

void FitNormals(const SurfaceMesh& mesh, const SurfaceTopology& topology, Points* normals) {
  std::vector<bool> smooth(static_cast<std::size_t>(normals->rows()));
  for (std::size_t v = 0; v < smooth.size(); ++v) {
    const auto vertex = static_cast<int>(v);
    smooth[v] = IsSmooth(mesh, topology, vertex, normals->row(vertex));
  }
  const Points means = *normals;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t v = 0; v < smooth.size(); ++v) {
      const auto vertex = static_cast<int>(v);
      if (smooth[v]) TurnToEdges(mesh, topology, smooth, vertex, means.row(vertex), normals);
    }
  }
}

Vector3d CurvedOffset(const SurfaceMesh& mesh, const SurfaceTopology& topology,
                      const Points& normals, const SurfacePoint& at) {
  std::array<Vector3d, 3> corners, bends;
  for (int k = 0; k < 3; ++k) {
    const int v = mesh.triangles(at.triangle, k);
    corners[k] = mesh.vertices.row(v);
    bends[k] = normals.row(v);
    if (!IsSmooth(mesh, topology, v, bends[k])) bends[k].setZero();
  }
  return CurvedOffset(corners, bends, at.barycentric);
}

}  // namespace hpdm
