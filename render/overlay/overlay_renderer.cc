#include "render/overlay/overlay_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/check.h"
#include "render/overlay/contact_marks.h"
#include "render/overlay/lattice_marks.h"

namespace hpdm {
namespace {

constexpr double kMinSpot = 0.02;  // m

int ContactCount(const SceneSnapshot& snapshot) {
  return std::min(snapshot.tool_count, kMaxInstruments);
}

}  // namespace

double RoundedUp(double value) {
  if (!(value > 0)) return 1e-3;
  const double decade = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {1., 2., 5.}) {
    if (step * decade >= value) return step * decade;
  }
  return 10 * decade;
}

OverlayRenderer::OverlayRenderer(const std::vector<OrganVisual>& organs) : organs_(organs) {
  for (const OrganVisual& organ : organs_) {
    const bool has_lattice = organ.model != nullptr && organ.model->lattice_organ() != nullptr;
    presence_.push_back(has_lattice ? ControlPointPresence(*organ.model) : Eigen::VectorXf());
  }
}

void OverlayRenderer::Draw(const SceneSnapshot& snapshot, const Laparoscope& scope,
                           std::uint32_t overlays, OrganRenderer* organs) {
  if (overlays & kOverlayError) DrawErrors(snapshot, organs);
  if (overlays & kOverlayForce) DrawForces(snapshot, *organs);
  if (overlays & kOverlayLattice) {
    marks_.clear();
    for (std::size_t o = 0; o < organs_.size(); ++o) {
      if (organs_[o].model == nullptr) continue;
      AddLatticeMarks(*organs_[o].model, presence_[o], snapshot.organs[o], &marks_);
    }
    mark_renderer_.Draw(marks_, 0.3f, 0.9 * scope.target_distance());
  }
  if (overlays & kOverlayContacts) {
    marks_.clear();
    for (int t = 0; t < ContactCount(snapshot); ++t) {
      AddContact(snapshot.contacts[t], snapshot);
      for (const SolvedContact& contact : snapshot.beside[t]) AddContact(contact, snapshot);
    }
    mark_renderer_.Draw(marks_, 0.6f, Laparoscope::kFar);
  }
}

void OverlayRenderer::AddContact(const SolvedContact& contact, const SceneSnapshot& snapshot) {
  if (contact.organ < 0 || contact.organ >= static_cast<int>(organs_.size())) return;
  const auto organ = static_cast<std::size_t>(contact.organ);
  AddContactMarks(contact, snapshot.organs[organ], organs_[organ].rest->triangles, &marks_);
}

void OverlayRenderer::DrawScales(std::uint32_t overlays) {
  const bool has_reference =
      std::any_of(organs_.begin(), organs_.end(),
                  [](const OrganVisual& organ) { return organ.reference != nullptr; });
  int bars = 0;
  if (overlays & kOverlayForce) heat_.DrawBar(bars++);
  if ((overlays & kOverlayError) && has_reference) heat_.DrawBar(bars++);
}

void OverlayRenderer::DrawForces(const SceneSnapshot& snapshot, const OrganRenderer& organs) {
  for (std::size_t o = 0; o < organs_.size(); ++o) {
    std::array<ForceSpot, kMaxInstruments> spots;
    int count = 0;
    for (int t = 0; t < ContactCount(snapshot); ++t) {
      // An instrument presses an organ at one place at most.
      const auto add = [&](const SolvedContact& contact) {
        const double force = contact.force_on_tissue_W.norm();
        if (contact.organ != static_cast<int>(o) || !(force > 0) || count == kMaxInstruments)
          return;
        spots[count++] = {contact.contact_W,
                          std::max(kForceSpotRadii * contact.kernel_radius, kMinSpot), force};
      };
      add(snapshot.contacts[t]);
      for (const SolvedContact& contact : snapshot.beside[t]) add(contact);
    }
    heat_.DrawForce(organs.mesh(o), spots, count, kForceScale);
  }
}

void OverlayRenderer::DrawErrors(const SceneSnapshot& snapshot, OrganRenderer* organs) {
  for (std::size_t o = 0; o < organs_.size(); ++o) {
    if (organs_[o].reference == nullptr) continue;
    const OrganSnapshot& shape = snapshot.organs[o];
    const Points& rest = organs_[o].rest->vertices;
    const Points& reference = *organs_[o].reference;
    HPDM_CHECK(reference.rows() == rest.rows() && shape.vertices.rows() == rest.rows());
    error_.resize(static_cast<std::size_t>(rest.rows()));
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
      const Eigen::RowVector3d u = shape.vertices.row(v).cast<double>() - rest.row(v);
      error_[static_cast<std::size_t>(v)] =
          static_cast<float>((u - reference.row(v)).norm() / organs_[o].error_scale);
    }
    organs->mesh(o).SetHeat(error_);
    heat_.DrawVertexHeat(organs->mesh(o));
  }
}

}  // namespace hpdm
