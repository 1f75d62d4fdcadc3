#include "engine/step/layer_actions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "engine/mesh/closest_point.h"

namespace hpdm {
namespace {

// Returns how far along a segment, 0..1, it is nearest to the plane y = 0.
double NearestShareToPlane(const Vector3d& a, const Vector3d& b) {
  const double across = a.y() - b.y();
  return across != 0 ? std::clamp(a.y() / across, 0.0, 1.0) : 0;
}

constexpr double kOutOfReach = std::numeric_limits<double>::infinity();

}  // namespace

LayerActions::LayerActions(const std::vector<ToolOptions>& tools)
    : reached_(kMaxAttachments * AttachmentBed::kMaxSamples) {
  for (const ToolOptions& tool : tools) geometries_.push_back(tool.geometries);
}

std::array<LayerWork, kMaxInstruments> LayerActions::Apply(const ToolState& tools,
                                                           const JawClosings& jaws, double dt,
                                                           const std::vector<OrganStep>& organs,
                                                           std::span<AttachmentLink> links) {
  std::array<LayerWork, kMaxInstruments> work;
  for (int t = 0; t < tools.tool_count; ++t) {
    const ToolPose& pose = tools.tools[ToSize(t)];
    const ToolGeometry& geometry = geometries_[ToSize(t)][ToSize(pose.instrument_index)];
    in_reach_[ToSize(t)] = -1;
    if (geometry.action == ToolAction::kBurn) {
      FindHeated(pose, geometry, organs, links);
      const double energy = geometry.power * std::min(dt, kLongestStep);
      if (pose.pedal) work[ToSize(t)].burning = Burn(energy);
      for (const Reached& at : reached_) {
        if (at.link->state().Left(at.layer, at.sample) == 0) continue;
        in_reach_[ToSize(t)] = at.link->joint().layers()[at.layer].bed.index;
        break;
      }
    }
    const double widest = jaws.ClosingFrom(ToSize(t));
    if (geometry.action == ToolAction::kCut && widest > 0) {
      work[ToSize(t)].cut_area = Cut(pose, geometry, widest, organs, links);
    }
  }
  return work;
}

// Lists in reached_ the samples that hold and whose distance_of(Fibres) is not infinite, the nearest
// first.
template <typename Distance>
void LayerActions::Find(const std::vector<OrganStep>& organs, std::span<AttachmentLink> links,
                        const Distance& distance_of) {
  reached_.clear();
  for (AttachmentLink& link : links) {
    const AttachmentJoint& joint = link.joint();
    for (std::size_t l = 0; l < joint.layers().size(); ++l) {
      const AttachmentJoint::Layer& layer = joint.layers()[l];
      const auto place = [&](std::size_t side, int i) -> Vector3d {
        const int member = layer.members[side];
        const OrganStep& organ = organs[ToSize(joint.members()[ToSize(member)].organ)];
        return layer.bed.surface_points[side][ToSize(i)].Position(organ.state().vertices,
                                                                  organ.model().rest().triangles) +
               organ.state().offset_W;
      };
      for (int i = 0; i < layer.bed.size(); ++i) {
        if (link.state().Left(l, i) == 0) continue;
        const double distance = distance_of(
            Fibres{place(0, i), place(1, i), std::sqrt(layer.bed.Footprint(i) / std::numbers::pi)});
        if (distance < kOutOfReach) reached_.push_back({&link, l, i, distance});
      }
    }
  }
  // Equal distances stay in the order of the samples.
  std::ranges::sort(reached_, [](const Reached& first, const Reached& second) {
    if (first.distance != second.distance) return first.distance < second.distance;
    return std::tuple(first.link, first.layer, first.sample) <
           std::tuple(second.link, second.layer, second.sample);
  });
}

// Lists in reached_ the samples that the tip of a hook heats.
void LayerActions::FindHeated(const ToolPose& tool, const ToolGeometry& geometry,
                              const std::vector<OrganStep>& organs,
                              std::span<AttachmentLink> links) {
  const Vector3d p_tip_W = tool.X_WT.translation();
  Find(organs, links, [&](const Fibres& fibres) {
    const Vector3d nearest_W = ClosestPointOnSegment(p_tip_W, fibres.a_W, fibres.b_W);
    const double distance = (nearest_W - p_tip_W).norm();
    const double reach = geometry.tip_radius + kHeatReach + fibres.radius;
    return distance <= reach ? distance : kOutOfReach;
  });
}

// Burns the samples in reached_. Returns the heat spent, J.
double LayerActions::Burn(double energy) {
  double left = energy;
  for (const Reached& at : reached_) {
    const AttachmentBed& bed = at.link->joint().layers()[at.layer].bed;
    const double heat = bed.options.burn_energy * bed.areas[at.sample];  // J, of the whole sample
    left -= heat * at.link->Burn(at.layer, at.sample, left / heat);
    if (!(left > 0)) break;
  }
  return energy - std::max(left, 0.0);
}

// Returns the area cut, m^2. The blades lie in the plane y = 0 of the tool's frame and turn about
// x = 0 at the end of the jaws.
double LayerActions::Cut(const ToolPose& tool, const ToolGeometry& geometry, double widest,
                         const std::vector<OrganStep>& organs, std::span<AttachmentLink> links) {
  const Isometry3d X_TW = tool.X_WT.inverse();
  const double pivot = geometry.JawsLength(), slope = std::tan(widest * geometry.opening);
  Find(organs, links, [&](const Fibres& fibres) {
    const Vector3d a_T = X_TW * fibres.a_W, b_T = X_TW * fibres.b_W;
    const Vector3d p_T = a_T + NearestShareToPlane(a_T, b_T) * (b_T - a_T);
    const double reach = fibres.radius + kBladeThickness / 2;
    const bool between = std::abs(p_T.y()) <= reach && p_T.z() >= -geometry.tip_radius &&
                         p_T.z() <= pivot && std::abs(p_T.x()) <= (pivot - p_T.z()) * slope;
    return between ? pivot - p_T.z() : kOutOfReach;
  });
  double area = 0;
  for (const Reached& at : reached_) {
    area += at.link->joint().layers()[at.layer].bed.areas[at.sample] *
            at.link->Cut(at.layer, at.sample, 1);
  }
  return area;
}

}  // namespace hpdm
