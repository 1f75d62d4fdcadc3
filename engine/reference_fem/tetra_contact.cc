#include "engine/reference_fem/tetra_contact.h"

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/error.h"
#include "engine/mesh/closest_point.h"

namespace hpdm {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
using Shapes6 = Eigen::Matrix<double, 6, 1>;

constexpr double kLeastFacing = 0.2;  // cosine between a normal and minus the other's

// Flat parts of a face by its six nodes.
constexpr std::array<std::array<int, 3>, 4> kParts = {{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}};
// Places of the six nodes in the face's barycentric coordinates.
const std::array<Vector3d, 6> kPlaces = {Vector3d(1, 0, 0),     Vector3d(0, 1, 0),
                                         Vector3d(0, 0, 1),     Vector3d(0.5, 0.5, 0),
                                         Vector3d(0, 0.5, 0.5), Vector3d(0.5, 0, 0.5)};

Shapes6 FaceShapes(const Vector3d& l) {
  Shapes6 shapes;
  for (int k = 0; k < 3; ++k) {
    shapes[k] = l[k] * (2 * l[k] - 1);
    shapes[3 + k] = 4 * l[k] * l[(k + 1) % 3];
  }
  return shapes;
}

// The lower triangle of the sum of the matrices, degree of freedom i in row place[i].
SparseMatrix LowerPart(const BlockMatrix& K, const BlockMatrix& springs,
                       const std::vector<int>& place) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const BlockMatrix* matrix : {&K, &springs}) {
    for (int i = 0; i < matrix->rows(); ++i) {
      for (int e = matrix->Start(i); e < matrix->Start(i + 1); ++e) {
        for (int k = 0; k < 9; ++k) {
          const int row = place[ToSize(3 * i + k / 3)];
          const int column = place[ToSize(3 * matrix->Column(e) + k % 3)];
          if (row >= column) entries.emplace_back(row, column, matrix->Block(e)(k / 3, k % 3));
        }
      }
    }
  }
  SparseMatrix lower(3 * K.rows(), 3 * K.rows());
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

// An order of elimination: approximate minimum degree, then the degrees of freedom of `last`.
std::vector<int> Places(const BlockMatrix& K, const std::vector<int>& last) {
  std::vector<int> inner(ToSize(K.rows()), 0);
  for (const int node : last) inner[ToSize(node)] = -1;
  std::vector<int> nodes;
  for (int i = 0; i < K.rows(); ++i) {
    if (inner[ToSize(i)] < 0) continue;
    inner[ToSize(i)] = static_cast<int>(nodes.size());
    nodes.push_back(i);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (const int i : nodes) {
    for (int e = K.Start(i); e < K.Start(i + 1); ++e) {
      const int j = K.Column(e);
      if (inner[ToSize(j)] >= 0) entries.emplace_back(inner[ToSize(i)], inner[ToSize(j)], 1.0);
    }
  }
  const auto count = static_cast<Eigen::Index>(nodes.size());
  SparseMatrix graph(count, count);
  graph.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(graph.selfadjointView<Eigen::Lower>(), order);
  std::vector<int> place(ToSize(3 * K.rows()));
  int next = 0;
  const auto put = [&](int node) {
    for (int d = 0; d < 3; ++d) place[ToSize(3 * node + d)] = next++;
  };
  for (Eigen::Index k = 0; k < count; ++k) put(nodes[ToSize(order.indices()[k])]);
  for (const int node : last) put(node);
  return place;
}

// A quadrature point of the first body's zone and the point of the second one's that it faces.
struct FacingPoint {
  const TetraFace* face = nullptr;
  Shapes6 shapes;
  double area = 0;
  Vector3d normal_there = Vector3d::Zero();  // of the second body; zero: faces nothing
  const TetraFace* face_there = nullptr;
  Shapes6 shapes_there;
};

Vector3d At(const TetraFace& face, const Shapes6& shapes, const Points& positions) {
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < 6; ++k) sum += shapes[k] * positions.row(face[k]).transpose();
  return sum;
}

Points Positions(const CondensedTetraBody& body, const Eigen::Ref<const Eigen::VectorXd>& u) {
  return body.rest() + Eigen::Map<const Points>(u.data(), u.size() / 3, 3);
}

