#include "engine/tissue/notch_finder.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "engine/mesh/collision.h"
#include "engine/mesh/mesh_edges.h"
#include "engine/mesh/mesh_facts.h"

namespace hpdm {
namespace {

constexpr double kWidest = 1.5;            // of a gap between facing walls, in cells
constexpr double kOpposite = -0.8;         // cosine between the normals of facing walls
constexpr double kLike = 0.7;              // the same of neighbouring places
constexpr double kFloodWidth = 4;          // largest width of a gap towards its sides, in cells
constexpr double kLeastDepth = 0.5;        // in cells
constexpr double kLeastSlenderness = 1.5;  // depth over width
constexpr double kOneSided = 0.3;          // mean of the unit directions in which a gap ends
constexpr double kNarrow = 1.0 / 64;  // of the organ: the voxels of SampleTissue may miss a gap
constexpr double kLength = 1.5;       // of the strip, in cells
constexpr double kBelow = 0.07;       // depth of the front below the gap's end, in widths
constexpr double kLinesAcross = 200;  // at most, along the organ
constexpr double kShortest = 0.25;    // least share of the deepest line's depth

/// A place of the surface that faces another wall.
struct FacingPlace {
  Vector3d middle;  ///< Of the gap, m.
  Vector3d normal;  ///< Of the surface, unit.
  double width;     ///< m.
  double area;      ///< m^2.
};

std::vector<FacingPlace> FacingPlaces(const SurfaceMesh& mesh, const SurfaceTree& tree,
                                      double most) {
  std::vector<FacingPlace> places;
  const auto normal_of = [&mesh](Eigen::Index t) {
    return TwiceAreaNormal(mesh.vertices, mesh.triangles, t);
  };
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Vector3d twice = normal_of(t);
    if (!(twice.norm() > 0)) continue;
    const Vector3d normal = twice.normalized();
    std::array<Vector3d, 3> corner;
    for (int k = 0; k < 3; ++k) {
      corner[static_cast<std::size_t>(k)] = mesh.vertices.row(mesh.triangles(t, k));
    }
    const auto& [a, b, c] = corner;
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const int parts = static_cast<int>(std::clamp(std::ceil(2 * longest / most), 1.0, 8.0));
    for (int i = 0; i < parts; ++i) {
      for (int j = 0; j < 2 * (parts - i) - 1; ++j) {  // triangles of a row, up and down
        const double third = (j % 2 == 0 ? 1.0 : 2.0) / 3;
        const Vector3d p = a + (i + third) / parts * (b - a) + (j / 2 + third) / parts * (c - a);
        const SurfaceHit hit = tree.FirstEntry(p + 1e-6 * most * normal, p + most * normal);
        if (hit.at.triangle < 0) continue;
        const Vector3d opposite = normal_of(hit.at.triangle).normalized();
        if (!(normal.dot(opposite) < kOpposite)) continue;
        const double width = hit.along * most;
        places.push_back(
            {p + width / 2 * normal, normal, width, twice.norm() / 2 / (parts * parts)});
      }
    }
  }
  return places;
}

/// Returns the places of each gap: neighbours within `reach` (m) with like normals.
std::vector<std::vector<FacingPlace>> Gaps(const std::vector<FacingPlace>& places, double reach) {
  using Key = std::array<long, 3>;
  const auto key_of = [reach](const Vector3d& p) {
    return Key{std::lround(p.x() / reach), std::lround(p.y() / reach), std::lround(p.z() / reach)};
  };
  std::map<Key, std::vector<int>> near;
  DisjointSets sets(static_cast<int>(places.size()));
  for (int i = 0; i < static_cast<int>(places.size()); ++i) {
    const FacingPlace& place = places[static_cast<std::size_t>(i)];
    const Key key = key_of(place.middle);
    for (int n = 0; n < 27; ++n) {
      const auto found =
          near.find({key[0] + n % 3 - 1, key[1] + n / 3 % 3 - 1, key[2] + n / 9 - 1});
      if (found == near.end()) continue;
      for (const int j : found->second) {
        const FacingPlace& other = places[static_cast<std::size_t>(j)];
        if ((place.middle - other.middle).norm() <= reach &&
            std::abs(place.normal.dot(other.normal)) > kLike) {
          sets.Merge(i, j);
        }
      }
    }
    near[key].push_back(i);
  }
  std::map<int, std::vector<FacingPlace>> gaps;
  for (int i = 0; i < static_cast<int>(places.size()); ++i) {
    gaps[sets.Find(i)].push_back(places[static_cast<std::size_t>(i)]);
  }
  std::vector<std::vector<FacingPlace>> sorted;
  for (auto& [first, gap] : gaps) sorted.push_back(std::move(gap));
  return sorted;
}

/// A part of a line that lies outside the tissue, m along the line.
struct Outside {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  double Width() const { return high - low; }
  double Middle() const { return (low + high) / 2; }
};

/// Parallel lines through an organ, on a square grid, and the parts of them that are in a gap.
class GapLines {
 public:
  /// `axes`: columns are the grid's directions and the lines' own. `spacing`: of the lines, m.
  GapLines(const SurfaceMesh& mesh, const Matrix3d& axes, double spacing)
      : axes_(axes), spacing_(spacing) {
    const Points local = mesh.vertices * axes;
    const Eigen::RowVector3d low = local.colwise().minCoeff(), high = local.colwise().maxCoeff();
    // Lines keep off the edges of meshes on regular grids.
    first_ = Eigen::Vector2d(low.x(), low.y()).array() - 0.6180339887 * spacing;
    for (int d = 0; d < 2; ++d) {
      count_[static_cast<std::size_t>(d)] = static_cast<int>((high[d] - first_[d]) / spacing) + 2;
    }
    std::vector<std::vector<std::pair<double, int>>> crossings(Lines());
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
      AddCrossings(local, mesh.triangles.row(t), &crossings);
    }
    outside_.resize(Lines());
    for (std::size_t line = 0; line < Lines(); ++line) {
      std::sort(crossings[line].begin(), crossings[line].end());
      int depth = 0;
      Outside part;
      for (const auto& [along, enters] : crossings[line]) {
        if (depth == 0 && enters > 0) {
          part.high = along;
          outside_[line].push_back(part);
        }
        depth += enters;
        if (depth == 0) part = {along};
      }
      part.high = std::numeric_limits<double>::infinity();
      outside_[line].push_back(part);
    }
    gap_.resize(Lines());
  }

