#include "engine/attachment/attachment_bed.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/contact/surface_kernel.h"
#include "engine/mesh/collision.h"
#include "engine/tissue/support.h"

namespace hpdm {
namespace {

// m. The damage of smaller samples would localise below what the lattices resolve.
constexpr double kLeastSide = 0.002;
// Samples at the start, which leaves room for those that the grid cuts off.
constexpr double kWantedSamples = 200;
// Facing normals are at least 120 degrees apart.
constexpr double kFacing = -0.5;
// Cosine of the largest angle between the normal and the way to the other surface: 45 degrees.
constexpr double kOpposite = 0.7;
// Surfaces nearer than this share of the reach touch: their way has no direction.
constexpr double kTouching = 1e-3;
// m: the least way that a leaf spans.
constexpr double kLeastSpan = 0.0005;

std::string AttachmentTitle(const AttachmentOptions& attachment) {
  return "[[attachment]] of organs \"" + attachment.a + "\" and \"" + attachment.b + "\": ";
}

template <typename... Values>
std::string BedText(const char* format, Values... values) {
  char text[240];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

using Facing = AttachmentBed::Facing;

Vector3d FaceNormal(const OrganModel& organ, const SurfacePoint& at) {
  const auto corner = [&](int k) -> Vector3d {
    return organ.rest().vertices.row(organ.rest().triangles(at.triangle, k));
  };
  return (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
}

std::vector<Facing> FacingPoints(const AttachmentOptions& attachment, const OrganModel& a,
                                 const OrganModel& b, const SurfaceTree& tree_b, double side) {
  std::vector<Facing> facing;
  for (const SurfaceSample& sample :
       SurfaceInRegion(a.rest(), attachment.region, AxisAlignedBounds(a.rest().vertices), side)) {
    Facing pair;
    pair.on_a = {sample.triangle, sample.barycentric};
    pair.a_W = pair.on_a.Position(a.rest().vertices, a.rest().triangles);
    const SurfaceHit hit = tree_b.Closest(pair.a_W, attachment.reach);
    if (hit.at.triangle < 0) continue;
    pair.on_b = hit.at;
    const Vector3d n_a = FaceNormal(a, pair.on_a), n_b = FaceNormal(b, pair.on_b);
    if (n_a.dot(n_b) > kFacing) continue;
    pair.b_W = pair.on_b.Position(b.rest().vertices, b.rest().triangles);
    // Beyond b's border the closest point lies beside, not opposite.
    const Vector3d way_W = pair.b_W - pair.a_W;
    const bool apart = way_W.norm() > kTouching * attachment.reach;
    if (apart && std::abs(n_a.dot(way_W)) < kOpposite * way_W.norm()) continue;
    pair.normal_W = (n_a - n_b).normalized();
    pair.area = sample.weight;
    facing.push_back(pair);
  }
  return facing;
}

double AreaOf(const std::vector<Facing>& facing) {
  double area = 0;
  for (const Facing& pair : facing) area += pair.area;
  return area;
}

// Returns the least area that one function of the two lattices covers, m^2.
double CellArea(const OrganModel& a, const OrganModel& b) {
  double spacing = 1e9;
  for (const OrganModel* organ : {&a, &b}) {
    const LatticeOrgan* lattice = organ->lattice_organ();
    if (lattice != nullptr) spacing = std::min(spacing, ControlPointSpacing(lattice->lattice()));
  }
  return spacing * spacing;
}

void RefuseSupports(const AttachmentOptions& attachment, const OrganModel& organ,
                    const std::vector<Facing>& facing, bool is_a) {
  const Box bounds = AxisAlignedBounds(organ.rest().vertices);
  const auto& supports = organ.options().supports;
  for (std::size_t s = 0; s < supports.size(); ++s) {
    for (const Facing& pair : facing) {
      const Vector3d& p_W = is_a ? pair.a_W : pair.b_W;
      if (!InRegion(supports[s].region, bounds, p_W)) continue;
      throw InputError(
          AttachmentTitle(attachment) +
          BedText("overlaps support[%zu] of organ \"%s\" at [%.3f, %.3f, %.3f]; make one "
                  "of the regions smaller",
                  s, organ.options().name.c_str(), p_W.x(), p_W.y(), p_W.z()));
    }
  }
}

double LengthOf(const std::vector<Vector3d>& path) {
  double length = 0;
  for (std::size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).norm();
  return length;
}

// Returns the point of a path at a way (m) from its start.
Vector3d AlongPath(const std::vector<Vector3d>& path, double way) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double length = (path[i] - path[i - 1]).norm();
    if (way < length) return path[i - 1] + way / length * (path[i] - path[i - 1]);
    way -= length;
  }
  return path.back();
}

// Groups the points by the cells of a grid of width `side` on a's surface, in the order of the grid.
std::vector<std::vector<std::size_t>> Grouped(const std::vector<Facing>& facing, double side) {
  std::map<std::array<long, 3>, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < facing.size(); ++i) {
    const Vector3d& p = facing[i].a_W;
    groups[{std::lround(p.x() / side), std::lround(p.y() / side), std::lround(p.z() / side)}]
        .push_back(i);
  }
  std::vector<std::vector<std::size_t>> lists;
  for (auto& [cell, list] : groups) lists.push_back(std::move(list));
  return lists;
}

}  // namespace