// Mean normals of a zone's nodes.
Points ZoneNormals(const CondensedTetraBody& body, const Points& positions) {
  Points normals = Points::Zero(positions.rows(), 3);
  for (const TetraFace& face : body.faces()) {
    for (const auto& part : kParts) {
      const Vector3d a = positions.row(face[part[0]]), b = positions.row(face[part[1]]),
                     c = positions.row(face[part[2]]);
      const Eigen::RowVector3d normal = (b - a).cross(c - a).transpose();
      for (const int k : part) normals.row(face[k]) += normal;
    }
  }
  for (Eigen::Index i = 0; i < normals.rows(); ++i) normals.row(i).normalize();
  return normals;
}

std::vector<FacingPoint> QuadraturePoints(const CondensedTetraBody& body, int splits) {
  std::vector<std::array<Vector3d, 3>> parts = {
      {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()}};
  for (int split = 0; split < splits; ++split) {
    std::vector<std::array<Vector3d, 3>> finer;
    for (const auto& [a, b, c] : parts) {
      const Vector3d ab = (a + b) / 2, bc = (b + c) / 2, ca = (c + a) / 2;
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    parts = finer;
  }
  std::vector<FacingPoint> points;
  for (const TetraFace& face : body.faces()) {
    const Vector3d a = body.rest().row(face[0]), b = body.rest().row(face[1]),
                   c = body.rest().row(face[2]);
    const double area = (b - a).cross(c - a).norm() / 2 / (3.0 * static_cast<double>(parts.size()));
    for (const auto& part : parts) {
      for (int k = 0; k < 3; ++k) {
        FacingPoint point;
        point.face = &face;
        point.shapes =
            FaceShapes(part[k] * (2.0 / 3) + (part[(k + 1) % 3] + part[(k + 2) % 3]) / 6);
        point.area = area;
        points.push_back(point);
      }
    }
  }
  return points;
}

// Finds the closest facing point of `second` for each point of `first`, at the given shapes.
void FindFacing(const CondensedTetraBody& first, const Points& x_first,
                const CondensedTetraBody& second, const Points& x_second,
                std::vector<FacingPoint>* points) {
  const Points normals_first = ZoneNormals(first, x_first);
  const Points normals_second = ZoneNormals(second, x_second);
  for (FacingPoint& point : *points) {
    const Vector3d p = At(*point.face, point.shapes, x_first);
    const Vector3d normal = At(*point.face, point.shapes, normals_first).normalized();
    double best = std::numeric_limits<double>::infinity();
    point.face_there = nullptr;
    for (const TetraFace& face : second.faces()) {
      for (const auto& part : kParts) {
        const Vector3d a = x_second.row(face[part[0]]), b = x_second.row(face[part[1]]),
                       c = x_second.row(face[part[2]]);
        const Vector3d there = (b - a).cross(c - a);
        if (-there.dot(normal) < kLeastFacing * there.norm()) continue;
        const TrianglePoint closest = ClosestOnTriangle(p, a, b, c);
        const double distance2 = (closest.point - p).squaredNorm();
        if (distance2 >= best) continue;
        best = distance2;
        Vector3d place = Vector3d::Zero();
        for (int k = 0; k < 3; ++k) place += closest.barycentric[k] * kPlaces[part[k]];
        point.face_there = &face;
        point.shapes_there = FaceShapes(place);
      }
    }
    if (point.face_there == nullptr) continue;
    point.normal_there = At(*point.face_there, point.shapes_there, normals_second).normalized();
    // Beside the zone's edge there is nothing to touch.
    const Vector3d offset = p - At(*point.face_there, point.shapes_there, x_second);
    const double along = offset.dot(point.normal_there);
    if ((offset - along * point.normal_there).norm() > 0.5 * std::abs(along) + 1e-4) {
      point.face_there = nullptr;
    }
  }
}

}  // namespace

