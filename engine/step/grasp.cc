#include "engine/step/grasp.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace hpdm {
namespace {

// Quadrature points of a face across (y) and along the jaw (z), and of a pinched strip.
constexpr int kAcross = 4, kAlong = 8;
static_assert(kAcross * kAlong <= Footprint::kMaxPoints);

// Fewest points of a face between which tissue counts as held.
constexpr int kMinHeld = 4;

// Smallest sine of the angle between the direction in which the jaws open and the normal. Below it
// one jaw lies flat on the surface.
constexpr double kMinOpening = 0.3;

// Point i of n on [low, high], where the density 1 / sqrt(1 - x^2) gives each an equal share.
struct Node {
  double at, size;  // m
};
Node NodeOf(int i, int n, double low, double high) {
  const auto edge = [&](int k) { return std::cos(std::numbers::pi * k / n); };
  const double half = (high - low) / 2;
  return {(low + high) / 2 - half * std::cos(std::numbers::pi * (i + 0.5) / n),
          half * (edge(i) - edge(i + 1))};
}

// Returns the place where the jaws' capsule touches the contact's organ, and moves the contact
// there; none if it does not.
std::optional<Vector3d> TouchOnJaws(const Isometry3d& X_WT, const ToolGeometry& geometry,
                                    const OrganModel& model, OrganState* state,
                                    TipContact* contact) {
  const Triangles& triangles = model.rest().triangles;
  if (!contact->from_tick && contact->gap > Grasp::kTouch) {
    const SurfaceHit hit = state->tree.ClosestToSegment(
        X_WT.translation(), X_WT * JawsEnd(geometry), geometry.tip_radius + Grasp::kTouch);
    if (hit.at.triangle < 0) return std::nullopt;
    contact->at = hit.at;
    contact->UpdateNeighbourhood(model, state);
  }
  return contact->at.Position(state->vertices, triangles);
}

}  // namespace

void Grasp::Take(const ToolPose& tool, const ToolGeometry& geometry, const TipPress& press,
                 const OrganModel& model, OrganState* state, TipContact* contact) {
  const Vector3d force_W =
      state->memory.IsElastic() ? contact->force_W : contact->equilibrium_force_W;
  for (Footprint& footprint : footprints_) footprint.Clear();
  slip_T_.setZero();
  has_lattice_rows_ = false;
  between_ = TakeBetween(tool, geometry, model, state, contact);
  if (between_ || TakeTouched(tool, geometry, model, state, contact)) {
    Tie(tool, model, state, *contact);
    PlaceTargets(tool, press, force_W, model, state);
  }
}

bool Grasp::TakeBetween(const ToolPose& tool, const ToolGeometry& geometry, const OrganModel& model,
                        OrganState* state, TipContact* contact) {
  const double opening = kHalfOpening * geometry.tip_radius;
  const double length = JawsEnd(geometry).z();
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < kAcross; ++i) {
    const Node y = NodeOf(i, kAcross, -geometry.tip_radius, geometry.tip_radius);
    for (int j = 0; j < kAlong; ++j) {
      const Node z = NodeOf(j, kAlong, 0, length);
      const Vector3d plus = tool.X_WT * Vector3d(opening, y.at, z.at);
      const Vector3d minus = tool.X_WT * Vector3d(-opening, y.at, z.at);
      const SurfaceHit at_plus = state->tree.FirstEntry(plus, minus);
      const SurfaceHit at_minus = state->tree.FirstEntry(minus, plus);
      if (at_plus.at.triangle < 0 || at_minus.at.triangle < 0) continue;
      if (at_plus.along + at_minus.along >= 1) continue;  // a gap, not tissue
      footprints_[0].Add({at_plus.at, {y.at, z.at}, {y.size, z.size}});
      footprints_[1].Add({at_minus.at, {y.at, z.at}, {y.size, z.size}});
      sum += Vector3d(0, y.at, z.at);
    }
  }
  const int held = footprints_[0].size();
  if (held < kMinHeld) {
    for (Footprint& footprint : footprints_) footprint.Clear();
    return false;
  }
  middle_T_ = sum / held;
  contact->at = MiddleOfNearerFace(model.rest(), contact->at);
  contact->UpdateNeighbourhood(model, state);
  return true;
}