AttachmentBed::AttachmentBed(const AttachmentOptions& attachment, const OrganModel& a,
                             const OrganModel& b, int number)
    : options(attachment), index(number), law(attachment) {
  if (attachment.IsLeaf()) {
    SampleLeaf(a, b);
  } else {
    SampleLayer(a, b);
  }
}

void AttachmentBed::SampleLayer(const OrganModel& a, const OrganModel& b) {
  const SurfaceTree tree_b(b.rest().vertices, b.rest().triangles);
  const double cell = CellArea(a, b);
  std::vector<Facing> facing;
  try {
    facing = FacingPoints(options, a, b, tree_b, std::sqrt(cell) / 4);
  } catch (const InputError&) {  // the region holds no surface
  }
  const double area = AreaOf(facing);
  if (facing.empty()) {
    throw InputError(
        AttachmentTitle(options) +
        BedText("the surface of \"%s\" in its region has none of \"%s\" within %.3g mm "
                "opposite; move the region or give a larger reach",
                options.a.c_str(), options.b.c_str(), 1000 * options.reach));
  }
  if (area < cell) {
    throw InputError(AttachmentTitle(options) +
                     BedText("its bed of %.3g mm^2 meets less than one function of the lattices, "
                             "%.3g mm^2; give a larger region or more cells",
                             1e6 * area, 1e6 * cell));
  }
  double side = std::max(kLeastSide, std::sqrt(area / kWantedSamples));
  facing = FacingPoints(options, a, b, tree_b, side / 3);
  RefuseSupports(options, a, facing, true);
  RefuseSupports(options, b, facing, false);
  std::vector<std::vector<std::size_t>> groups = Grouped(facing, side);
  while (groups.size() > kMaxSamples) groups = Grouped(facing, side *= 1.1);
  TakeGroups(facing, groups, {&a, &b});
}

// Cuts the leaf into strips of equal width and takes each as two facing points.
void AttachmentBed::SampleLeaf(const OrganModel& a, const OrganModel& b) {
  const std::array<const OrganModel*, 2> organs{&a, &b};
  std::array<double, 2> lengths;
  for (std::size_t side = 0; side < 2; ++side) lengths[side] = LengthOf(options.paths_W[side]);
  width = (lengths[0] + lengths[1]) / 2;
  const int count = std::clamp(static_cast<int>(width / kLeastSide), 1, kMaxSamples);
  width /= count;
  std::vector<Facing> strips(ToSize(count));
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t side = 0; side < 2; ++side) {
    const OrganModel& organ = *organs[side];
    const SurfaceTree tree(organ.rest().vertices, organ.rest().triangles);
    for (int i = 0; i < count; ++i) {
      const Vector3d p_W = AlongPath(options.paths_W[side], lengths[side] * (i + 0.5) / count);
      const SurfaceHit hit = tree.Closest(p_W, options.reach);
      if (hit.at.triangle < 0) {
        throw InputError(
            AttachmentTitle(options) +
            BedText("path_%c at [%.3f, %.3f, %.3f] is farther than %.3g mm from the surface "
                    "of \"%s\"; move it or give a larger reach",
                    side == 0 ? 'a' : 'b', p_W.x(), p_W.y(), p_W.z(), 1000 * options.reach,
                    organ.options().name.c_str()));
      }
      Facing& strip = strips[ToSize(i)];
      (side == 0 ? strip.on_a : strip.on_b) = hit.at;
      (side == 0 ? strip.a_W : strip.b_W) =
          hit.at.Position(organ.rest().vertices, organ.rest().triangles);
    }
  }
  double area = 0;
  for (std::size_t i = 0; i < strips.size(); ++i) {
    Facing& strip = strips[i];
    const Vector3d way_W = strip.b_W - strip.a_W;
    if (way_W.norm() < kLeastSpan) {
      throw InputError(
          AttachmentTitle(options) +
          BedText("the leaf spans less than %.3g mm at [%.3f, %.3f, %.3f]; move its paths "
                  "apart or give a region: the surfaces touch there",
                  1000 * kLeastSpan, strip.a_W.x(), strip.a_W.y(), strip.a_W.z()));
    }
    strip.normal_W = way_W.normalized();
    strip.area = width * way_W.norm();
    area += strip.area;
    groups.push_back({i});
  }
  const double length = area / (width * count);
  if (!(options.toughness > LeastToughness(options, length))) {
    throw InputError(
        AttachmentTitle(options) +
        BedText("toughness is not above strength^2 length / (2 young) = %.3g J/m^2 for a "
                "leaf that spans %.3g mm; give a larger one, or a lower strength",
                LeastToughness(options, length), 1000 * length));
  }
  law = CohesiveLaw(options, length);
  RefuseSupports(options, a, strips, true);
  RefuseSupports(options, b, strips, false);
  TakeGroups(strips, groups, organs);
  edges_W = Points::Zero(count, 3);
  for (int i = 0; i < count; ++i) {
    Vector3d along_W = Vector3d::Zero();
    for (std::size_t side = 0; side < 2; ++side) {
      const auto at = [&](double strips) {
        return AlongPath(options.paths_W[side], lengths[side] * strips / count);
      };
      along_W += at(i + 1.0) - at(i);
    }
    const Vector3d normal_W = normals_W.row(i), edge_W = along_W - normal_W.dot(along_W) * normal_W;
    edges_W.row(i) = edge_W.norm() > 0 ? edge_W.normalized() : normal_W.unitOrthogonal();
  }
}

