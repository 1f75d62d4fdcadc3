#include "render/tissue/duct_renderer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/duct/duct_state.h"

namespace hpdm {
namespace {

constexpr int kRings = 2 * kMaxDuctNodes;
// Half axes of a clipped section, in radii.
constexpr double kFlat = 0.25, kWide = 1.4;
constexpr double kTaper = 0.002;  // m: beside a clip the tube is round again

Vector3d NodeOf(const DuctSnapshot& snapshot, int node) {
  return snapshot.nodes_W[ToSize(std::clamp(node, 0, snapshot.nodes - 1))].cast<double>();
}

bool IsClipped(const DuctSnapshot& snapshot, int segment) {
  return segment >= 0 && segment + 1 < snapshot.nodes &&
         snapshot.segments[ToSize(segment)] == SegmentState::kClipped;
}

// Returns how flat clips press the tube at a node, 0..1.
double FlatnessAt(const DuctSnapshot& snapshot, int node) {
  double nearest = kTaper;
  for (int i = 0; i + 1 < snapshot.nodes; ++i) {
    if (!IsClipped(snapshot, i)) continue;
    for (const int end : {i, i + 1}) {
      nearest = std::min(nearest, (NodeOf(snapshot, node) - NodeOf(snapshot, end)).norm());
    }
  }
  const double share = 1 - nearest / kTaper;
  return share * share * (3 - 2 * share);
}

bool IsGap(const DuctSnapshot& snapshot, int segment) {
  return segment >= 0 && segment + 1 < snapshot.nodes &&
         snapshot.segments[ToSize(segment)] == SegmentState::kGap;
}

}  // namespace

SweptTube::SweptTube(const DuctSnapshot& snapshot, double radius) : radius_(radius) {
  PointsF vertices(kRings * kSides, 3);
  Sweep(snapshot, &vertices);
  rest_.vertices = vertices.cast<double>();
  rest_.triangles.resize(2 * (kRings - 1) * kSides, 3);
  rest_.texture_coordinates.resize(3 * rest_.triangles.rows(), 2);
  double length = 0;
  for (int i = 0; i + 1 < snapshot.nodes; ++i) {
    length += (NodeOf(snapshot, i + 1) - NodeOf(snapshot, i)).norm();
  }
  const double of_side = 2 * std::numbers::pi * radius / (kSides * length);
  const double of_ring = 0.5 / std::max(1, snapshot.nodes - 1);
  Eigen::Index row = 0;
  for (int ring = 0; ring + 1 < kRings; ++ring) {
    for (int side = 0; side < kSides; ++side) {
      // Corners as (ring, side), counter-clockwise from outside.
      const std::array<std::array<int, 2>, 4> corners{{{0, 0}, {0, 1}, {1, 1}, {1, 0}}};
      for (const auto& [first, second, third] : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
        int corner = 0;
        for (const int at : {first, second, third}) {
          const int r = ring + corners[ToSize(at)][0], s = side + corners[ToSize(at)][1];
          rest_.triangles(row, corner) = r * kSides + s % kSides;
          rest_.texture_coordinates.row(3 * row + corner) << of_ring * r, of_side * s;
          ++corner;
        }
        ++row;
      }
    }
  }
}

SurfaceMesh SweptTube::Clip() const { return ClipMesh(kFlat * radius_, kWide * radius_); }

void SweptTube::Sweep(const DuctSnapshot& snapshot, PointsF* vertices,
                      std::vector<Isometry3d>* clips_W) const {
  if (clips_W != nullptr) clips_W->clear();
  Vector3d across = Vector3d::Zero(), last = Vector3d::Zero();
  for (int ring = 0; ring < kRings; ++ring) {
    const int node = std::min(ring / 2, snapshot.nodes - 1);
    // Directions never lead across a gap.
    const int before = node > 0 && !IsGap(snapshot, node - 1) ? node - 1 : node;
    const int after = node + 1 < snapshot.nodes && !IsGap(snapshot, node) ? node + 1 : node;
    const Vector3d way = NodeOf(snapshot, after) - NodeOf(snapshot, before);
    const Vector3d along = way.norm() > 0 ? Vector3d(way.normalized()) : Vector3d::UnitZ();
    across = ring == 0 ? along.unitOrthogonal()
                       : Vector3d(Eigen::Quaterniond::FromTwoVectors(last, along) * across);
    across = (across - along.dot(across) * along).normalized();
    last = along;
    const Vector3d beside = along.cross(across);
    // The rings that face a gap close the ends.
    const bool closing = ring % 2 == 1 ? IsGap(snapshot, node) : IsGap(snapshot, node - 1);
    const double radius = closing || ring / 2 >= snapshot.nodes ? 0 : radius_;
    if (clips_W != nullptr && ring % 2 == 1 && IsClipped(snapshot, node)) {
      Isometry3d& X_WC = clips_W->emplace_back(Isometry3d::Identity());
      const Vector3d next = NodeOf(snapshot, node + 1);
      const Vector3d z = (next - NodeOf(snapshot, node)).stableNormalized();
      const Vector3d x = (across - z.dot(across) * z).stableNormalized();
      X_WC.linear() << x, z.cross(x), z;
      X_WC.translation() = 0.5 * (NodeOf(snapshot, node) + next);
    }
    const double flatness = FlatnessAt(snapshot, node);
    const double flat = 1 - flatness * (1 - kFlat), wide = 1 + flatness * (kWide - 1);
    for (int side = 0; side < kSides; ++side) {
      const double angle = 2 * std::numbers::pi * side / kSides;
      const Vector3d point = NodeOf(snapshot, node) + radius * (flat * std::cos(angle) * across +
                                                                wide * std::sin(angle) * beside);
      vertices->row(ring * kSides + side) = point.transpose().cast<float>();
    }
  }
}

std::vector<SweptTube> DuctRenderer::TubesOf(const std::vector<DuctVisual>& ducts) {
  std::vector<SweptTube> tubes;
  for (const DuctVisual& duct : ducts) {
    tubes.emplace_back(SnapshotOf(duct.model->rod), duct.model->options.radius);
  }
  return tubes;
}

std::vector<OrganVisual> DuctRenderer::VisualsOf(const std::vector<DuctVisual>& ducts,
                                                 const std::vector<SweptTube>& tubes) {
  std::vector<OrganVisual> visuals;
  for (std::size_t d = 0; d < ducts.size(); ++d) {
    OrganVisual& visual = visuals.emplace_back();
    visual.rest = &tubes[d].rest();
    visual.colour = ducts[d].colour;
  }
  return visuals;
}

std::vector<SurfaceMesh> DuctRenderer::ClipsOf(const std::vector<SweptTube>& tubes) {
  std::vector<SurfaceMesh> clips;
  for (const SweptTube& tube : tubes) clips.push_back(tube.Clip());
  return clips;
}

DuctRenderer::DuctRenderer(const std::vector<DuctVisual>& ducts, const ToolShade& shade)
    : tubes_(TubesOf(ducts)),
      tubes_renderer_(VisualsOf(ducts, tubes_), shade, false),
      clips_renderer_(ClipsOf(tubes_)),
      clips_W_(tubes_.size()) {
  for (std::vector<Isometry3d>& clips_W : clips_W_) clips_W.reserve(kMaxDuctNodes);
  for (const DuctVisual& duct : ducts) indices_.push_back(duct.model->index);
  for (const SweptTube& tube : tubes_) {
    OrganSnapshot& shape = shapes_.organs.emplace_back();
    shape.vertices = tube.rest().vertices.cast<float>();
  }
}

void DuctRenderer::Move(const SceneSnapshot& snapshot, const Laparoscope& scope) {
  for (std::size_t d = 0; d < tubes_.size(); ++d) {
    const auto index = ToSize(indices_[d]);
    if (index >= snapshot.ducts.size()) continue;
    tubes_[d].Sweep(snapshot.ducts[index], &shapes_.organs[d].vertices, &clips_W_[d]);
    ++shapes_.organs[d].version;
  }
  tubes_renderer_.Move(shapes_, scope);
}

void DuctRenderer::Draw(const Occlusion* occlusion) const {
  tubes_renderer_.Draw(occlusion);
  clips_renderer_.Draw(clips_W_);
}

}  // namespace hpdm