// Returns the middle of the face that lies nearer to `pressed` at rest, of any face if the tip pressed
// nothing. Jaws around a wall have one face inside of it; when they let go, the tip is still on the side
// from which it came.
SurfacePoint Grasp::MiddleOfNearerFace(const SurfaceMesh& rest, const SurfacePoint& pressed) const {
  const auto middle = [this](std::size_t jaw) {
    return footprints_[jaw][footprints_[jaw].size() / 2].at;
  };
  if (pressed.triangle < 0) return middle(0);
  const Vector3d p = pressed.Position(rest.vertices, rest.triangles);
  const auto distance = [&](const SurfacePoint& at) {
    return (at.Position(rest.vertices, rest.triangles) - p).squaredNorm();
  };
  const SurfacePoint one = middle(0), other = middle(1);
  return distance(one) <= distance(other) ? one : other;
}

bool Grasp::TakeTouched(const ToolPose& tool, const ToolGeometry& geometry, const OrganModel& model,
                        OrganState* state, TipContact* contact) {
  const std::optional<Vector3d> touch = TouchOnJaws(tool.X_WT, geometry, model, state, contact);
  if (!touch) return false;
  const Vector3d normal =
      InterpolatedNormal(state->vertices, model.rest().triangles, model.topology(), contact->at);
  const auto along_surface = [&](int axis) {
    const Vector3d direction = tool.X_WT.linear().col(axis);
    return Vector3d(direction - normal.dot(direction) * normal);
  };
  Vector3d apart = along_surface(0);
  if (apart.norm() < kMinOpening) apart = along_surface(2);
  apart = apart.stableNormalized();
  const Vector3d across = normal.cross(apart);
  const double r = geometry.tip_radius, size = kHalfOpening * r;
  for (int i = 0; i < kAlong; ++i) {
    const Node u = NodeOf(i, kAlong, -size, size);
    for (int j = 0; j < kAcross; ++j) {
      const Node v = NodeOf(j, kAcross, -r, r);
      const Vector3d p = *touch + u.at * apart + v.at * across;
      const SurfaceHit hit = state->tree.FirstEntry(p + size * normal, p - size * normal);
      if (hit.at.triangle < 0) continue;
      footprints_[0].Add({hit.at, {u.at, v.at}, {u.size, v.size}});
    }
  }
  if (footprints_[0].size() == 0) footprints_[0].Add({contact->at, {0, 0}, {size, size}});
  middle_T_ = JawsEnd(geometry) / 2;
  return true;
}

// Fixes the ties of what the footprints cover.
void Grasp::Tie(const ToolPose& tool, const OrganModel& model, OrganState* state,
                const TipContact& contact) {
  const std::size_t jaws = footprints_[1].size() > 0 ? 2 : 1;
  const SurfaceMesh& rest = model.rest();
  const double thickness = between_ ? Thickness(model) : 0;
  rows_ = 0;
  p_middle_rest_W_.setZero();
  for (std::size_t jaw = 0; jaw < jaws; ++jaw) {
    Footprint& footprint = footprints_[jaw];
    footprint.Resolve(model, thickness, &state->neighbourhoods);
    for (int row = 0; row < footprint.rows(); ++row) {
      Vector3d& p_rest_W = p_rest_W_[ToSize(rows_++)];
      p_rest_W = footprint.Mean(row, rest.vertices, rest.triangles);
      p_middle_rest_W_ += p_rest_W;
    }
  }
  FillLocalCoupling({footprints_.data(), jaws}, &coupling_);
  p_middle_rest_W_ /= rows_;
  reach_ = 0;
  for (std::size_t jaw = 0; jaw < jaws; ++jaw) {
    for (int i = 0; i < footprints_[jaw].size(); ++i) {
      const Vector3d p = footprints_[jaw][i].at.Position(rest.vertices, rest.triangles);
      reach_ = std::max(reach_, 2 * (p - p_middle_rest_W_).norm());
    }
  }
  p_contact_T_ = tool.X_WT.inverse() * contact.at.Position(state->vertices, rest.triangles);
}

