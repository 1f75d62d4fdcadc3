#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "engine/organ_options.h"
#include "engine/reference_fem/tetra_contact.h"

/// Two soft bodies like a liver's left lobe and the stomach below it, for the reference of their
/// contact (tests/reference/touching_bodies.json) and those that compare themselves with it. They
/// are smooth bricks of known grids, so that no mesher is needed.
namespace hpdm {

struct TouchingBody {
  const char* name;
  Vector3d half_axes;  ///< m.
  Vector3d centre;     ///< m.
  double young;        ///< Pa.
  double held_from;    ///< Fractions of the height: the held part.
  double held_to;
};
inline const std::array<TouchingBody, 2> kTouchingBodies = {
    {{"stomach", Vector3d(0.06, 0.045, 0.03), Vector3d(0.015, 0, -0.03), 20000, 0, 0.3},
     {"lobe", Vector3d(0.08, 0.06, 0.025), Vector3d(0, 0.01, 0.025), 5500, 0.7, 1}}};
inline constexpr double kTouchingPoisson = 0.45;
inline constexpr double kTouchingPress = 0.008;  ///< m, by which the lobe's support moves down.
/// Bricks along each axis: those of the surfaces, of which the reference's are multiples.
inline constexpr std::array<int, 3> kTouchingBricks = {16, 12, 6};

/// A brick with rounded edges, `bricks` x 6 tetrahedra.
inline TetraMesh TouchingMesh(const TouchingBody& body, const std::array<int, 3>& bricks) {
  constexpr double kRound = 0.7;  // 0: a brick, 1: an ellipsoid
  TetraMesh mesh = BoxTetraMesh(Vector3d::Constant(-1), Vector3d::Constant(1), bricks);
  for (Eigen::Index i = 0; i < mesh.nodes.rows(); ++i) {
    Vector3d p = mesh.nodes.row(i);
    const double length = p.norm();
    if (length > 0) p *= std::pow(p.cwiseAbs().maxCoeff() / length, kRound);
    mesh.nodes.row(i) = body.centre + body.half_axes.cwiseProduct(p);
  }
  return MakeTetraMesh(mesh.nodes, mesh.elements, body.name);
}

/// Returns the surface's corners and triangles, outwards. `nodes`: the mesh's node of each vertex.
inline SurfaceMesh TouchingSurface(const TetraMesh& linear, std::vector<int>* nodes) {
  const std::vector<TetraFace> faces = BoundaryFaces(Quadratic(linear));
  std::map<int, int> vertices;
  SurfaceMesh surface;
  surface.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  nodes->clear();
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int node = faces[f][static_cast<std::size_t>(k)];
      const auto [at, added] = vertices.try_emplace(node, static_cast<int>(nodes->size()));
      if (added) nodes->push_back(node);
      surface.triangles(static_cast<Eigen::Index>(f), k) = at->second;
    }
  }
  surface.vertices = linear.nodes(*nodes, Eigen::all);
  return surface;
}

inline OrganOptions TouchingOptions(const TouchingBody& body) {
  OrganOptions options;
  options.name = body.name;
  options.material.young = body.young;
  options.material.poisson = kTouchingPoisson;
  options.energy.type = EnergyType::kStrain;
  options.supports.push_back(
      {BoxFraction{Vector3d(0, 0, body.held_from), Vector3d(1, 1, body.held_to)}, {}});
  return options;
}

}  // namespace hpdm
