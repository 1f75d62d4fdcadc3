#include "engine/reference_fem/tetra_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "engine/base/error.h"
#include "engine/mesh/closest_point.h"

namespace hpdm {
namespace {

Vector3d Node(const TetraMesh& mesh, int element, int k) {
  return mesh.nodes.row(mesh.elements(element, k)).transpose();
}

double SixVolumes(const Points& nodes, const Tetrahedra& elements, Eigen::Index e) {
  const auto node = [&](int k) -> Vector3d { return nodes.row(elements(e, k)).transpose(); };
  const Vector3d a = node(0);
  return (node(1) - a).cross(node(2) - a).dot(node(3) - a);
}

constexpr std::array<std::array<int, 3>, 4> kFaces = {{{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}};

}  // namespace

TetraMesh MakeTetraMesh(const Points& nodes, const Tetrahedra& elements, const std::string& where) {
  if (elements.rows() == 0 || elements.cols() != 4) {
    throw InputError(where + ": no tetrahedra; give a mesh of four-node tetrahedra");
  }
  if (!nodes.allFinite()) throw InputError(where + ": a node is not finite; repair the mesh");
  if (elements.minCoeff() < 0 || elements.maxCoeff() >= nodes.rows()) {
    throw InputError(where + ": a tetrahedron names a node that does not exist; repair the mesh");
  }
  TetraMesh mesh{nodes, elements, static_cast<int>(nodes.rows()), {}};
  for (Eigen::Index e = 0; e < elements.rows(); ++e) {
    const double volume = SixVolumes(nodes, mesh.elements, e);
    if (volume < 0) std::swap(mesh.elements(e, 2), mesh.elements(e, 3));
    if (volume == 0) {
      throw InputError(where + ": tetrahedron " + std::to_string(e) +
                       " has no volume; repair the mesh");
    }
  }
  return mesh;
}

TetraMesh Quadratic(const TetraMesh& linear) {
  TetraMesh mesh;
  mesh.corners = static_cast<int>(linear.nodes.rows());
  mesh.elements.resize(linear.elements.rows(), 10);
  mesh.elements.leftCols(4) = linear.elements;
  std::map<std::pair<int, int>, int> middles;
  for (Eigen::Index e = 0; e < linear.elements.rows(); ++e) {
    for (int k = 0; k < 6; ++k) {
      const int a = linear.elements(e, kTetraEdges[k][0]);
      const int b = linear.elements(e, kTetraEdges[k][1]);
      const int next = mesh.corners + static_cast<int>(mesh.parents.size());
      const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), next);
      if (is_new) mesh.parents.push_back({std::min(a, b), std::max(a, b)});
      mesh.elements(e, 4 + k) = at->second;
    }
  }
  mesh.nodes.resize(mesh.corners + static_cast<Eigen::Index>(mesh.parents.size()), 3);
  mesh.nodes.topRows(mesh.corners) = linear.nodes;
  for (std::size_t m = 0; m < mesh.parents.size(); ++m) {
    mesh.nodes.row(mesh.corners + static_cast<Eigen::Index>(m)) =
        (linear.nodes.row(mesh.parents[m][0]) + linear.nodes.row(mesh.parents[m][1])) / 2;
  }
  return mesh;
}

TetraMesh BoxTetraMesh(const Vector3d& min, const Vector3d& max, const std::array<int, 3>& cells) {
  const auto index = [&](int i, int j, int k) {
    return i + (cells[0] + 1) * (j + (cells[1] + 1) * k);
  };
  Points nodes(index(cells[0], cells[1], cells[2]) + 1, 3);
  Tetrahedra elements(6 * cells[0] * cells[1] * cells[2], 4);
  constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  Eigen::Index next = 0;
  for (int k = 0; k <= cells[2]; ++k) {
    for (int j = 0; j <= cells[1]; ++j) {
      for (int i = 0; i <= cells[0]; ++i) {
        const Vector3d fraction(static_cast<double>(i) / cells[0],
                                static_cast<double>(j) / cells[1],
                                static_cast<double>(k) / cells[2]);
        nodes.row(index(i, j, k)) = min + fraction.cwiseProduct(max - min);
        if (i == cells[0] || j == cells[1] || k == cells[2]) continue;
        for (const auto& order : kOrders) {  // a walk along the three axes
          std::array<int, 3> at = {i, j, k};
          elements(next, 0) = index(i, j, k);
          for (int step = 0; step < 3; ++step) {
            ++at[order[step]];
            elements(next, step + 1) = index(at[0], at[1], at[2]);
          }
          ++next;
        }
      }
    }
  }
  return MakeTetraMesh(nodes, elements, "box");
}

double TetraVolume(const TetraMesh& mesh) {
  double six_volumes = 0;
  for (Eigen::Index e = 0; e < mesh.elements.rows(); ++e) {
    six_volumes += SixVolumes(mesh.nodes, mesh.elements, e);
  }
  return six_volumes / 6;
}

std::vector<TetraPoint> Locate(const TetraMesh& mesh, const Points& points) {
  const int count = static_cast<int>(mesh.elements.rows());
  std::vector<Eigen::AlignedBox3d> boxes(static_cast<std::size_t>(count));
  for (int e = 0; e < count; ++e) {
    for (int k = 0; k < 4; ++k) boxes[static_cast<std::size_t>(e)].extend(Node(mesh, e, k));
  }
  std::vector<TetraPoint> found(static_cast<std::size_t>(points.rows()));
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Vector3d p = points.row(i).transpose();
    TetraPoint best;
    best.distance = std::numeric_limits<double>::infinity();
    for (int e = 0; e < count && best.distance > 0; ++e) {
      if (boxes[static_cast<std::size_t>(e)].squaredExteriorDistance(p) >=
          best.distance * best.distance) {
        continue;
      }
      Matrix3d edges;
      for (int k = 1; k < 4; ++k) edges.col(k - 1) = Node(mesh, e, k) - Node(mesh, e, 0);
      const Vector3d local = edges.inverse() * (p - Node(mesh, e, 0));
      const Eigen::Vector4d barycentric(1 - local.sum(), local[0], local[1], local[2]);
      double distance = 0;
      if (barycentric.minCoeff() < 0) {
        distance = std::numeric_limits<double>::infinity();
        for (const auto& face : kFaces) {
          const Vector3d on_face = ClosestOnTriangle(p, Node(mesh, e, face[0]),
                                                     Node(mesh, e, face[1]), Node(mesh, e, face[2]))
                                       .point;
          distance = std::min(distance, (on_face - p).norm());
        }
      }
      if (distance < best.distance) best = {e, barycentric, distance};
    }
    found[static_cast<std::size_t>(i)] = best;
  }
  return found;
}

Eigen::VectorXd ShapeFunctions(bool quadratic, const Eigen::Vector4d& barycentric) {
  if (!quadratic) return barycentric;
  Eigen::VectorXd values(10);
  for (int k = 0; k < 4; ++k) values[k] = barycentric[k] * (2 * barycentric[k] - 1);
  for (int k = 0; k < 6; ++k) {
    values[4 + k] = 4 * barycentric[kTetraEdges[k][0]] * barycentric[kTetraEdges[k][1]];
  }
  return values;
}

}  // namespace hpdm