// Places the targets where the rows are now, but under equal shares of the force of the press that
// ends, instead of under the press itself. Then the ties begin with this force. Models without a
// compliance only stay where they are.
void Grasp::PlaceTargets(const ToolPose& tool, const TipPress& press, const Vector3d& force_W,
                         const OrganModel& model, OrganState* state) {
  UpdateLatticeRows(model, state->contacts.refinement);
  const Points& U = state->control_displacements;
  const Eigen::Index columns = U.rows();
  const auto rows = lattice_rows_.topLeftCorner(rows_, columns);
  auto moved = moved_.head(3 * columns);
  moved.setZero();
  const LatticeCompliance* compliance = state->present_compliance;
  const bool keeps_force = compliance != nullptr && !force_W.isZero(0);
  if (keeps_force) {
    auto change = state->tips.ScratchRow();
    press.AddKernelToRow(model, *state, change);
    change = rows.colwise().mean() - change;
    auto response = response_.topRows(3 * columns);
    compliance->RespondTo(state->tips.Compress(change), response);
    moved.noalias() = response * force_W;
  }
  const Isometry3d X_TW = tool.X_WT.inverse();
  for (int row = 0; row < rows_; ++row) {
    Vector3d p_W = state->TurnedRest(model, p_rest_W_[ToSize(row)], rows.row(row));
    for (Eigen::Index i = 0; i < columns; ++i) {
      p_W += rows(row, i) * (U.row(i).transpose() + moved.segment<3>(3 * i));
    }
    for (int other = 0; keeps_force && other < rows_; ++other) {
      p_W += coupling_.block<3, 3>(3 * row, 3 * other) * force_W / rows_;
    }
    p_T_[ToSize(row)] = X_TW * p_W;
  }
}

// Returns the mean distance of the two faces' points at rest, m.
double Grasp::Thickness(const OrganModel& model) const {
  const SurfaceMesh& rest = model.rest();
  const int count = footprints_[0].size();
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    sum += (footprints_[0][i].at.Position(rest.vertices, rest.triangles) -
            footprints_[1][i].at.Position(rest.vertices, rest.triangles))
               .norm();
  }
  return sum / count;
}

void Grasp::Slip(const Vector3d& slip_T, const ToolGeometry& geometry) {
  if (!holds() || !slip_T.allFinite()) return;
  slip_T_ = slip_T;
  const Vector3d middle_T = middle_T_ + slip_T_;
  const bool on_faces = std::abs(middle_T.y()) <= geometry.tip_radius && middle_T.z() >= 0 &&
                        middle_T.z() <= JawsEnd(geometry).z();
  if (!on_faces) Release();
}

// The rows stay the same while the grasp holds, unless the local functions change.
void Grasp::UpdateLatticeRows(const OrganModel& model, const ActiveRefinement& active) {
  bool same = has_lattice_rows_;
  for (int s = 0; s < active.slots(); ++s) {
    same = same && slots_[ToSize(s)] == active.Function(s);
    slots_[ToSize(s)] = active.Function(s);
  }
  if (same) return;
  has_lattice_rows_ = true;
  lattice_rows_.setZero();
  const int columns = model.control_points() + active.slots();
  int place = 0;
  for (const Footprint& footprint : footprints_) {
    if (footprint.size() == 0) continue;
    for (int k = 0; k < footprint.rows(); ++k, ++place) {
      footprint.AddToRow(k, model, active, lattice_rows_.row(place).head(columns));
    }
  }
}

bool Grasp::AddRows(const ToolPose& tool, const OrganModel& model, OrganState* state) {
  UpdateLatticeRows(model, state->contacts.refinement);
  int place = 0;
  for (const Footprint& footprint : footprints_) {
    if (footprint.size() == 0) continue;
    for (int k = 0; k < footprint.rows(); ++k, ++place) {
      ContactConstraints::Row* row = state->contacts.Add();
      if (row == nullptr) return false;
      row->kind = ContactConstraints::RowKind::kGrasp;
      row->tool = tool_;
      row->target_W = tool.X_WT * (p_T_[ToSize(place)] + slip_T_);
      row->local_compliance_W = coupling_.block<3, 3>(3 * place, 3 * place);
      row->coupled = {&coupling_, place};
      auto weights = state->contacts.WeightRow(state->contacts.size() - 1);
      weights = lattice_rows_.row(place).head(weights.size());
      row->p_rest_W = state->TurnedRest(model, p_rest_W_[ToSize(place)], weights);
    }
  }
  return true;
}

}  // namespace hpdm