  double spacing() const { return spacing_; }
  int count(int axis) const { return count_[static_cast<std::size_t>(axis)]; }
  /// The gap's part of a line; absent where there is none.
  const std::optional<Outside>& Gap(int i, int j) const { return gap_[Index(i, j)]; }
  Vector3d At(int i, int j, double along) const {
    return axes_ * Vector3d(first_.x() + i * spacing_, first_.y() + j * spacing_, along);
  }
  /// True if there is tissue on a line; false beyond the grid.
  bool Tissue(int i, int j, double along) const {
    if (!Within(i, j)) return false;
    const std::vector<Outside>& outside = outside_[Index(i, j)];
    return std::none_of(outside.begin(), outside.end(), [along](const Outside& part) {
      return part.low <= along && along <= part.high;
    });
  }

  /// Finds the gap that holds `places`, up to `widest` (m) wide. Returns the mean of the unit
  /// directions on the grid in which it ends in tissue; 0 if it does not.
  Eigen::Vector2d Spread(const std::vector<FacingPlace>& places, double widest) {
    std::vector<std::array<int, 2>> next;
    const auto take = [&](int i, int j, const Outside& part) {
      gap_[Index(i, j)] = part;
      next.push_back({i, j});
    };
    for (const FacingPlace& place : places) {
      const Vector3d p = axes_.transpose() * place.middle;
      const int i = static_cast<int>(std::lround((p.x() - first_.x()) / spacing_)),
                j = static_cast<int>(std::lround((p.y() - first_.y()) / spacing_));
      if (!Within(i, j) || Gap(i, j)) continue;
      for (const Outside& part : outside_[Index(i, j)]) {
        if (part.low < p.z() && p.z() < part.high && part.Width() <= widest) take(i, j, part);
      }
    }
    Eigen::Vector2d ends = Eigen::Vector2d::Zero();
    int ending = 0;
    while (!next.empty()) {
      const auto [i, j] = next.back();
      next.pop_back();
      const Outside here = *Gap(i, j);
      constexpr std::array<std::array<int, 2>, 4> kNeighbours = {
          {{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
      for (const auto& [di, dj] : kNeighbours) {
        if (Tissue(i + di, j + dj, here.Middle())) {
          ends += Eigen::Vector2d(di, dj);
          ++ending;
          continue;
        }
        if (!Within(i + di, j + dj) || Gap(i + di, j + dj)) continue;
        for (const Outside& part : outside_[Index(i + di, j + dj)]) {
          const bool overlaps = part.low < here.high && here.low < part.high;
          if (overlaps && part.Width() <= widest && !Gap(i + di, j + dj))
            take(i + di, j + dj, part);
        }
      }
    }
    return ending > 0 ? Eigen::Vector2d(ends / ending) : Eigen::Vector2d::Zero();
  }

 private:
  std::size_t Lines() const { return static_cast<std::size_t>(count_[0]) * count_[1]; }
  std::size_t Index(int i, int j) const { return static_cast<std::size_t>(i) * count_[1] + j; }
  bool Within(int i, int j) const { return i >= 0 && j >= 0 && i < count_[0] && j < count_[1]; }

  // An edge has the same sign in both of its triangles, so a line beside it crosses one of them.
  static double Side(const Points& local, int from, int to, const Eigen::Vector2d& p) {
    if (from > to) return -Side(local, to, from, p);
    const Eigen::Vector2d a = local.block<1, 2>(from, 0), b = local.block<1, 2>(to, 0);
    return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
  }

  void AddCrossings(const Points& local, const Eigen::RowVector3i& corners,
                    std::vector<std::vector<std::pair<double, int>>>* crossings) const {
    std::array<int, 2> low = {count_[0], count_[1]}, high = {-1, -1};
    for (int k = 0; k < 3; ++k) {
      for (std::size_t d = 0; d < 2; ++d) {
        const auto axis = static_cast<Eigen::Index>(d);
        const double at = (local(corners[k], axis) - first_[axis]) / spacing_;
        low[d] = std::min(low[d], std::max(0, static_cast<int>(std::ceil(at))));
        high[d] = std::max(high[d], std::min(count_[d] - 1, static_cast<int>(std::floor(at))));
      }
    }
    for (int i = low[0]; i <= high[0]; ++i) {
      for (int j = low[1]; j <= high[1]; ++j) {
        const Eigen::Vector2d p(first_.x() + i * spacing_, first_.y() + j * spacing_);
        const Vector3d side(Side(local, corners[1], corners[2], p),
                            Side(local, corners[2], corners[0], p),
                            Side(local, corners[0], corners[1], p));
        const bool positive = (side.array() > 0).all();
        if (!positive && !(side.array() < 0).all()) continue;
        const Vector3d weights = side / side.sum();
        const double along = weights[0] * local(corners[0], 2) + weights[1] * local(corners[1], 2) +
                             weights[2] * local(corners[2], 2);
        (*crossings)[Index(i, j)].emplace_back(along, positive ? -1 : 1);
      }
    }
  }

  Matrix3d axes_;
  double spacing_;
  Eigen::Vector2d first_;
  std::array<int, 2> count_;
  std::vector<std::vector<Outside>> outside_;
  std::vector<std::optional<Outside>> gap_;
};

/// Rows of one column of the grid that lie in the gap; behind the last one there is tissue.
struct GapRows {
  int first = 0, last = -1;
  int Count() const { return last - first + 1; }
};

GapRows MostRows(const GapLines& lines, int column) {
  GapRows most;
  for (int first = 0, i = 0; i < lines.count(0); ++i) {
    if (!lines.Gap(i, column)) {
      first = i + 1;
      continue;
    }
    const bool ends = lines.Tissue(i + 1, column, lines.Gap(i, column)->Middle());
    if (ends && i - first + 1 > most.Count()) most = {first, i};
  }
  return most;
}

/// Returns the first row from `first` on from which a straight line to the last one stays in the gap.
int StraightFrom(const GapLines& lines, int column, int first, int last) {
  constexpr double kOffWall = 0.1;  // of the gap's width
  for (; first < last; ++first) {
    const double from = lines.Gap(first, column)->Middle(), to = lines.Gap(last, column)->Middle();
    bool inside = true;
    for (int i = first; i <= last && inside; ++i) {
      const double along = from + (to - from) * (i - first) / (last - first);
      const Outside& gap = *lines.Gap(i, column);
      inside = std::min(along - gap.low, gap.high - along) >= kOffWall * gap.Width();
    }
    if (inside) break;
  }
  return first;
}

/// Returns the longest run of columns with at least `least` rows: its first and its last.
std::array<int, 2> LongestRun(const std::vector<GapRows>& columns, int least) {
  std::array<int, 2> longest = {0, -1};
  for (int first = 0, j = 0; j < static_cast<int>(columns.size()); ++j) {
    if (columns[static_cast<std::size_t>(j)].Count() < least) {
      first = j + 1;
    } else if (j - first > longest[1] - longest[0]) {
      longest = {first, j};
    }
  }
  return longest;
}

/// Means over the places of a gap.
struct GapShape {
  double area = 0;   ///< Of both walls, m^2.
  double width = 0;  ///< m.
  Vector3d normal;   ///< Of the walls, unit.
};

GapShape ShapeOf(const std::vector<FacingPlace>& places) {
  GapShape shape;
  Matrix3d normals = Matrix3d::Zero();
  for (const FacingPlace& place : places) {
    shape.area += place.area;
    shape.width += place.area * place.width;
    normals += place.area * place.normal * place.normal.transpose();
  }
  shape.width /= shape.area;
  shape.normal = Eigen::SelfAdjointEigenSolver<Matrix3d>(normals).eigenvectors().col(2);
  return shape;
}

/// Finds the notches of one organ's surface.
class NotchFinder {
 public:
  NotchFinder(const SurfaceMesh& mesh, double cell)
      : mesh_(mesh),
        tree_(mesh.vertices, mesh.triangles),
        cell_(cell),
        extent_((mesh.vertices.colwise().maxCoeff() - mesh.vertices.colwise().minCoeff()).norm()) {}

  std::vector<std::vector<BladeEdge>> Strips() const {
    std::vector<std::vector<BladeEdge>> strips;
    const double most = kWidest * cell_;
    for (const std::vector<FacingPlace>& gap : Gaps(FacingPlaces(mesh_, tree_, most), cell_)) {
      std::vector<BladeEdge> strip = StripOf(gap);
      if (!strip.empty()) strips.push_back(std::move(strip));
    }
    return strips;
  }

 private:
  /// Returns the strip in a gap; empty if it is no notch.
  std::vector<BladeEdge> StripOf(const std::vector<FacingPlace>& places) const {
    const GapShape shape = ShapeOf(places);
    const double depth = std::max(kLeastDepth * cell_, kLeastSlenderness * shape.width);
    if (shape.area < depth * depth) return {};
    const double spacing = std::max(shape.width / 4, extent_ / kLinesAcross);
    const double widest = kFloodWidth * cell_;
    const Vector3d& normal = shape.normal;
    Matrix3d axes;
    axes << normal.unitOrthogonal(), normal.cross(normal.unitOrthogonal()), normal;
    const Eigen::Vector2d ends = GapLines(mesh_, axes, spacing).Spread(places, widest);
    if (ends.norm() < kOneSided) return {};

    // The first axis points to the gap's end, so columns are lines of the gap's depth.
    const Vector3d down = (axes.leftCols<2>() * ends).normalized();
    axes << down, normal.cross(down), normal;
    GapLines lines(mesh_, axes, spacing);
    lines.Spread(places, widest);
    std::vector<GapRows> columns;
    int deepest = 0;
    for (int j = 0; j < lines.count(1); ++j) {
      columns.push_back(MostRows(lines, j));
      deepest = std::max(deepest, columns.back().Count());
    }
    if (deepest * spacing < depth) return {};
    const auto [first, last] =
        LongestRun(columns, std::max(2, static_cast<int>(kShortest * deepest)));

    const int step = std::max(1, static_cast<int>(cell_ / 4 / spacing));
    std::vector<BladeEdge> strip;
    for (int j = first; j <= last; j += std::max(1, std::min(step, last - j))) {
      strip.push_back(EdgeAt(lines, j, columns[static_cast<std::size_t>(j)], down, shape.width));
    }
    if (strip.size() < 2) return {};
    // The organ's sides lie up to a line's distance beyond the outermost lines.
    const Vector3d beside = 1.5 * spacing * axes.col(1);
    const BladeEdge front = strip.front(), back = strip.back();
    strip.insert(strip.begin(), {front.a - beside, front.b - beside});
    strip.push_back({back.a + beside, back.b + beside});
    return strip;
  }

  /// Returns an edge from just below the gap's end up along a column.
  BladeEdge EdgeAt(const GapLines& lines, int column, const GapRows& rows, const Vector3d& down,
                   double width) const {
    const double spacing = lines.spacing();
    const int longest = static_cast<int>(kLength * cell_ / spacing);
    const bool whole = width < kNarrow * extent_;
    const int from = whole ? rows.first : std::max(rows.first, rows.last - longest);
    const int first = StraightFrom(lines, column, from, rows.last);
    const Vector3d lowest = lines.At(rows.last, column, lines.Gap(rows.last, column)->Middle());
    const SurfaceHit end = tree_.FirstEntry(lowest, lowest + 3 * spacing * down);
    const double to_end = end.at.triangle < 0 ? spacing : 3 * spacing * end.along;
    const double middle = lines.Gap(first, column)->Middle();
    Vector3d highest = lines.At(first, column, middle);
    // Up through the gap's mouth, which lies between two lines.
    if (whole && !lines.Tissue(first - 1, column, middle)) highest -= 1.5 * spacing * down;
    return {lowest + (to_end + kBelow * width) * down, highest};
  }

  const SurfaceMesh& mesh_;
  SurfaceTree tree_;
  double cell_, extent_;
};

}  // namespace

std::vector<CutOptions> FindNotches(const SurfaceMesh& rest_W, const std::string& organ,
                                    double cell) {
  std::vector<CutOptions> notches;
  if (!ComputeMeshFacts(rest_W).Closed()) return notches;
  for (std::vector<BladeEdge>& strip : NotchFinder(rest_W, cell).Strips()) {
    notches.push_back({.organ = organ, .strip = std::move(strip)});
  }
  return notches;
}

}  // namespace hpdm
