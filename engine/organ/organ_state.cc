#include "engine/organ/organ_state.h"

#include <utility>

namespace hpdm {
namespace {

std::shared_ptr<ElasticSupports> SupportsOf(const OrganModel& model, const Relaxation& relaxation,
                                            Eigen::Index rows) {
  const LatticeOrgan* organ = model.lattice_organ();
  if (organ == nullptr || organ->elastic_supports().size() == 0) return nullptr;
  return std::make_shared<ElasticSupports>(*relaxation.compliance(), organ->elastic_supports(),
                                           rows);
}

LumenLeaks LeaksOf(const OrganModel& model, const Relaxation& relaxation, Eigen::Index rows) {
  const LatticeOrgan* organ = model.lattice_organ();
  if (organ == nullptr || organ->fillings_and_layers().lumens().empty()) return {};
  return {organ->fillings_and_layers(), organ->lattice(), *relaxation.compliance(), rows,
          HasLeakingLumens(model.options())};
}

// Turns p (m) about the mean rest point of a free organ's row.
Vector3d TurnAboutMean(const OrganModel& model, const Matrix3d& rotation, const Vector3d& p,
                       const Eigen::Ref<const Eigen::RowVectorXd>& row) {
  const FreeBody* body = model.free_body();
  if (body == nullptr) return p;
  const Eigen::Index n = body->arms.rows();
  const Vector3d mean = body->p_centre_W + (row.head(n) * body->arms).transpose();
  return mean + rotation * (p - mean);
}

}  // namespace

OrganState::OrganState(const OrganModel& model, int tools, std::function<Nanoseconds()> clock)
    : control_displacements(Points::Zero(model.control_points() + model.RefinementSlots(tools), 3)),
      vertices(model.rest().vertices),
      tree(model.rest().vertices, model.rest().triangles),
      contacts(model.control_points(),
               model.refinement_basis() != nullptr ? model.refinement_basis()->size() : 0,
               model.RefinementSlots(tools)),
      neighbourhoods(model.rest().triangles, model.topology()),
      relaxation(model.MakeRelaxation(model.RefinementSlots(tools), std::move(clock))),
      memory(model.options().material.prony, static_cast<int>(control_displacements.rows()),
             SupportsOf(model, *relaxation, control_displacements.rows())),
      leaks(LeaksOf(model, *relaxation, control_displacements.rows())),
      awake(model.options().free.has_value()),
      tips(static_cast<int>(control_displacements.rows())) {
  if (const CoarseSurface* coarse = model.coarse_surface(); coarse != nullptr) {
    coarse_neighbourhoods.emplace(coarse->triangles(), coarse->topology());
  }
  const LatticeCompliance* compliance = relaxation->compliance();
  std::vector<Matrix3d> of_vertices;
  for (int v = 0; v < vertices.rows() && compliance != nullptr; ++v) {
    of_vertices.push_back(compliance->PointCompliance(model.LatticeRow(v)));
  }
  vertex_compliances = std::make_shared<const std::vector<Matrix3d>>(std::move(of_vertices));
}

Vector3d OrganState::TurnedRest(const OrganModel& model, const Vector3d& p_rest_W,
                                const Eigen::Ref<const Eigen::RowVectorXd>& row) const {
  return TurnAboutMean(model, relaxation->Rotation(), p_rest_W, row);
}

Vector3d OrganState::RestOfTurned(const OrganModel& model, const Vector3d& turned_W,
                                  const Eigen::Ref<const Eigen::RowVectorXd>& row) const {
  return TurnAboutMean(model, relaxation->Rotation().transpose(), turned_W, row);
}

}  // namespace hpdm
