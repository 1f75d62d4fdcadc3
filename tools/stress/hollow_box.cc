#include "tools/stress/hollow_box.h"

#include <cmath>

#include "engine/reference_fem/tetra_fem.h"

namespace hpdm {
namespace {

constexpr int kBricks = 10;  // per edge: a wall, eight inside, a wall

// Meshes the bricks of a box without the inner ones; the planes are moved to the walls.
TetraMesh Walls(double edge, double wall) {
  const TetraMesh whole =
      BoxTetraMesh(Vector3d::Zero(), Vector3d::Constant(kBricks), {kBricks, kBricks, kBricks});
  const auto place = [&](double plane) {
    if (plane < 0.5) return 0.0;
    if (plane > kBricks - 0.5) return edge;
    return wall + (plane - 1) / (kBricks - 2) * (edge - 2 * wall);
  };
  std::vector<int> number(static_cast<std::size_t>(whole.nodes.rows()), -1);
  std::vector<Vector3d> nodes;
  std::vector<int> corners;
  for (Eigen::Index e = 0; e < whole.elements.rows(); ++e) {
    Vector3d centre = Vector3d::Zero();
    for (int k = 0; k < 4; ++k) centre += whole.nodes.row(whole.elements(e, k)).transpose() / 4;
    if (centre.minCoeff() > 1 && centre.maxCoeff() < kBricks - 1) continue;
    for (int k = 0; k < 4; ++k) {
      int& node = number[static_cast<std::size_t>(whole.elements(e, k))];
      if (node < 0) {
        node = static_cast<int>(nodes.size());
        nodes.emplace_back(whole.nodes.row(whole.elements(e, k)).transpose().unaryExpr(place));
      }
      corners.push_back(node);
    }
  }
  Points points(static_cast<Eigen::Index>(nodes.size()), 3);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    points.row(static_cast<Eigen::Index>(n)) = nodes[n].transpose();
  }
  const Tetrahedra elements = Eigen::Map<const Tetrahedra>(
      corners.data(), static_cast<Eigen::Index>(corners.size() / 4), 4);
  return MakeTetraMesh(points, elements, "hollow box");
}

// Returns the outer surface and the reversed inner one.
SurfaceMesh BothSides(double edge, double wall) {
  const SurfaceMesh outer = BoxSurface(Vector3d::Zero(), Vector3d::Constant(edge), {16, 16, 16});
  const SurfaceMesh inner =
      BoxSurface(Vector3d::Constant(wall), Vector3d::Constant(edge - wall), {16, 16, 16});
  SurfaceMesh both;
  both.vertices.resize(outer.vertices.rows() + inner.vertices.rows(), 3);
  both.vertices << outer.vertices, inner.vertices;
  Triangles turned = inner.triangles.array() + static_cast<int>(outer.vertices.rows());
  turned.col(1).swap(turned.col(2));
  both.triangles.resize(outer.triangles.rows() + turned.rows(), 3);
  both.triangles << outer.triangles, turned;
  return both;
}

}  // namespace

HollowBody HollowBox(double edge, double wall, int cells) {
  HollowBody body;
  body.organ = PressedBlock(true).organ;
  body.organ.name = "hollow";
  body.organ.lattice.cells = {cells, cells, cells};
  body.organ.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.1)}, {}}};
  LoadOptions press;
  press.organ = body.organ.name;
  press.p_centre_W = Vector3d(edge / 2, edge / 2, edge);
  press.radius = 0.015;
  // Chooses the load for a displacement of about a hundredth of the edge, as a plate or as a
  // half-space.
  const double young = body.organ.material.young;
  const double plate = young * std::pow(wall, 3) / (0.06 * edge * edge);
  const double solid = young * press.radius;
  press.force_W = Vector3d(0, 0, -0.01 * edge * plate * solid / (plate + solid));
  body.loads = {press};
  body.rest = BothSides(edge, wall);
  body.tetrahedra = Walls(edge, wall);
  return body;
}

StressAnswer TetraRest(const HollowBody& body, bool quadratic) {
  const TetraBody tetra(quadratic ? Quadratic(body.tetrahedra) : body.tetrahedra,
                        body.organ.material, TetraLaw::kSmallStrain);
  const TetraSolution solution =
      SolveTetra(tetra, MakeTetraProblem(tetra, body.rest, body.organ.supports, body.loads));
  return {ApplyRows(PointRows(tetra.mesh(), body.rest.vertices), solution.u), solution.Compliance(),
          1, solution.residual};
}

}  // namespace hpdm