// Makes one sample of each group of facing points.
void AttachmentBed::TakeGroups(const std::vector<Facing>& facing,
                               const std::vector<std::vector<std::size_t>>& groups,
                               const std::array<const OrganModel*, 2>& organs) {
  const auto count = static_cast<Eigen::Index>(groups.size());
  points_W = {Points::Zero(count, 3), Points::Zero(count, 3)};
  normals_W = Points::Zero(count, 3);
  areas = Eigen::VectorXd::Zero(count);
  std::array<std::vector<Eigen::Triplet<double>>, 2> entries;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& group = groups[static_cast<std::size_t>(i)];
    for (const std::size_t p : group) {
      areas[i] += facing[p].area;
      points_W[0].row(i) += facing[p].area * facing[p].a_W.transpose();
      points_W[1].row(i) += facing[p].area * facing[p].b_W.transpose();
      normals_W.row(i) += facing[p].area * facing[p].normal_W.transpose();
    }
    for (Points& points : points_W) points.row(i) /= areas[i];
    const auto nearest = std::ranges::min(group, {}, [&](std::size_t p) {
      return (facing[p].a_W.transpose() - points_W[0].row(i)).squaredNorm();
    });
    surface_points[0].push_back(facing[nearest].on_a);
    surface_points[1].push_back(facing[nearest].on_b);
    normals_W.row(i).normalize();
    for (std::size_t o = 0; o < 2; ++o) {
      if (organs[o]->rigid()) continue;
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(organs[o]->control_points());
      for (const std::size_t p : group) {
        organs[o]->AddToRow(o == 0 ? facing[p].on_a : facing[p].on_b, facing[p].area / areas[i],
                            ActiveRefinement(0, 0), row);
      }
      for (Eigen::Index c = 0; c < row.size(); ++c) {
        if (row[c] != 0) entries[o].emplace_back(i, c, row[c]);
      }
    }
  }
  for (std::size_t o = 0; o < 2; ++o) {
    rows[o].resize(count, organs[o]->rigid() ? 0 : organs[o]->control_points());
    rows[o].setFromTriplets(entries[o].begin(), entries[o].end());
  }
}

void RefuseSharedSurface(const AttachmentBed& first, const AttachmentBed& second) {
  const std::array<std::string, 2> of_first{first.options.a, first.options.b};
  const std::array<std::string, 2> of_second{second.options.a, second.options.b};
  for (std::size_t f = 0; f < 2; ++f) {
    for (std::size_t s = 0; s < 2; ++s) {
      if (of_first[f] != of_second[s]) continue;
      for (int i = 0; i < first.size(); ++i) {
        const Vector3d p_W = first.points_W[f].row(i);
        for (int j = 0; j < second.size(); ++j) {
          const double distance = (second.points_W[s].row(j).transpose() - p_W).norm();
          if (distance > std::sqrt(std::min(first.Footprint(i), second.Footprint(j))) / 2) continue;
          throw InputError(
              AttachmentTitle(second.options) +
              BedText(
                  "shares the surface of organ \"%s\" at [%.3f, %.3f, %.3f] with the attachment "
                  "of \"%s\" and \"%s\"; make their regions disjoint",
                  of_first[f].c_str(), p_W.x(), p_W.y(), p_W.z(), of_first[0].c_str(),
                  of_first[1].c_str()));
        }
      }
    }
  }
}

}  // namespace hpdm
