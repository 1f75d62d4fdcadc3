#include <array>
#include <map>

#include "engine/base/error.h"
#include "engine/contact/surface_kernel.h"
#include "engine/reference_fem/tetra_fem.h"
#include "engine/tissue/support.h"

namespace hpdm {
namespace {

struct RulePoint {
  Eigen::Vector4d barycentric;
  double weight;
};

/// The 14-point rule of degree five with positive weights (Walkington 2000).
std::array<RulePoint, 14> FourteenPoints() {
  std::array<RulePoint, 14> points;
  std::size_t next = 0;
  for (const auto& [a, weight] : {std::pair(0.31088591926330061, 0.11268792571801585),
                                  std::pair(0.09273525031089123, 0.07349304311636195)}) {
    for (int k = 0; k < 4; ++k) {
      points[next] = {Eigen::Vector4d::Constant(a), weight};
      points[next++].barycentric[k] = 1 - 3 * a;
    }
  }
  constexpr double kEdge = 0.04550370412564965, kEdgeWeight = 0.042546020777081466;
  for (const auto& [a, b] : kTetraEdges) {
    points[next] = {Eigen::Vector4d::Constant(kEdge), kEdgeWeight};
    points[next].barycentric[a] = points[next].barycentric[b] = 0.5 - kEdge;
    ++next;
  }
  return points;
}

constexpr double kFixedPenalty = 1e6;

/// Returns the row of a load's patch.
TetraRow PatchRow(const TetraMesh& mesh, const SurfaceMesh& rest, const LoadOptions& load) {
  const std::vector<SurfaceSample> samples = SurfaceKernel(rest, load.p_centre_W, load.radius);
  Points points(static_cast<Eigen::Index>(samples.size()), 3);
  for (std::size_t s = 0; s < samples.size(); ++s) {
    points.row(static_cast<Eigen::Index>(s)) =
        AtSample(samples[s], rest.triangles, rest.vertices).transpose();
  }
  const std::vector<TetraRow> rows = PointRows(mesh, points);
  std::map<int, double> sum;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    for (const auto& [node, value] : rows[s]) sum[node] += samples[s].weight * value;
  }
  return TetraRow(sum.begin(), sum.end());
}

}  // namespace

TetraProblem EmptyProblem(const TetraBody& body) {
  const int nodes = static_cast<int>(body.mesh().nodes.rows());
  return {BlockMatrix(body.mesh().elements, nodes), Points::Zero(nodes, 3), {}};
}

TetraProblem MakeTetraProblem(const TetraBody& body, const SurfaceMesh& rest,
                              const std::vector<SupportOptions>& supports,
                              const std::vector<LoadOptions>& loads) {
  TetraProblem problem = EmptyProblem(body);
  const TetraMesh& mesh = body.mesh();
  const Box bounds = AxisAlignedBounds(rest.vertices);
  const double length = (bounds.max - bounds.min).mean();
  const double fixed = kFixedPenalty * body.options().young / (length * length);
  const std::array<RulePoint, 14> rule = FourteenPoints();
  std::vector<Eigen::VectorXd> shapes;
  for (const RulePoint& point : rule) {
    shapes.push_back(ShapeFunctions(mesh.quadratic(), point.barycentric));
  }
  std::vector<bool> holds(supports.size(), false);
  for (Eigen::Index e = 0; e < mesh.elements.rows(); ++e) {
    Eigen::Matrix<double, 4, 3> corners;
    for (int k = 0; k < 4; ++k) corners.row(k) = mesh.nodes.row(mesh.elements(e, k));
    Matrix3d edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = (corners.row(k + 1) - corners.row(0)).transpose();
    const double volume = edges.determinant() / 6;
    const Eigen::Index shape_count = mesh.elements.cols();
    Eigen::MatrixXd springs = Eigen::MatrixXd::Zero(shape_count, shape_count);
    bool held = false;
    for (std::size_t q = 0; q < rule.size(); ++q) {
      const Vector3d p_W = corners.transpose() * rule[q].barycentric;
      for (std::size_t s = 0; s < supports.size(); ++s) {
        if (!InRegion(supports[s].region, bounds, p_W)) continue;
        holds[s] = held = true;
        springs += supports[s].stiffness.value_or(fixed) * volume * rule[q].weight * shapes[q] *
                   shapes[q].transpose();
      }
    }
    if (!held) continue;
    for (Eigen::Index a = 0; a < shape_count; ++a) {
      for (Eigen::Index b = 0; b < shape_count; ++b) {
        problem.springs.At(mesh.elements(e, a), mesh.elements(e, b)) +=
            springs(a, b) * Matrix3d::Identity();
      }
    }
  }
  for (std::size_t s = 0; s < supports.size(); ++s) {
    if (!holds[s]) {
      throw InputError("support " + std::to_string(s) +
                       ": holds no tissue of the tetrahedra; enlarge its region");
    }
  }
  for (const LoadOptions& load : loads) {
    if (load.pressure) {
      throw InputError("a pressure is not solved with tetrahedra; give a force or a displacement");
    }
    problem.loads.push_back({PatchRow(mesh, rest, load), load.force_W, load.displacement_W});
  }
  return problem;
}

std::vector<TetraRow> PointRows(const TetraMesh& mesh, const Points& points) {
  const std::vector<TetraPoint> located = Locate(mesh, points);
  std::vector<TetraRow> rows(located.size());
  for (std::size_t i = 0; i < located.size(); ++i) {
    const Eigen::VectorXd values = ShapeFunctions(mesh.quadratic(), located[i].barycentric);
    for (Eigen::Index a = 0; a < values.size(); ++a) {
      rows[i].emplace_back(mesh.elements(located[i].element, a), values[a]);
    }
  }
  return rows;
}

Points ApplyRows(const std::vector<TetraRow>& rows, const Points& u) {
  Points values = Points::Zero(static_cast<Eigen::Index>(rows.size()), 3);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (const auto& [node, weight] : rows[r]) {
      values.row(static_cast<Eigen::Index>(r)) += weight * u.row(node);
    }
  }
  return values;
}

}  // namespace hpdm
