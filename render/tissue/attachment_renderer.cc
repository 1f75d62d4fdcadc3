#include "render/tissue/attachment_renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "engine/exercise/step_queries.h"
#include "engine/mesh/closest_point.h"

namespace hpdm {
namespace {

constexpr std::size_t kFibresOfSample = 3;
constexpr double kFibreRadius = 0.0002;  // m
// A strip of a leaf is drawn as so many fibres that lie closely beside each other.
constexpr std::size_t kFibresOfStrip = 4;
constexpr double kStripOverlap = 1.3;
// Opacity of a leaf's fibres: a film through which the tissue behind is seen, with denser strands.
constexpr double kLeastLeafOpacity = 0.10, kMostLeafOpacity = 0.42;
constexpr double kLeastStretch = 5e-4;  // m: shorter fibres are hidden between the surfaces
constexpr double kDotRadius = 0.0005;   // m, of what is left to free
constexpr double kLeastDot = 1.5, kMostDot = 6;  // px
constexpr float kLineRadius = 1;                 // px, at an instrument's tip
constexpr float kDotOpacity = 0.8f, kDotHidden = 0.5f;
// Damage at which a surface begins to look raw.
constexpr float kRawFrom = 0.5f;
// Vertices within so many sample widths of a sample's point belong to the bed.
constexpr double kBedReach = 1.0;
const Colour kFibreColour(0.88f, 0.74f, 0.66f);
const Colour kTautColour(1.0f, 1.0f, 0.97f);  // of fibres that are about to tear
const Colour kLeafColour(0.86f, 0.72f, 0.62f);

// Returns 0 for whole tissue up to 1 for raw, and from there on up to 2 for charred.
float RawnessOf(float damage, float burnt) {
  const float x = std::clamp((damage - kRawFrom) / (1 - kRawFrom), 0.0f, 1.0f);
  return x * x * (3 - 2 * x) + (damage >= 1 ? burnt : 0);
}

// Returns the effective displacement of a sample's fibres between a_W and b_W, m.
double Displacement(const AttachmentBed& bed, std::size_t sample, const Vector3d& a_W,
                    const Vector3d& b_W) {
  const auto row = static_cast<Eigen::Index>(sample);
  const Vector3d at_rest_W = bed.points_W[1].row(row) - bed.points_W[0].row(row);
  return bed.law.Effective(b_W - a_W - at_rest_W, bed.normals_W.row(row).transpose());
}

// Returns the share of the way to where a sample's fibres tear, 0..1. a_W, b_W: their ends, m.
double Tautness(const AttachmentBed& bed, std::size_t sample, const Vector3d& a_W,
                const Vector3d& b_W) {
  return std::clamp(Displacement(bed, sample, a_W, b_W) / bed.law.final, 0.0, 1.0);
}

// Returns the colour of a sample's fibres: they turn white in the second half of the way from where they
// begin to give way to where they tear. a_W, b_W: their ends, m.
Colour FibreColour(const AttachmentBed& bed, std::size_t sample, const Vector3d& a_W,
                   const Vector3d& b_W) {
  const double effective = Displacement(bed, sample, a_W, b_W);
  const double share = (effective - bed.law.onset) / (bed.law.final - bed.law.onset);
  const Colour& slack = bed.law.leaf ? kLeafColour : kFibreColour;
  return slack + static_cast<float>(std::clamp(2 * share - 1, 0.0, 1.0)) * (kTautColour - slack);
}

// Returns a number from 0 to 1 that looks random from one fibre to the next.
double Scatter(std::size_t fibre) {
  const double turns = std::numbers::phi * static_cast<double>(fibre);
  return turns - std::floor(turns);
}

std::vector<int> NearestSamples(const AttachmentBed& bed, std::size_t side,
                                const Points& vertices_W) {
  std::vector<int> nearest(static_cast<std::size_t>(vertices_W.rows()), -1);
  if (bed.law.leaf) return nearest;  // it leaves no raw surface
  for (Eigen::Index v = 0; v < vertices_W.rows(); ++v) {
    Eigen::Index i = 0;
    const double squared =
        (bed.points_W[side].rowwise() - vertices_W.row(v)).rowwise().squaredNorm().minCoeff(&i);
    if (squared > kBedReach * kBedReach * bed.areas[i]) continue;
    nearest[static_cast<std::size_t>(v)] = static_cast<int>(i);
  }
  return nearest;
}

}  // namespace

AttachmentRenderer::AttachmentRenderer(std::vector<AttachmentVisual> attachments,
                                       const std::vector<OrganVisual>& organs) {
  std::size_t samples = 0;
  for (const AttachmentVisual& visual : attachments) {
    const AttachmentBed& bed = *visual.bed;
    Layer& layer = layers_.emplace_back();
    layer.visual = visual;
    layer.damage.assign(ToSize(bed.size()), 0);
    layer.burnt = layer.damage;
    samples += layer.damage.size();
    for (std::size_t side = 0; side < 2; ++side) {
      const auto organ = ToSize(visual.organs[side]);
      const SurfaceMesh& rest = *organs[organ].rest;
      layer.nearest[side] = NearestSamples(bed, side, rest.vertices);
      layer.triangles[side].resize(bed.size(), 3);
      for (int i = 0; i < bed.size(); ++i) {
        layer.triangles[side].row(i) =
            rest.triangles.row(bed.surface_points[side][ToSize(i)].triangle);
      }
    }
    for (int i = 0; i < bed.size(); ++i) {
      const Vector3d normal_W = bed.normals_W.row(i);
      const double half = std::sqrt(bed.Footprint(i)) / 2;
      const Vector3d first =
          bed.law.leaf ? Vector3d(bed.edges_W.row(i)) : normal_W.unitOrthogonal();
      layer.across.push_back({half * first, half * normal_W.cross(first)});
    }
  }
  fibres_.reserve(std::max(kFibresOfSample, kFibresOfStrip) * samples);
}

bool AttachmentRenderer::Follow(const SceneSnapshot& snapshot) {
  bool changed = false;
  for (Layer& layer : layers_) {
    const std::size_t index = ToSize(layer.visual.bed->index);
    changed = changed || snapshot.damage[index] != layer.damage;
    layer.damage = snapshot.damage[index];
    layer.burnt = snapshot.burnt[index];
  }
  return changed;
}

void AttachmentRenderer::AddRaw(std::vector<std::vector<float>>* raws) const {
  for (const Layer& layer : layers_) {
    for (std::size_t side = 0; side < 2; ++side) {
      std::vector<float>& raw = (*raws)[ToSize(layer.visual.organs[side])];
      for (std::size_t v = 0; v < raw.size(); ++v) {
        if (layer.nearest[side][v] < 0) continue;
        const std::size_t sample = ToSize(layer.nearest[side][v]);
        raw[v] = std::max(raw[v], RawnessOf(layer.damage[sample], layer.burnt[sample]));
      }
    }
  }
}

Vector3d AttachmentRenderer::EndOf(const Layer& layer, std::size_t side, std::size_t sample,
                                   const SceneSnapshot& snapshot) const {
  const OrganSnapshot& organ = snapshot.organs[ToSize(layer.visual.organs[side])];
  const Vector3d& weights = layer.visual.bed->surface_points[side][sample].barycentric;
  Vector3d end_W = organ.offset_W;
  for (int k = 0; k < 3; ++k) {
    const auto vertex = organ.vertices.row(layer.triangles[side](static_cast<int>(sample), k));
    end_W += weights[k] * vertex.transpose().cast<double>();
  }
  return end_W;
}

// Adds a strip of a leaf, which lies bare also at rest.
void AttachmentRenderer::AddStrip(const Layer& layer, std::size_t sample, const Vector3d& a_W,
                                  const Vector3d& b_W, double px_per_m) {
  const Vector3d& half = layer.across[sample][0];
  const Colour colour = FibreColour(*layer.visual.bed, sample, a_W, b_W);
  const double radius = kStripOverlap * half.norm() / double{kFibresOfStrip};
  for (std::size_t k = 0; k < kFibresOfStrip; ++k) {
    const double place = (2 * static_cast<double>(k) + 1) / double{kFibresOfStrip} - 1;  // -1..1
    const auto px = static_cast<float>(std::max(0.4, radius * px_per_m));
    const double opacity =
        std::lerp(kLeastLeafOpacity, kMostLeafOpacity, Scatter(kFibresOfStrip * sample + k));
    fibres_.push_back({.a_W = (a_W + place * half).cast<float>(),
                       .radius_a = px,
                       .b_W = (b_W + place * half).cast<float>(),
                       .radius_b = px,
                       .colour = colour,
                       .opacity = static_cast<float>(opacity) * (1 - 0.5f * layer.burnt[sample])});
  }
}

void AttachmentRenderer::DrawLeft(const SceneSnapshot& snapshot, const Laparoscope& scope,
                                  FreeingGuide* guide) {
  fibres_.clear();
  guide->nearest = {};
  guide->tautness = 0;
  std::array<double, kMaxInstruments> least;
  least.fill(std::numeric_limits<double>::infinity());
  const auto add = [&](const Vector3d& from_W, const Vector3d& to_W) {
    const double px = kDotRadius * scope.MostPixelsPerMetre(to_W, to_W);
    const auto radius = static_cast<float>(std::clamp(px, kLeastDot, kMostDot));
    const float radius_a = from_W == to_W ? radius : kLineRadius;
    fibres_.push_back(
        {from_W.cast<float>(), radius_a, to_W.cast<float>(), radius, guide->colour, kDotOpacity});
  };
  for (const Layer& layer : layers_) {
    const int attachment = layer.visual.bed->index;
    if (!Contains(guide->attachments, attachment)) continue;
    for (std::size_t i = 0; i < layer.damage.size(); ++i) {
      if (layer.damage[i] >= 1) continue;
      const Vector3d a_W = EndOf(layer, 0, i, snapshot), b_W = EndOf(layer, 1, i, snapshot);
      const Vector3d middle_W = (a_W + b_W) / 2;
      add(middle_W, middle_W);
      guide->tautness = std::max(guide->tautness, Tautness(*layer.visual.bed, i, a_W, b_W));
      for (std::size_t t = 0; t < kMaxInstruments; ++t) {
        if (!guide->tips_W[t]) continue;
        const Vector3d& tip_W = *guide->tips_W[t];
        const Vector3d near_W = ClosestPointOnSegment(tip_W, a_W, b_W);
        if ((tip_W - near_W).norm() >= least[t]) continue;
        least[t] = (tip_W - near_W).norm();
        guide->nearest[t] = {near_W, attachment, (b_W - a_W).norm()};
      }
    }
  }
  for (std::size_t t = 0; t < kMaxInstruments; ++t) {
    if (guide->nearest[t]) add(*guide->tips_W[t], guide->nearest[t]->p_W);
  }
  mark_renderer_.Draw(fibres_, kDotHidden, Laparoscope::kFar);
}

void AttachmentRenderer::Draw(const SceneSnapshot& snapshot, const Laparoscope& scope) {
  fibres_.clear();
  for (const Layer& layer : layers_) {
    const AttachmentBed& bed = *layer.visual.bed;
    for (std::size_t i = 0; i < layer.damage.size(); ++i) {
      if (layer.damage[i] >= 1) continue;
      const auto row = static_cast<Eigen::Index>(i);
      const Vector3d a_W = EndOf(layer, 0, i, snapshot), b_W = EndOf(layer, 1, i, snapshot);
      const double px_per_m = scope.MostPixelsPerMetre(a_W.cwiseMin(b_W), a_W.cwiseMax(b_W));
      if (bed.law.leaf) {
        AddStrip(layer, i, a_W, b_W, px_per_m);
        continue;
      }
      const double at_rest = (bed.points_W[1].row(row) - bed.points_W[0].row(row)).norm();
      if ((b_W - a_W).norm() < at_rest + kLeastStretch) continue;
      const Colour colour = FibreColour(bed, i, a_W, b_W);
      const auto radius = static_cast<float>(std::max(0.4, kFibreRadius * px_per_m));
      for (std::size_t k = 0; k < kFibresOfSample; ++k) {
        // Spread evenly over the sample, turned from sample to sample.
        const double angle = 2.4 * static_cast<double>(i) + 2 * std::numbers::pi *
                                                                static_cast<double>(k) /
                                                                double{kFibresOfSample};
        const Vector3d beside =
            0.7 * (std::cos(angle) * layer.across[i][0] + std::sin(angle) * layer.across[i][1]);
        fibres_.push_back({.a_W = (a_W + beside).cast<float>(),
                           .radius_a = radius,
                           .b_W = (b_W + beside).cast<float>(),
                           .radius_b = radius,
                           .colour = colour,
                           .opacity = 0.9f - 0.5f * layer.burnt[i]});
      }
    }
  }
  mark_renderer_.Draw(fibres_, 0, Laparoscope::kFar);
}

}  // namespace hpdm
