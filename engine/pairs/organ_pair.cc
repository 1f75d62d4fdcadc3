#include "engine/pairs/organ_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/mesh/closest_point.h"

namespace hpdm {
namespace {

constexpr double kLeastFacing = 0.1;   // cosine between a sample's normal and minus its partner's
constexpr double kFullFacing = 0.5;    // from here on the weight is full
constexpr double kBeside = 0.0005;     // m, beside the partner's normal: full weight up to here
constexpr double kMostBeside = 0.002;  // m, no weight from here on
constexpr double kBesidePerGap = 0.5;  // both grow by this share of the gap's size
constexpr double kKeptBonus = 1.5;
constexpr double kLeastWeight = 1e-12;  // m^2

double SmoothStep(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

double MeanTriangle(const SurfaceMesh& mesh) {
  double sum = 0;
  for (int t = 0; t < mesh.triangles.rows(); ++t) {
    sum += TwiceAreaNormal(mesh.vertices, mesh.triangles, t).norm() / 2;
  }
  return sum / static_cast<double>(mesh.triangles.rows());
}

// Equal meshes in different poses have equal triangles to round-off.
bool Coarser(const SurfaceMesh& mesh, const SurfaceMesh& other) {
  return MeanTriangle(mesh) > MeanTriangle(other) * (1 + 1e-9);
}

bool Faces(const Vector3d& face, const Vector3d& normal) {
  return -face.dot(normal) > kLeastFacing * face.norm();
}

double CellSize(const OrganModel& a, const OrganModel& b) {
  double finest = 0;
  for (const OrganModel* organ : {&a, &b}) {
    const double radius = organ->FinestRadius();
    if (radius > 0 && (finest == 0 || radius < finest)) finest = radius;
  }
  return finest > 0 ? std::clamp(finest / 2, 0.005, 0.010) : OrganPair::kDefaultCell;
}

double LargestMotion(const Points& from, const Points& to) {
  double motion2 = 0;
  for (Eigen::Index v = 0; v < to.rows(); ++v) {
    motion2 = std::max(motion2, (to.row(v) - from.row(v)).squaredNorm());
  }
  return std::sqrt(motion2);
}

}  // namespace

OrganPair::OrganPair(const OrganModel& a, const OrganModel& b)
    : OrganPair({&a.rest(), &a.topology()}, {&b.rest(), &b.topology()}, CellSize(a, b)) {
  if (!a.options().free && !b.options().free) return;
  motion_gain_ = kFreeGain;
  most_motion_ = kMostFreeMotion;
}

OrganPair::OrganPair(const PairSurface& a, const PairSurface& b, double cell_size)
    : a_is_source_(!Coarser(*a.rest, *b.rest)),
      source_(a_is_source_ ? a : b),
      target_(a_is_source_ ? b : a),
      cells_(*source_.surface.rest, cell_size),
      memory_(ToSize(cells_.samples())),
      searched_(ToSize(cells_.samples()), 0),
      triangle_stamps_(ToSize(source_.surface.rest->triangles.rows()), 0),
      cell_(ToSize(cells_.cells() + cells_.blocks())),
      block_(ToSize(cells_.blocks())),
      pool_(ToSize(kMaxPatches) * ToSize(cells_.most_samples())),
      contacts_(kMaxPatches) {
  partnered_.reserve(kMaxFound);
  last_partnered_.reserve(kMaxFound);
  triangles_.reserve(triangle_stamps_.size());
  found_.reserve(kMaxFound);
  touched_cells_.reserve(cell_.size());
  kept_cells_.reserve(kMaxPatches);
  touched_blocks_.reserve(block_.size());
}

std::span<const PairContact> OrganPair::Update(const PairShape& a, const PairShape& b) {
  const PairShape& source = a_is_source_ ? a : b;
  const PairShape& target = a_is_source_ ? b : a;
  SetMargin(source, target);
  source_.normals.Begin(source.vertices);
  target_.normals.Begin(target.vertices);
  ++stamp_;
  found_.clear();
  touched_cells_.clear();
  std::swap(partnered_, last_partnered_);
  partnered_.clear();
  complete_ = true;
  deeper_ = false;
  Search(source, target, margin_);
  if (deeper_) Search(source, target, kMostDepth);
  for (const int sample : last_partnered_) {
    if (searched_[sample] != stamp_) memory_[sample].partner = -1;
  }
  for (const Found& found : found_) AddToCells(found);
  MergeBlocks();
  ChooseCells();
  WriteContacts();
  return contacts();
}

void OrganPair::SetMargin(const PairShape& source, const PairShape& target) {
  const Vector3d slid =
      (source.offset_W - source_.last_offset_W) - (target.offset_W - target_.last_offset_W);
  const double motion =
      source_.ExpectedMotion(source) + target_.ExpectedMotion(target) + slid.norm();
  margin_ = kMargin + std::min(motion_gain_ * motion, most_motion_);
  source_.Remember(source);
  target_.Remember(target);
}

double OrganPair::Side::ExpectedMotion(const PairShape& shape) const {
  return LargestMotion(last_vertices, shape.vertices) + std::max(0.0, shape.demand - last_demand);
}

void OrganPair::Side::Remember(const PairShape& shape) {
  last_vertices = shape.vertices;
  last_offset_W = shape.offset_W;
  last_demand = shape.demand;
}

// Seeks partners for all samples near the target, and for those that had one.
void OrganPair::Search(const PairShape& source, const PairShape& target, double reach) {
  ++search_stamp_;
  triangles_.clear();
  const auto add = [&](int triangle) {
    if (triangle_stamps_[triangle] == search_stamp_) return;
    triangle_stamps_[triangle] = search_stamp_;
    triangles_.push_back(triangle);
  };
  for (const int sample : last_partnered_) add(cells_.sample(sample).triangle);
  source.tree.VisitNear(target.tree, target.offset_W - source.offset_W, reach, add);
  const Triangles& triangles = source_.surface.rest->triangles;
  for (const int t : triangles_) {
    const auto [first, last] = cells_.OfTriangle(t);
    const double area = TwiceAreaNormal(source.vertices, triangles, t).norm() / 2;
    const bool near = last - first == 1 || IsNear(t, source, target, reach);
    for (int sample = first; sample < last; ++sample) {
      if (searched_[sample] == stamp_ || (!near && memory_[sample].partner < 0)) continue;
      SeekPartner(sample, area, source, target, reach);
    }
  }
}

// False if no point of the source's triangle is within `reach` of the target.
bool OrganPair::IsNear(int triangle, const PairShape& source, const PairShape& target,
                       double reach) const {
  const Triangles& triangles = source_.surface.rest->triangles;
  const Vector3d centre =
      SurfacePoint{triangle, Vector3d::Constant(1.0 / 3)}.Position(source.vertices, triangles);
  double radius = 0;
  for (int k = 0; k < 3; ++k) {
    const Vector3d corner = source.vertices.row(triangles(triangle, k));
    radius = std::max(radius, (corner - centre).norm());
  }
  return target.tree.Closest(centre + source.offset_W - target.offset_W, reach + radius)
             .at.triangle >= 0;
}

void OrganPair::SeekPartner(int sample, double triangle_area, const PairShape& source,
                            const PairShape& target, double reach) {
  const SurfaceSample& at = cells_.sample(sample);
  const SurfacePoint on_source{at.triangle, at.barycentric};
  const Triangles& target_triangles = target_.surface.rest->triangles;
  Memory& memory = memory_[sample];
  Found found;
  found.sample = sample;
  found.p_sample = on_source.Position(source.vertices, source_.surface.rest->triangles) +
                   source.offset_W - target.offset_W;
  const Vector3d normal = source_.normals.At(on_source);
  if (memory.partner >= 0) {
    found.partner = ClosestFacing(found.p_sample, normal, target,
                                  margin_ + std::max(0.0, -memory.gap), Behind::kEither, &memory);
  }
  if (found.partner.triangle < 0) {
    const SurfaceHit closest = target.tree.Closest(found.p_sample, reach);
    if (closest.at.triangle < 0) return;
    const Vector3d offset = found.p_sample - closest.at.Position(target.vertices, target_triangles);
    const bool inside =
        IsBehind(offset, closest.at, target.vertices, target_triangles, *target_.surface.topology);
    deeper_ = deeper_ || inside;
    const Vector3d face = TwiceAreaNormal(target.vertices, target_triangles, closest.at.triangle);
    if (Faces(face, normal) && (offset.dot(face) < 0) == inside) {
      found.partner = closest.at;
    } else {
      found.partner = ClosestFacing(found.p_sample, normal, target, reach,
                                    inside ? Behind::kBack : Behind::kFront, nullptr);
    }
    if (found.partner.triangle < 0) return;
  }
  found.p_partner = found.partner.Position(target.vertices, target_triangles);
  const Vector3d partner_normal = target_.normals.At(found.partner);
  const Vector3d offset = found.p_sample - found.p_partner;
  found.gap = offset.dot(partner_normal);
  if (found.gap >= margin_) return;
  const double beside =
      (offset - found.gap * partner_normal).norm() - kBesidePerGap * std::abs(found.gap);
  const double facing = -normal.dot(partner_normal);
  const double fade = SmoothStep((facing - kLeastFacing) / (kFullFacing - kLeastFacing)) *
                      SmoothStep((kMostBeside - beside) / (kMostBeside - kBeside)) *
                      SmoothStep((margin_ - found.gap) / (margin_ / 2));
  found.area = fade * at.weight * triangle_area;
  if (!(found.area > 0)) return;
  if (found_.size() == kMaxFound) {
    complete_ = false;
    return;
  }
  found.normal_difference = normal - partner_normal;
  memory.partner = found.partner.triangle;
  memory.gap = found.gap;
  memory.p_partner_rest = found.partner.Position(target_.surface.rest->vertices, target_triangles);
  searched_[sample] = stamp_;
  partnered_.push_back(sample);
  found_.push_back(found);
}

// Returns the closest point within `reach` on triangles that face `normal` and have `p` on the
// given side. `near`: a partner in whose neighbourhood at rest it is, if any. Triangle -1: none.
SurfacePoint OrganPair::ClosestFacing(const Vector3d& p, const Vector3d& normal,
                                      const PairShape& target, double reach, Behind behind,
                                      const Memory* near) const {
  const SurfaceMesh& rest = *target_.surface.rest;
  SurfacePoint best;
  double best2 = reach * reach;
  const auto visit = [&](int t) {
    const Vector3d a = target.vertices.row(rest.triangles(t, 0)),
                   b = target.vertices.row(rest.triangles(t, 1)),
                   c = target.vertices.row(rest.triangles(t, 2));
    const Vector3d face = (b - a).cross(c - a);
    if (!Faces(face, normal)) return std::sqrt(best2);
    const TrianglePoint closest = ClosestOnTriangle(p, a, b, c);
    const double distance2 = (p - closest.point).squaredNorm();
    const double side = face.dot(p - closest.point);
    if (distance2 >= best2 || (behind == Behind::kBack && side > 0) ||
        (behind == Behind::kFront && side < 0)) {
      return std::sqrt(best2);
    }
    const SurfacePoint at{t, closest.barycentric};
    if (near == nullptr ||
        (at.Position(rest.vertices, rest.triangles) - near->p_partner_rest).norm() < kMostSlide) {
      best2 = distance2;
      best = at;
    }
    return std::sqrt(best2);
  };
  if (near != nullptr) reach = visit(near->partner);
  target.tree.VisitNear(p, reach, visit);
  return best;
}

double OrganPair::Weight(const Found& found, int cell) const {
  const double sharpness =
      std::max({kSharpness, cell_[cell].indentation / 2, kFarShare * found.gap});
  return found.area * std::exp(-found.gap / sharpness);
}

void OrganPair::SetIndentation(std::uint64_t key, double indentation) {
  const int index = static_cast<int>(key / 2), block = index - cells_.cells();
  cell_[index].indentation = indentation;
  for (int cell = 0; block >= 0 && cell < cells_.cells(); ++cell) {
    if (cells_.BlockOf(cell) == block) cell_[cell].indentation = indentation;
  }
}

void OrganPair::Cell::Begin(std::uint32_t step) {
  stamp = step;
  slot = -1;
  weight = score = area = 0;
  least_gap = std::numeric_limits<double>::infinity();
  p_sample = p_partner = normal_difference = Vector3d::Zero();
}

void OrganPair::Cell::Add(const Cell& other) {
  weight += other.weight;
  score += other.score;
  area += other.area;
  least_gap = std::min(least_gap, other.least_gap);
  p_sample += other.p_sample;
  p_partner += other.p_partner;
  normal_difference += other.normal_difference;
}

void OrganPair::AddToCells(const Found& found) {
  for (const auto& [index, share] : cells_.CellsOf(found.sample)) {
    Cell& cell = cell_[index];
    if (cell.stamp != stamp_) {
      cell.Begin(stamp_);
      touched_cells_.push_back(index);
    }
    const double weight = share * Weight(found, index);
    cell.weight += weight;
    cell.score += share * found.area * (margin_ - found.gap);
    cell.area += share * found.area * std::clamp(1 - found.gap / kTouching, 0.0, 1.0);
    cell.least_gap = std::min(cell.least_gap, found.gap);
    cell.p_sample += weight * found.p_sample;
    cell.p_partner += weight * found.p_partner;
    cell.normal_difference += weight * found.normal_difference;
  }
}

// Makes one contact of each of so many blocks that there are at most kMaxPatches, if possible.
void OrganPair::MergeBlocks() {
  std::erase_if(touched_cells_, [&](int i) {
    return !(cell_[i].weight > kLeastWeight) || cell_[i].normal_difference.isZero(0);
  });
  touched_blocks_.clear();
  for (const int i : touched_cells_) {
    Block& block = block_[cells_.BlockOf(i)];
    if (block.stamp != stamp_) {
      block = {.stamp = stamp_,
               .least_gap = std::numeric_limits<double>::infinity(),
               .merged_last = block.merged && block.stamp + 1 == stamp_};
      touched_blocks_.push_back(cells_.BlockOf(i));
    }
    ++block.count;
    block.least_gap = std::min(block.least_gap, cell_[i].least_gap);
  }
  std::size_t contacts = touched_cells_.size();
  if (contacts <= ToSize(kMaxPatches)) return;
  const auto gap = [&](int b) {
    return block_[b].least_gap + (block_[b].merged_last ? kTouching : 0.0);
  };
  std::sort(touched_blocks_.begin(), touched_blocks_.end(), [&](int i, int j) {
    const double a = gap(i), b = gap(j);
    return a != b ? a > b : i < j;
  });
  for (const int b : touched_blocks_) {
    if (contacts <= ToSize(kMaxPatches)) break;
    if (block_[b].count == 1) continue;
    block_[b].merged = true;
    contacts -= ToSize(block_[b].count - 1);
    cell_[cells_.cells() + b].Begin(stamp_);
  }
  for (const int i : touched_cells_) {
    const int b = cells_.BlockOf(i);
    if (block_[b].merged) cell_[cells_.cells() + b].Add(cell_[i]);
  }
  std::erase_if(touched_cells_, [&](int i) { return block_[cells_.BlockOf(i)].merged; });
  for (const int b : touched_blocks_) {
    if (block_[b].merged) touched_cells_.push_back(cells_.cells() + b);
  }
}

void OrganPair::ChooseCells() {
  const auto score = [&](int i) { return cell_[i].score * (cell_[i].kept ? kKeptBonus : 1.0); };
  std::sort(touched_cells_.begin(), touched_cells_.end(), [&](int i, int j) {
    const double a = score(i), b = score(j);
    return a != b ? a > b : i < j;
  });
  complete_ = complete_ && touched_cells_.size() <= kMaxPatches;
  touched_cells_.resize(std::min(touched_cells_.size(), ToSize(kMaxPatches)));
  std::sort(touched_cells_.begin(), touched_cells_.end());
  for (const int i : kept_cells_) {
    cell_[i].kept = false;
    if (cell_[i].stamp != stamp_) cell_[i].indentation = 0;
  }
  for (const int i : touched_cells_) cell_[i].kept = true;
  kept_cells_ = touched_cells_;
}

void OrganPair::WriteContacts() {
  count_ = touched_cells_.size();
  for (std::size_t c = 0; c < count_; ++c) {
    Cell& cell = cell_[touched_cells_[c]];
    cell.slot = static_cast<int>(c);
    PairContact& contact = contacts_[c];
    const Vector3d normal = cell.normal_difference.normalized();  // from the source
    contact.key = 2 * static_cast<std::uint64_t>(touched_cells_[c]) + (a_is_source_ ? 0 : 1);
    contact.normal_W = a_is_source_ ? normal : Vector3d(-normal);
    contact.gap = normal.dot(cell.p_partner - cell.p_sample) / cell.weight;
    contact.least_gap = cell.least_gap;
    contact.area = cell.area;
    contact.samples = {pool_.data() + c * ToSize(cells_.most_samples()), 0};
  }
  for (const Found& found : found_) {
    const SurfaceSample& at = cells_.sample(found.sample);
    const SurfacePoint on_source{at.triangle, at.barycentric};
    for (const auto& [index, share] : cells_.CellsOf(found.sample)) {
      const int b = cells_.BlockOf(index);
      const bool merged = block_[b].stamp == stamp_ && block_[b].merged;
      const Cell& cell = cell_[merged ? cells_.cells() + b : index];
      if (cell.slot < 0) continue;
      PairContact& contact = contacts_[ToSize(cell.slot)];
      PairSample& sample =
          pool_[ToSize(cell.slot) * ToSize(cells_.most_samples()) + contact.samples.size()];
      contact.samples = {contact.samples.data(), contact.samples.size() + 1};
      sample.on_a = a_is_source_ ? on_source : found.partner;
      sample.on_b = a_is_source_ ? found.partner : on_source;
      sample.weight = share * Weight(found, index) / cell.weight;
    }
  }
}

}  // namespace hpdm
