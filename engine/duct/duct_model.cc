#include "engine/duct/duct_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "engine/base/error.h"
#include "engine/contact/surface_kernel.h"
#include "engine/mesh/collision.h"
#include "engine/mesh/winding_number.h"
#include "engine/tissue/support.h"

namespace hpdm {
namespace {

constexpr int kPointsOfSpan = 64;  // of the curve between two points of the path
constexpr int kPolarIterations = 12;
constexpr double kLeastDeterminant = 0.05;
// The rod is thin: its path is longer than so many radii.
constexpr double kLeastSlenderness = 4;
// Ends nearer than this share of the control points' spacing have rows that depend on each other.
constexpr double kLeastDistance = 0.02;

std::string DuctTitle(const DuctOptions& options) { return "duct \"" + options.name + "\": "; }

template <typename... Values>
std::string DuctText(const char* format, Values... values) {
  char text[240];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

Points CheckedPath(const DuctOptions& options, int segments) {
  const Points path = EvenPath(options.path_W, segments);
  double length = 0;
  for (Eigen::Index i = 0; i + 1 < path.rows(); ++i) {
    length += (path.row(i + 1) - path.row(i)).norm();
  }
  if (!(length > kLeastSlenderness * options.radius)) {
    throw InputError(DuctTitle(options) +
                     DuctText("its path is %.3g mm long; give more than %g radii, %.3g mm",
                              1000 * length, kLeastSlenderness,
                              1000 * kLeastSlenderness * options.radius));
  }
  for (Eigen::Index i = 1; i + 1 < path.rows(); ++i) {
    const Vector3d before = path.row(i) - path.row(i - 1), after = path.row(i + 1) - path.row(i);
    if (before.dot(after) > 0) continue;
    throw InputError(DuctTitle(options) +
                     DuctText("its path turns by more than 90 degrees at [%.4f, %.4f, %.4f]; give "
                              "points that follow each other",
                              path(i, 0), path(i, 1), path(i, 2)));
  }
  return path;
}

// Fills the rows of an end of the organ. Throws InputError if the end lies in the air.
DuctModel::Hold HoldBy(const DuctOptions& options, const OrganModel& organ, bool first) {
  const Points& path = options.path_W;
  const Vector3d p_W = path.row(first ? 0 : path.rows() - 1);
  const SurfaceMesh& rest = organ.rest();
  const bool inside = WindingNumber(rest).At(p_W) > 0.5;
  const SurfaceTree tree(rest.vertices, rest.triangles);
  const SurfaceHit hit = tree.Closest(p_W, 10);
  if (!inside && !(hit.at.triangle >= 0 && hit.distance <= options.radius)) {
    throw InputError(
        DuctTitle(options) +
        DuctText("its end %s at [%.4f, %.4f, %.4f] lies in the air, %.3g mm off organ \"%s\"; move "
                 "it into the organ or within the duct's radius of its surface",
                 first ? "a" : "b", p_W.x(), p_W.y(), p_W.z(), 1000 * hit.distance,
                 organ.options().name.c_str()));
  }
  DuctModel::Hold hold;
  if (organ.rigid()) return hold;
  const Lattice& lattice = organ.lattice_organ()->lattice();
  hold.length = ControlPointSpacing(lattice);
  // The material point that the end belongs to; outside, the nearest one below the surface.
  Vector3d material_W = p_W;
  if (!inside) {
    const auto corner = [&](int k) -> Vector3d {
      return rest.vertices.row(rest.triangles(hit.at.triangle, k));
    };
    const Vector3d normal_W = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    material_W =
        hit.at.Position(rest.vertices, rest.triangles) - std::max(lattice.inset(), 1e-6) * normal_W;
  }
  const Vector3d arm_W = p_W - material_W;
  std::vector<Eigen::Vector4d> dense(ToSize(organ.control_points()), Eigen::Vector4d::Zero());
  lattice.ForEachFunction(material_W, [&](int column, double value) {
    if (column >= 0) dense[ToSize(column)][0] += value;
  });
  lattice.ForEachGradient(material_W, [&](int column, const Vector3d& gradient) {
    if (column < 0) return;
    dense[ToSize(column)][0] += gradient.dot(arm_W);
    dense[ToSize(column)].tail<3>() += hold.length * gradient;
  });
  for (std::size_t c = 0; c < dense.size(); ++c) {
    if (dense[c].isZero(0)) continue;
    for (int r = 0; r < DuctModel::Hold::kRows; ++r) {
      hold.rows[ToSize(r)].emplace_back(static_cast<int>(c), dense[c][r]);
    }
  }
  return hold;
}

}  // namespace

Points EvenPath(const Points& path, int segments) {
  // Catmull and Rom's curve, centripetal: it has no loops between the points.
  const auto point = [&](Eigen::Index i) -> Vector3d {
    const Eigen::Index last = path.rows() - 1;
    if (i < 0) return 2 * path.row(0) - path.row(1);
    if (i > last) return 2 * path.row(last) - path.row(last - 1);
    return path.row(i);
  };
  std::vector<Vector3d> curve;
  for (Eigen::Index i = 0; i + 1 < path.rows(); ++i) {
    const Vector3d p0 = point(i - 1), p1 = point(i), p2 = point(i + 1), p3 = point(i + 2);
    const double d1 = std::sqrt((p1 - p0).norm()), d2 = std::sqrt((p2 - p1).norm()),
                 d3 = std::sqrt((p3 - p2).norm());
    if (d2 == 0) continue;
    const Vector3d m1 = d1 == 0 ? Vector3d(p2 - p1)
                                : Vector3d(p2 - p1 + d2 * ((p1 - p0) / d1 - (p2 - p0) / (d1 + d2)));
    const Vector3d m2 = d3 == 0 ? Vector3d(p2 - p1)
                                : Vector3d(p2 - p1 + d2 * ((p3 - p2) / d3 - (p3 - p1) / (d2 + d3)));
    for (int k = 0; k < kPointsOfSpan; ++k) {
      const double t = static_cast<double>(k) / kPointsOfSpan, s = 1 - t;
      curve.emplace_back((1 + 2 * t) * s * s * p1 + t * s * s * m1 + t * t * (3 - 2 * t) * p2 -
                         t * t * s * m2);
    }
  }
  curve.emplace_back(path.row(path.rows() - 1));
  std::vector<double> arc(curve.size(), 0);
  for (std::size_t i = 1; i < curve.size(); ++i) {
    arc[i] = arc[i - 1] + (curve[i] - curve[i - 1]).norm();
  }
  Points even(segments + 1, 3);
  std::size_t at = 0;
  for (int i = 0; i <= segments; ++i) {
    const double s = arc.back() * i / segments;
    while (at + 2 < arc.size() && arc[at + 1] < s) ++at;
    const double step = at + 1 < arc.size() ? arc[at + 1] - arc[at] : 0;
    const double share = step > 0 ? std::clamp((s - arc[at]) / step, 0.0, 1.0) : 0;
    const Vector3d& next = curve[std::min(at + 1, curve.size() - 1)];
    even.row(i) = (curve[at] + share * (next - curve[at])).transpose();
  }
  even.row(0) = path.row(0);
  even.row(segments) = path.row(path.rows() - 1);
  return even;
}

void RefuseSharedEnds(const DuctModel& first, const DuctModel& second) {
  for (std::size_t f = 0; f < 2; ++f) {
    for (std::size_t s = 0; s < 2; ++s) {
      const std::string& organ = f == 0 ? first.options.a : first.options.b;
      if (organ != (s == 0 ? second.options.a : second.options.b)) continue;
      if (!first.IsHeldByLattice(f) || !second.IsHeldByLattice(s)) continue;
      const Vector3d& p_W = second.rod.rest_ends()[s].p_W;
      const double distance = (first.rod.rest_ends()[f].p_W - p_W).norm();
      const double least = kLeastDistance * second.holds[s].length;
      if (distance >= least) continue;
      throw InputError(
          DuctTitle(second.options) +
          DuctText("its end at [%.4f, %.4f, %.4f] is %.3g mm from an end of duct \"%s\" "
                   "in organ \"%s\"; move it at least %.3g mm away",
                   p_W.x(), p_W.y(), p_W.z(), 1000 * distance, first.options.name.c_str(),
                   organ.c_str(), 1000 * least));
    }
  }
}

DuctModel::DuctModel(const DuctOptions& duct, const OrganModel* a, const OrganModel* b, int number,
                     int segments)
    : options(duct),
      index(number),
      section(duct.young, duct.radius, duct.wall, kDuctPoisson),
      rod(CheckedPath(duct, segments), section) {
  if (a != nullptr) holds[0] = HoldBy(duct, *a, true);
  if (b != nullptr) holds[1] = HoldBy(duct, *b, false);
}

EndMotion EndMotionOf(const Rod::Frame& rest, double length, const Eigen::Matrix<double, 12, 1>& w,
                      const Matrix3d& turn) {
  Matrix3d F = Matrix3d::Identity();
  for (int k = 0; k < 3; ++k) F.col(k) += w.segment<3>(3 + 3 * k) / length;
  Matrix3d R = turn;
  if (F.determinant() > kLeastDeterminant && !w.tail<9>().isZero(0)) {
    // Higham's iteration for the polar rotation.
    R = F;
    for (int i = 0; i < kPolarIterations; ++i) {
      R = ((R + R.inverse().transpose()) / 2).eval();
    }
  } else if (w.tail<9>().isZero(0)) {
    R = Matrix3d::Identity();
  }
  EndMotion motion;
  motion.frame.p_W = rest.p_W + w.head<3>();
  motion.frame.R_W = R * rest.R_W;
  motion.turn = R;
  // dR = [turn]x R with turn = R (tr(S) I - S)^-1 axial(R^T dF - dF^T R), S = R^T F.
  const Matrix3d S = (R.transpose() * F + F.transpose() * R) / 2;
  const Matrix3d spread = S.trace() * Matrix3d::Identity() - S;
  const Matrix3d from_axial = std::abs(spread.determinant()) > kLeastDeterminant
                                  ? Matrix3d(R * spread.inverse())
                                  : Matrix3d(R / 2);
  motion.map.setZero();
  motion.map.topLeftCorner<3, 3>().setIdentity();
  for (int k = 0; k < 3; ++k) {
    // axial(a e_k^T - e_k a^T) = e_k x a
    Matrix3d cross;
    for (int c = 0; c < 3; ++c) cross.col(c) = Vector3d::Unit(k).cross(Vector3d::Unit(c));
    motion.map.block<3, 3>(3, 3 + 3 * k) = from_axial * cross * R.transpose() / length;
  }
  return motion;
}

}  // namespace hpdm
