// The set-up of a DeformationLoop: its tools, and the organs that attachments and ducts join.

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/check.h"
#include "engine/deformation_loop.h"

namespace hpdm {
namespace {

// m. A tool that never had a pose is placed this far from any organ.
constexpr double kFarAway = 1e3;

Sheddable SheddableIn(const std::vector<OrganModel>& organs) {
  std::vector<OrganOptions> options;
  for (const OrganModel& organ : organs) options.push_back(organ.options());
  return SheddableOf(options);
}

}  // namespace

DeformationLoop::DeformationLoop(const std::vector<OrganModel>& organs,
                                 const std::vector<ToolOptions>& tools,
                                 const DeformationEdges& edges,
                                 std::function<Nanoseconds()> stopwatch, Nanoseconds budget,
                                 const std::vector<AttachmentOptions>& attachments,
                                 const std::vector<DuctOptions>& ducts)
    : edges_(edges),
      stopwatch_(std::move(stopwatch)),
      organ_contacts_(organs),
      joint_relaxation_(organ_contacts_.pairs()),
      layer_actions_(tools),
      duct_actions_(tools),
      wall_actions_(tools),
      shedding_(SheddableIn(organs), budget) {
  HPDM_CHECK(tools.size() <= kMaxInstruments && organs.size() <= kMaxOrgans);
  organs_.reserve(organs.size());
  for (const OrganModel& model : organs) {
    organs_.emplace_back(model, static_cast<int>(tools.size()), stopwatch_);
  }
  for (const ToolOptions& tool : tools) {
    std::vector<ToolAction>& actions = actions_.emplace_back();
    for (const ToolGeometry& geometry : tool.geometries) actions.push_back(geometry.action);
  }
  for (ToolPose& tool : tools_.tools) tool.X_WT.translation().setConstant(kFarAway);
  Eigen::Index columns = 0;
  for (const OrganStep& organ : organs_) {
    columns = std::max(columns, organ.state().control_displacements.rows());
  }
  trackers_.reserve(tools.size());
  if (organ_contacts_.pairs() > 0) loads_.resize(3 * columns, ContactSolver::kMaxEquations);
  for (std::size_t t = 0; t < tools.size(); ++t) {
    trackers_.emplace_back(static_cast<int>(t), tools[t]).Reserve(columns);
  }
  if (!attachments.empty() || !ducts.empty()) Join(attachments, ducts);
}

AttachmentJoint::Organ DeformationLoop::JoinedOrganOf(const std::string& name) const {
  for (std::size_t o = 0; o < organs_.size(); ++o) {
    const OrganModel& model = organs_[o].model();
    if (model.options().name != name) continue;
    HPDM_CHECK(TakesAttachments(model.options()));
    const OrganState& state = organs_[o].state();
    return JoinedOrgan(static_cast<int>(o), model, *state.relaxation,
                       state.control_displacements.rows());
  }
  return {.index = -1};
}

// Returns the beds of the attachments, and adds the organs of each to `pairs`.
std::vector<AttachmentBed> DeformationLoop::MakeBeds(
    const std::vector<AttachmentOptions>& attachments, std::vector<JoinedPair>* pairs) {
  std::vector<AttachmentBed> beds;
  for (const AttachmentOptions& attachment : attachments) {
    const JoinedPair& pair =
        pairs->emplace_back(JoinedPair{JoinedOrganOf(attachment.a), JoinedOrganOf(attachment.b)});
    HPDM_CHECK(pair[0].index != pair[1].index);
    organ_contacts_.Wait({pair[0].index, pair[1].index});
    beds.emplace_back(attachment, organs_[ToSize(pair[0].index)].model(),
                      organs_[ToSize(pair[1].index)].model(), static_cast<int>(beds.size()));
    for (std::size_t other = 0; other + 1 < beds.size(); ++other) {
      RefuseSharedSurface(beds[other], beds.back());
    }
  }
  return beds;
}

// The same for ducts. An end that the world holds has no organ.
std::vector<std::shared_ptr<const DuctModel>> DeformationLoop::MakeDucts(
    const std::vector<DuctOptions>& ducts, std::vector<JoinedPair>* pairs) {
  const auto model_of = [&](const AttachmentJoint::Organ& organ) {
    return organ.index < 0 ? nullptr : &organs_[ToSize(organ.index)].model();
  };
  std::vector<std::shared_ptr<const DuctModel>> models;
  for (const DuctOptions& duct : ducts) {
    const JoinedPair& pair =
        pairs->emplace_back(JoinedPair{JoinedOrganOf(duct.a), JoinedOrganOf(duct.b)});
    models.push_back(std::make_shared<const DuctModel>(duct, model_of(pair[0]), model_of(pair[1]),
                                                       static_cast<int>(models.size())));
    for (std::size_t other = 0; other + 1 < models.size(); ++other) {
      RefuseSharedEnds(*models[other], *models.back());
    }
  }
  return models;
}

void DeformationLoop::Join(const std::vector<AttachmentOptions>& attachments,
                           const std::vector<DuctOptions>& ducts) {
  std::vector<JoinedPair> pairs;
  std::vector<AttachmentBed> beds = MakeBeds(attachments, &pairs);
  std::vector<std::shared_ptr<const DuctModel>> models = MakeDucts(ducts, &pairs);
  const bool may_repeat = std::ranges::any_of(
      organs_, [](const OrganStep& organ) { return organ.model().finite_energy() != nullptr; });
  std::vector<AttachmentLink> links;
  for (auto& joint : JoinOrgans(std::move(beds), pairs, std::move(models))) {
    attached_work_.MakeRoom(*joint, 3 * TipCompliance::kMaxRows);
    links.emplace_back(std::move(joint));
    if (may_repeat) links.back().MayRepeat();
  }
  joint_relaxation_ = JointRelaxation(organ_contacts_.pairs(), std::move(links));
  for (const AttachmentLink& link : joint_relaxation_.links()) HoldOrgans(link);
}

// Gives the joint's organs the compliances that their vertices have with its layers and ducts at rest.
void DeformationLoop::HoldOrgans(const AttachmentLink& link) {
  for (std::size_t m = 0; m < link.joint().members().size(); ++m) {
    OrganStep& organ = organs_[ToSize(link.joint().members()[m].organ)];
    if (organ.model().rigid()) continue;
    OrganState& state = organ.state();
    state.relaxation->body()->SetHeld(true);
    const AttachedCompliance compliance(*state.relaxation->compliance(), link.state(),
                                        static_cast<int>(m), &attached_work_);
    std::vector<Matrix3d> of_vertices;
    for (int v = 0; v < state.vertices.rows(); ++v) {
      of_vertices.push_back(compliance.PointCompliance(organ.model().LatticeRow(v)));
    }
    state.attached = true;
    state.vertex_compliances =
        std::make_shared<const std::vector<Matrix3d>>(std::move(of_vertices));
  }
}

}  // namespace hpdm
