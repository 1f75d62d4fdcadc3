#include "engine/lattice/cut_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "engine/base/error.h"
#include "engine/mesh/closest_point.h"
#include "engine/mesh/winding_number.h"

namespace hpdm {
namespace {

using CutPoint = CutSurface::GridPoint;
__extension__ using Wide = __int128;

constexpr double kCutGrid = 1 << 30;
// Parts of the box's longest side in which a border is looked at for tissue.
constexpr double kBorderParts = 256;
// The same for the cut.
constexpr double kCutParts = 64;
// Sides of the box up to which integers of 128 bits hold the determinants.
constexpr double kMostReach = 500;
// Border nearer to the organ's surface than this share of the longest side counts as outside: a
// strip may end on the surface itself.
constexpr double kOnSurface = 1e-5;

CutPoint CutMinus(const CutPoint& a, const CutPoint& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

// Sign of the volume of (a, b, c, d); 0 if they lie in a plane.
int Orientation(const CutPoint& a, const CutPoint& b, const CutPoint& c, const CutPoint& d) {
  const CutPoint u = CutMinus(b, a), v = CutMinus(c, a), w = CutMinus(d, a);
  const auto minor = [&](int i, int j) { return Wide{u[i]} * v[j] - Wide{u[j]} * v[i]; };
  const Wide volume = minor(1, 2) * w[0] + minor(2, 0) * w[1] + minor(0, 1) * w[2];
  return (volume > 0) - (volume < 0);
}

bool SegmentCrosses(const std::array<CutPoint, 3>& triangle, const CutPoint& p, const CutPoint& q) {
  for (int d = 0; d < 3; ++d) {
    const auto [low, high] = std::minmax({triangle[0][d], triangle[1][d], triangle[2][d]});
    if (std::max(p[d], q[d]) < low || std::min(p[d], q[d]) > high) return false;
  }
  const auto& [a, b, c] = triangle;
  if ((Orientation(a, b, c, p) >= 0) == (Orientation(a, b, c, q) >= 0)) return false;
  const int ab = Orientation(p, q, a, b), bc = Orientation(p, q, b, c),
            ca = Orientation(p, q, c, a);
  // Edges count as inside, so no segment slips between two triangles.
  return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
}

}  // namespace

CutSurface::CutSurface(const OrientedBox& box_W, const CutOptions& strip, const SurfaceMesh& rest_W)
    : box_(box_W) {
  const std::string place =
      "organ \"" + strip.organ + "\": cut[" + std::to_string(strip.number) + "]: ";
  for (const BladeEdge& edge : strip.strip) {
    for (const Vector3d& p : {edge.a, edge.b}) {
      if (box_.ToUnit(p).cwiseProduct(box_.lengths).cwiseAbs().maxCoeff() >
          kMostReach * box_.lengths.maxCoeff()) {
        throw InputError(place + "its strip reaches far beyond the organ; end it near the surface");
      }
    }
  }
  AddTriangles(strip);
  if (triangles_.empty()) {
    throw InputError(place + "its strip has no area; move its edges apart");
  }
  if (CrossesItself()) {
    throw InputError(place +
                     "its strip crosses itself; order its edges along the cut, or give two "
                     "cuts");
  }
  FindNormals();
  FindTissue(rest_W);
  if (samples_.empty() && front_.empty()) {
    throw InputError(place + "its strip meets no tissue; move it into the organ");
  }
}

void CutSurface::AddTriangles(const CutOptions& strip) {
  const auto add = [this](const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const Vector3d normal = (b - a).cross(c - a);
    const std::array<CutPoint, 3> corners = {At(a), At(b), At(c)};
    if (!(normal.norm() > 0) || corners[0] == corners[1] || corners[1] == corners[2] ||
        corners[2] == corners[0]) {
      return;
    }
    triangles_.push_back({a, b, c});
    normals_.push_back(normal.normalized());
    on_grid_.push_back(corners);
  };
  const auto border = [this](const Vector3d& a, const Vector3d& b, std::size_t triangle) {
    if ((b - a).norm() > 0) border_.push_back({a, b, Vector3d::Zero(), Vector3d::Zero(), triangle});
  };
  std::size_t last = 0;  // triangle at the edge before
  for (std::size_t e = 0; e + 1 < strip.strip.size(); ++e) {
    const auto& [a, b] = strip.strip[e];
    const auto& [next_a, next_b] = strip.strip[e + 1];
    const std::size_t before = triangles_.size();
    add(a, b, next_b);
    add(a, next_b, next_a);
    if (triangles_.size() == before) continue;
    last = triangles_.size() - 1;
    if (border_.empty()) border(a, b, before);
    border(b, next_b, before);
    border(a, next_a, last);
  }
  if (!border_.empty()) border(strip.strip.back().a, strip.strip.back().b, last);
}

// Normals at the border's corners are means, so the angle around a bent front has no jumps.
void CutSurface::FindNormals() {
  for (Segment& segment : border_) {
    for (const bool end : {false, true}) {
      const Vector3d& corner = end ? segment.b : segment.a;
      Vector3d sum = Vector3d::Zero();
      for (const Segment& other : border_) {
        if (other.a == corner || other.b == corner) sum += normals_[other.triangle];
      }
      if (!(sum.norm() > 0)) sum = normals_[segment.triangle];
      (end ? segment.normal_b : segment.normal_a) = sum.normalized();
    }
  }
}

bool CutSurface::CrossesItself() const {
  for (const auto& [a, b, c] : on_grid_) {
    for (const auto& other : on_grid_) {
      const auto shared = [&](const CutPoint& p) {
        return std::find(other.begin(), other.end(), p) != other.end();
      };
      for (const auto& [p, q] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
        if (!shared(p) && !shared(q) && SegmentCrosses(other, p, q)) return true;
      }
    }
  }
  return false;
}

void CutSurface::FindTissue(const SurfaceMesh& rest_W) {
  const WindingNumber winding(rest_W);
  const double longest = box_.lengths.maxCoeff();
  const auto inside = [&](const Vector3d& p) {
    if (!(winding.At(p) > 0.5)) return false;
    for (const double offset : {-kOnSurface * longest, kOnSurface * longest}) {
      for (int d = 0; d < 3; ++d) {
        if (!(winding.At(p + offset * Vector3d::Unit(d)) > 0.5)) return false;
      }
    }
    return true;
  };
  for (const Segment& segment : border_) {
    const auto parts =
        static_cast<int>(std::ceil((segment.b - segment.a).norm() / longest * kBorderParts));
    const std::size_t before = front_points_.size();
    for (int part = 0; part < parts; ++part) {
      const Vector3d p = segment.a + (part + 0.5) / parts * (segment.b - segment.a);
      if (inside(p)) front_points_.push_back(p);
    }
    if (front_points_.size() > before) front_.push_back(segment);
  }
  for (Triangle triangle : triangles_) {
    // The edge b c is the shortest, so slender triangles get few samples across.
    const auto length = [&](std::size_t k) {
      return (triangle[(k + 1) % 3] - triangle[(k + 2) % 3]).norm();
    };
    const std::size_t first = length(0) <= std::min(length(1), length(2))   ? 0
                              : length(1) <= std::min(length(0), length(2)) ? 1
                                                                            : 2;
    std::rotate(triangle.begin(), triangle.begin() + static_cast<std::ptrdiff_t>(first),
                triangle.end());
    const auto& [a, b, c] = triangle;
    const auto parts = [&](double size) {
      return static_cast<int>(std::clamp(std::ceil(size / longest * kCutParts), 1.0, 4096.0));
    };
    const int along = parts((b - a).norm()), across = parts((c - b).norm());
    const double area = (b - a).cross(c - a).norm() / (along * across);
    for (int i = 0; i < along; ++i) {
      const double s = (i + 0.5) / along;
      for (int j = 0; j < across; ++j) {
        const Vector3d p = a + s * (b - a + (j + 0.5) / across * (c - b));
        if (inside(p)) samples_.push_back({p, s * area});
      }
    }
  }
}

CutPoint CutSurface::AtUnit(const Vector3d& c) const {
  const double scale = kCutGrid / box_.lengths.maxCoeff();
  CutPoint p;
  for (std::size_t d = 0; d < 3; ++d) {
    const auto axis = static_cast<Eigen::Index>(d);
    p[d] = std::llround(c[axis] * box_.lengths[axis] * scale);
  }
  return p;
}

bool CutSurface::Crosses(const CutPoint& p, const CutPoint& q) const {
  return std::any_of(on_grid_.begin(), on_grid_.end(),
                     [&](const auto& triangle) { return SegmentCrosses(triangle, p, q); });
}

bool CrossesAny(const std::vector<CutSurface>& cuts, const CutPoint& p, const CutPoint& q) {
  return std::any_of(cuts.begin(), cuts.end(),
                     [&](const CutSurface& cut) { return cut.Crosses(p, q); });
}

CutSurface::Nearest CutSurface::NearestOnFront(const Vector3d& p_W) const {
  Nearest nearest{p_W, Vector3d::UnitX(), std::numeric_limits<double>::infinity(),
                  Vector3d::UnitX()};
  for (const Segment& segment : front_) {
    const Vector3d along = segment.b - segment.a;
    const double t = ClosestOnSegment(p_W, segment.a, segment.b);
    const Vector3d point = segment.a + t * along;
    const double distance = (p_W - point).norm();
    if (distance >= nearest.distance) continue;
    nearest = {point, ((1 - t) * segment.normal_a + t * segment.normal_b).normalized(), distance,
               along.normalized()};
  }
  return nearest;
}

CutSurface::Nearest CutSurface::NearestOnCut(const Vector3d& p_W) const {
  Nearest nearest{p_W, Vector3d::UnitX(), std::numeric_limits<double>::infinity(),
                  Vector3d::UnitX()};
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& [a, b, c] = triangles_[t];
    const Vector3d point = ClosestOnTriangle(p_W, a, b, c).point;
    const double distance = (p_W - point).norm();
    if (distance < nearest.distance) nearest = {point, normals_[t], distance, nearest.along};
  }
  return nearest;
}

CutSurface::FrontPlace CutSurface::NearestFront(const Vector3d& p_W) const {
  const Nearest nearest = NearestOnFront(p_W);
  return {nearest.distance, nearest.along};
}

FrontValues CutSurface::AtFront(const Vector3d& p_W, const Vector3d& side_W, double h) const {
  FrontValues values;
  if (!has_front()) return values;
  const Nearest front = NearestOnFront(p_W), cut = NearestOnCut(p_W);
  const Vector3d d = p_W - front.point;
  const double r = std::max(front.distance, 1e-9 * h);
  constexpr double kRounding = 1e-9;
  const bool ahead = cut.distance >= front.distance * (1 - kRounding);
  // Local coordinates across the front: n along the cut's normal, x ahead in the cut's surface.
  const Vector3d normal = ahead ? front.normal : cut.normal;
  double n = ahead ? d.dot(normal) : (p_W - cut.point).dot(normal);
  double side = n;
  if (std::abs(n) <= kRounding * h) side = (side_W - cut.point).dot(normal);
  n = std::clamp(std::copysign(std::abs(n), side < 0 ? -1.0 : 1.0), -r, r);
  const double x = (ahead ? 1 : -1) * std::sqrt(r * r - n * n);
  Vector3d forward = d - d.dot(normal) * normal;
  if (!ahead) forward = -forward;
  forward = forward.norm() > kRounding * r ? Vector3d(forward.normalized()) : Vector3d::Zero();
  const double cosine = x / r, sine = n / r;
  const double half_cosine = std::sqrt((1 + cosine) / 2);
  const double half_sine = std::copysign(std::sqrt(std::max(1 - cosine, 0.0) / 2), n);
  const Vector3d outward = cosine * forward + sine * normal;
  const Vector3d around = cosine * normal - sine * forward;
  values.value = {std::sqrt(r / h) * half_sine, std::sqrt(r / h) * half_sine * sine};
  const double scale = 1 / (2 * std::sqrt(r * h));
  values.gradient = {scale * (half_sine * outward + half_cosine * around),
                     scale * (half_sine * sine * outward +
                              (half_cosine * sine + 2 * half_sine * cosine) * around)};
  return values;
}

}  // namespace hpdm