std::vector<TetraFace> BoundaryFaces(const TetraMesh& mesh) {
  HPDM_CHECK(mesh.quadratic());
  constexpr std::array<std::array<int, 3>, 4> kCorners = {
      {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};  // outwards
  std::map<std::pair<int, int>, int> middles;
  std::map<std::array<int, 3>, std::pair<int, std::array<int, 3>>> uses;
  for (Eigen::Index e = 0; e < mesh.elements.rows(); ++e) {
    for (int k = 0; k < 6; ++k) {
      const auto [a, b] = kTetraEdges[ToSize(k)];
      middles[std::minmax(int{mesh.elements(e, a)}, int{mesh.elements(e, b)})] =
          mesh.elements(e, 4 + k);
    }
    for (const auto& corners : kCorners) {
      std::array<int, 3> face, sorted;
      for (int k = 0; k < 3; ++k) face[k] = sorted[k] = mesh.elements(e, corners[k]);
      std::sort(sorted.begin(), sorted.end());
      auto& use = uses[sorted];
      ++use.first;
      use.second = face;
    }
  }
  std::vector<TetraFace> faces;
  for (const auto& [key, use] : uses) {
    if (use.first != 1) continue;
    const auto& [a, b, c] = use.second;
    const auto middle = [&](int i, int j) { return middles.at(std::minmax(i, j)); };
    faces.push_back({a, b, c, middle(a, b), middle(b, c), middle(c, a)});
  }
  return faces;
}

struct CondensedTetraBody::Factor {
  std::vector<int> place;  // of each degree of freedom; the zone's are the last, in their order
  Eigen::SimplicialLLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>> llt;

  Eigen::VectorXd Solve(const Eigen::VectorXd& b) const {
    Eigen::VectorXd placed(b.size()), x(b.size());
    for (Eigen::Index i = 0; i < b.size(); ++i) placed[place[ToSize(i)]] = b[i];
    placed = llt.solve(placed).eval();
    for (Eigen::Index i = 0; i < b.size(); ++i) x[i] = placed[place[ToSize(i)]];
    return x;
  }
};

CondensedTetraBody::~CondensedTetraBody() = default;
CondensedTetraBody::CondensedTetraBody(CondensedTetraBody&&) noexcept = default;

CondensedTetraBody::CondensedTetraBody(const TetraBody& body, const TetraProblem& problem,
                                       const std::vector<TetraFace>& zone)
    : body_(&body), faces_(zone), factor_(std::make_unique<Factor>()) {
  HPDM_CHECK(body.law() == TetraLaw::kSmallStrain);
  for (const TetraFace& face : zone) nodes_.insert(nodes_.end(), face.begin(), face.end());
  std::sort(nodes_.begin(), nodes_.end());
  nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
  for (TetraFace& face : faces_) {
    for (int& node : face) {
      node =
          static_cast<int>(std::lower_bound(nodes_.begin(), nodes_.end(), node) - nodes_.begin());
    }
  }
  rest_ = body.mesh().nodes(nodes_, Eigen::all);

  const int count = static_cast<int>(body.mesh().nodes.rows());
  BlockMatrix K(body.mesh().elements, count);
  body.SetHessian(Points::Zero(count, 3), false, &K);
  factor_->place = Places(K, nodes_);
  factor_->llt.compute(LowerPart(K, problem.springs, factor_->place));
  if (factor_->llt.info() != Eigen::Success) {
    throw InputError("nothing holds a body of the contact; add supports");
  }
  Points forces = problem.forces;
  for (const TetraLoad& load : problem.loads) {
    HPDM_CHECK(load.force);
    for (const auto& [node, weight] : load.patch) {
      forces.row(node) += weight * load.force->transpose();
    }
  }
  loads_ = Eigen::Map<const Eigen::VectorXd>(forces.data(), forces.size());
  const Eigen::VectorXd u = factor_->Solve(loads_);
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(nodes_.size());
  u_0_.resize(size);
  for (Eigen::Index i = 0; i < size; ++i) u_0_[i] = u[3 * nodes_[ToSize(i / 3)] + i % 3];
  // The unknowns that are eliminated last leave the Schur complement.
  const SparseMatrix L = factor_->llt.matrixL();
  const Eigen::MatrixXd L_zone = Eigen::MatrixXd(L.bottomRightCorner(size, size));
  stiffness_ = L_zone * L_zone.transpose();
}

Points CondensedTetraBody::Displacements(const Eigen::VectorXd& forces) const {
  Eigen::VectorXd all = loads_;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    all.segment<3>(3 * nodes_[i]) += forces.segment<3>(3 * static_cast<Eigen::Index>(i));
  }
  const Eigen::VectorXd u = factor_->Solve(all);
  return Eigen::Map<const Points>(u.data(), u.size() / 3, 3);
}

TetraContactSolution SolveTetraContact(const CondensedTetraBody& first,
                                       const CondensedTetraBody& second,
                                       const TetraContactOptions& options) {
  const Eigen::Index n_first = first.unloaded().size(), n = n_first + second.unloaded().size();
  Eigen::VectorXd u_0(n);
  u_0 << first.unloaded(), second.unloaded();
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(n, n);
  S.topLeftCorner(n_first, n_first) = first.stiffness();
  S.bottomRightCorner(n - n_first, n - n_first) = second.stiffness();
  std::vector<FacingPoint> points = QuadraturePoints(first, options.splits);
  double area = 0;
  for (const FacingPoint& point : points) area += point.area;
  const double size = std::sqrt(area / static_cast<double>(first.faces().size()));
  const double k = options.penalty *
                   std::min(first.body().options().young, second.body().options().young) / size;

  // The derivative of a point's gap, sparse.
  const auto for_each_entry = [&](const FacingPoint& point, const auto& visit) {
    for (int i = 0; i < 6; ++i) {
      for (int d = 0; d < 3; ++d) {
        visit(3 * (*point.face)[i] + d, point.shapes[i] * point.normal_there[d]);
        visit(n_first + 3 * (*point.face_there)[i] + d,
              -point.shapes_there[i] * point.normal_there[d]);
      }
    }
  };
  const auto gap = [&](const FacingPoint& point, const Eigen::VectorXd& u) {
    const Points x_first = first.rest(), x_second = second.rest();
    double sum = point.normal_there.dot(At(*point.face, point.shapes, x_first) -
                                        At(*point.face_there, point.shapes_there, x_second));
    for_each_entry(point, [&](Eigen::Index i, double value) { sum += value * u[i]; });
    return sum;
  };

  TetraContactSolution solution;
  Eigen::VectorXd u = u_0;
  for (; solution.rounds < options.most_rounds && !solution.converged; ++solution.rounds) {
    FindFacing(first, Positions(first, u.head(n_first)), second,
               Positions(second, u.tail(n - n_first)), &points);
    const Eigen::VectorXd last = u;
    std::vector<char> touching(points.size(), 2);
    for (int newton = 0; newton < 50; ++newton) {
      bool changed = false;
      Eigen::MatrixXd A = S;
      Eigen::VectorXd b = S * u_0;
      for (std::size_t q = 0; q < points.size(); ++q) {
        if (points[q].face_there == nullptr) continue;
        const double g = gap(points[q], u);
        const char now = g < 0 ? 1 : 0;
        changed = changed || now != touching[q];
        touching[q] = now;
        if (now == 0) continue;
        double constant = g;
        for_each_entry(points[q], [&](Eigen::Index i, double v) { constant -= v * u[i]; });
        for_each_entry(points[q], [&](Eigen::Index i, double v) {
          b[i] -= k * points[q].area * constant * v;
          for_each_entry(points[q],
                         [&](Eigen::Index j, double w) { A(i, j) += k * points[q].area * v * w; });
        });
      }
      if (!changed) break;
      u = A.llt().solve(b);
    }
    solution.converged =
        (u - last).lpNorm<Eigen::Infinity>() < options.tolerance * u.lpNorm<Eigen::Infinity>();
  }

  const Points x_first = Positions(first, u.head(n_first));
  for (const FacingPoint& point : points) {
    if (point.face_there == nullptr) continue;
    const double g = gap(point, u);
    if (g >= 0) continue;
    solution.points.push_back({At(*point.face, point.shapes, x_first), point.area, -k * g, -g});
    solution.force_W -= -k * g * point.area * point.normal_there;
    solution.area += point.area;
    solution.largest_penetration = std::max(solution.largest_penetration, -g);
  }
  const Eigen::VectorXd forces = S * (u - u_0);
  solution.u = {first.Displacements(forces.head(n_first)),
                second.Displacements(forces.tail(n - n_first))};
  return solution;
}

}  // namespace hpdm
