#include "engine/step/shaft_tracker.h"

#include <algorithm>
#include <cmath>

namespace hpdm {
namespace {

// m. Within this distance an organ gets a place though the shaft stands still.
constexpr double kStandingReach = 0.02;

// The instrument's geometry with the shaft in place of the tip.
ToolGeometry BallOf(const ToolGeometry& geometry) {
  ToolGeometry ball = geometry;
  ball.tip_radius = geometry.shaft_radius;
  return ball;
}

}  // namespace

ShaftTracker::Place::Place(int tool, const ToolOptions& options)
    : press(tool, 0, options.wall_stiffness, options.walls),
      patch_builder(options.prefetch, {.k1 = options.k1, .k2 = options.k2}) {}

ShaftTracker::ShaftTracker(int tool, const ToolOptions& options)
    : tool_(tool), reaction_(options.reaction), places_(kShaftPlaces, Place(tool, options)) {}

void ShaftTracker::Release() {
  for (Place& place : places_) place.contact = {};
  started_ = false;
}

bool ShaftTracker::touches() const {
  return std::any_of(places_.begin(), places_.end(), [](const Place& place) {
    return place.contact.organ >= 0 && place.contact.row >= 0;
  });
}

ShaftTracker::Axis ShaftTracker::AxisOf(const ToolPose& tool, double end) {
  Axis axis;
  axis.p_trocar_W = tool.p_trocar_W;
  axis.direction_W = tool.X_WT.linear().col(2);
  axis.length = axis.direction_W.dot(tool.p_trocar_W - tool.X_WT.translation());
  axis.end = axis.length - end;
  return axis;
}

// Returns where the shaft's part ends on an organ, m from the trocar.
double ShaftTracker::EndOn(int organ, const Input& input) const {
  if (organ != input.held_organ) return axis_.end;
  return std::min(axis_.end, axis_.length - input.geometry.JawsLength() - input.grasp->reach());
}

void ShaftTracker::Track(const Input& input,
                         std::span<const TickContactPoint, kShaftPlaces> contact_points,
                         std::vector<OrganStep>* organs) {
  axis_ = AxisOf(input.tool, input.geometry.JawsLength() + input.below);
  for (std::size_t o = 0; o < organs->size(); ++o) ends_[o] = EndOn(static_cast<int>(o), input);
  for (std::size_t p = 0; p < places_.size(); ++p) {
    KeepPlace(input, contact_points[p], *organs, &places_[p]);
  }
  FindCandidates(input, *organs);
  GivePlaces();
  for (Place& place : places_) UpdateContact(input, organs, &place);
  axis_last_ = axis_;
  started_ = true;
}

// Keeps the place if its contact continues: in the tick, or from the last step.
void ShaftTracker::KeepPlace(const Input& input, const TickContactPoint& contact_point,
                             const std::vector<OrganStep>& organs, Place* place) const {
  TipContact& contact = place->contact;
  const bool pressed = contact.touching && contact.organ >= 0;
  const bool lost = contact_point.known_organ != contact.organ ||
                    (contact_point.organ >= 0 && contact_point.triangle < 0);
  contact.from_tick = contact_point.organ >= 0 && contact_point.triangle >= 0 &&
                      !input.pierced[ToSize(contact_point.organ)];
  contact.normal_W.setZero();
  contact.friction_W.setZero();
  place->ahead = false;
  place->taken = contact.from_tick;
  if (contact.from_tick) {
    contact.organ = contact_point.organ;
    contact.at = {contact_point.triangle, contact_point.weights};
    contact.normal_W = contact_point.normal_W;
    contact.friction_W = contact_point.friction_W;
    place->from_trocar = contact_point.from_trocar;
    return;
  }
  if (!pressed || !lost) return;
  const OrganState& state = organs[contact.organ].state();
  const Triangles& triangles = organs[contact.organ].model().rest().triangles;
  const Vector3d p_W = contact.at.Position(state.vertices, triangles) + state.offset_W;
  const double end = ends_[contact.organ];
  place->from_trocar =
      std::clamp(axis_.direction_W.dot(axis_.p_trocar_W - p_W), 0.0, std::max(end, 0.0));
  contact.at = ClosestIn(contact.around, state.vertices, triangles,
                         axis_.At(place->from_trocar) - state.offset_W);
  const Candidate found{.organ = contact.organ, .at = contact.at};
  place->taken = end > 0 && Counts(input, organs[contact.organ], found);
}

// True unless the shaft meets the surface end on, or tissue that its own jaws hold.
bool ShaftTracker::Counts(const Input& input, const OrganStep& organ,
                          const Candidate& candidate) const {
  const SurfaceMesh& rest = organ.model().rest();
  const Vector3d facing = InterpolatedNormal(organ.state().vertices, rest.triangles,
                                             organ.model().topology(), candidate.at);
  if (facing.squaredNorm() == 0) return false;
  if (!candidate.outside && std::abs(axis_.direction_W.dot(facing)) > kMaxEndOn) return false;
  return candidate.organ != input.held_organ ||
         !input.grasp->Holds(candidate.at.Position(rest.vertices, rest.triangles));
}

// Lists the organs that the shaft touches or may touch next, besides the places that are taken, the
// first ones first.
void ShaftTracker::FindCandidates(const Input& input, const std::vector<OrganStep>& organs) {
  candidates_.count = 0;
  for (std::size_t o = 0; o < organs.size(); ++o) {
    if (input.pierced[o]) continue;
    // The parts of the axis that are kShaftApart from other places on the organ.
    std::array<Part, 2 * kShaftPlaces + 1> parts{Part{0, ends_[o]}};
    std::size_t count = 1;
    const auto keep_apart = [&](double from_trocar) {
      for (std::size_t i = count; i-- > 0;) {
        Part& part = parts[i];
        if (from_trocar - kShaftApart >= part.to || from_trocar + kShaftApart <= part.from)
          continue;
        parts[count++] = {from_trocar + kShaftApart, part.to};
        part.to = from_trocar - kShaftApart;
      }
    };
    int places = 0;
    for (const Place& place : places_) {
      if (!place.taken || place.contact.organ != static_cast<int>(o)) continue;
      keep_apart(place.from_trocar);
      ++places;
    }
    for (; places < kShaftPlaces; ++places) {
      Candidate best;
      for (std::size_t i = 0; i < count; ++i) {
        Candidate candidate;
        candidate.organ = static_cast<int>(o);
        if (parts[i].to <= parts[i].from || !FindIn(parts[i], input, organs[o], &candidate))
          continue;
        const bool first = best.organ < 0 || candidate.entered > best.entered ||
                           (candidate.entered == best.entered && candidate.order < best.order);
        if (first) best = candidate;
      }
      if (best.organ < 0) break;
      candidates_.list[candidates_.count++] = best;
      keep_apart(best.from_trocar);
    }
  }
  const auto first = candidates_.list.begin();
  std::sort(first, first + candidates_.count, [](const Candidate& a, const Candidate& c) {
    if (a.entered != c.entered) return a.entered;
    if (a.order != c.order) return a.order < c.order;
    return a.organ != c.organ ? a.organ < c.organ : a.from_trocar < c.from_trocar;
  });
}

// Finds where a part of the shaft entered the organ since the last step, or will first touch it, or
// is nearest. False if it stays out of reach.
bool ShaftTracker::FindIn(const Part& part, const Input& input, const OrganStep& organ,
                          Candidate* candidate) const {
  const OrganState& state = organ.state();
  const double radius = input.geometry.shaft_radius;
  const Vector3d start = axis_.At(part.to) - state.offset_W;
  const Vector3d end = axis_.At(part.from) - state.offset_W;
  const auto take = [&](const SurfaceHit& hit) {
    candidate->at = hit.at;
    candidate->from_trocar = part.to + hit.along * (part.from - part.to);
    return Counts(input, organ, *candidate);
  };
  if (started_) {
    double share = 0;
    const SurfaceHit entry = state.tree.FirstTouch(axis_last_.At(part.to) - state.offset_last_W,
                                                   axis_last_.At(part.from) - state.offset_last_W,
                                                   start, end, radius, &share);
    candidate->outside = entry.along > 0;
    if (entry.at.triangle >= 0 && share > 0 && take(entry)) {
      candidate->entered = true;
      candidate->order = share;
      return true;
    }
  }
  const double reach = kStandingReach + kAhead * input.tool.v_tip_W.norm();
  SurfaceHit hit = state.tree.ClosestToSegment(start, end, reach);
  if (hit.at.triangle < 0) return false;
  if (hit.distance == 0) {
    // Between two crossings it is deepest in the middle, more or less.
    const SurfaceHit in = state.tree.FirstEntry(start, end),
                     out = state.tree.FirstEntry(end, start);
    if (in.at.triangle >= 0 && out.at.triangle >= 0 && in.along + out.along < 1) {
      hit.along = (in.along + 1 - out.along) / 2;
      hit.at = state.tree.Closest(start + hit.along * (end - start), reach).at;
      if (hit.at.triangle < 0) return false;
    }
  } else if (hit.distance > radius) {
    ToolPose later = input.tool;
    later.X_WT.translation() += kAhead * input.tool.v_tip_W;
    const Vector3d shaft_W = later.p_trocar_W - later.X_WT.translation();
    const Vector3d ahead_W = shaft_W.stableNormalized();
    double share = 0;
    const SurfaceHit touch = state.tree.FirstTouch(
        start, end, later.p_trocar_W - part.to * ahead_W - state.offset_W,
        later.p_trocar_W - part.from * ahead_W - state.offset_W, radius, &share);
    candidate->outside = touch.along > 0;
    if (touch.at.triangle >= 0 && take(touch)) {
      candidate->ahead = true;
      candidate->order = share * kAhead * input.tool.v_tip_W.norm();
      return true;
    }
  }
  candidate->order = hit.distance;
  candidate->outside = false;
  return take(hit);
}

// Gives the places that are not taken to the first candidates. One near the last step's keeps it.
void ShaftTracker::GivePlaces() {
  const auto is_free = [](const Place& place) { return !place.taken; };
  const auto free = std::count_if(places_.begin(), places_.end(), is_free);
  const int count = std::min(static_cast<int>(free), candidates_.count);
  std::array<bool, kShaftPlaces> given{};
  const auto take = [](const Candidate& candidate, Place* place) {
    TipContact& contact = place->contact;
    if (contact.organ != candidate.organ) {
      contact.touching = false;
      contact.force_W.setZero();
    }
    contact.organ = candidate.organ;
    contact.at = candidate.at;
    place->from_trocar = candidate.from_trocar;
    place->ahead = candidate.ahead;
    place->taken = true;
  };
  for (int i = 0; i < count; ++i) {
    const Candidate& candidate = candidates_.list[i];
    const auto distance = [&](const Place& place) {
      const bool same = !place.taken && place.contact.organ == candidate.organ;
      return same ? std::abs(place.from_trocar - candidate.from_trocar) : kShaftApart;
    };
    const auto nearest =
        std::min_element(places_.begin(), places_.end(),
                         [&](const Place& a, const Place& c) { return distance(a) < distance(c); });
    given[i] = distance(*nearest) < kShaftApart;
    if (given[i]) take(candidate, &*nearest);
  }
  for (Place& place : places_) {
    if (!place.taken) place.contact.organ = -1;
  }
  for (int i = 0; i < count; ++i) {
    if (!given[i])
      take(candidates_.list[i], &*std::find_if(places_.begin(), places_.end(), is_free));
  }
}

void ShaftTracker::UpdateContact(const Input& input, std::vector<OrganStep>* organs,
                                 Place* place) const {
  TipContact& contact = place->contact;
  if (contact.organ < 0) return;
  const OrganModel& model = (*organs)[contact.organ].model();
  OrganState& state = (*organs)[contact.organ].state();
  contact.axis_W = axis_.direction_W;
  contact.UpdateNeighbourhood(model, &state);
  const Vector3d offset = axis_.At(place->from_trocar) - state.offset_W -
                          contact.at.Position(state.vertices, model.rest().triangles);
  const Vector3d normal =
      InterpolatedNormal(state.vertices, model.rest().triangles, model.topology(), contact.at);
  const double radius = input.geometry.shaft_radius;
  contact.gap = (normal.dot(offset) < 0 ? -offset.norm() : offset.norm()) - radius;
}

// Returns the pose with the origin where the shaft presses, moving as the contact does: the shaft
// slides along its axis without it.
ToolPose ShaftTracker::BallAt(const ToolPose& tool, const Place& place) const {
  ToolPose ball = tool;
  ball.X_WT.translation() = axis_.At(place.from_trocar);
  const Vector3d across_W = tool.v_tip_W - axis_.direction_W.dot(tool.v_tip_W) * axis_.direction_W;
  ball.v_tip_W =
      place.ahead ? Vector3d::Zero() : Vector3d(place.from_trocar / axis_.length * across_W);
  return ball;
}

bool ShaftTracker::AddContacts(const ToolPose& tool, const ToolGeometry& geometry,
                               std::vector<OrganStep>* organs) {
  bool complete = true;
  for (Place& place : places_) {
    if (place.contact.organ < 0) continue;
    OrganStep& organ = (*organs)[place.contact.organ];
    complete =
        place.press.AddRow(InOrganFrame(organ.state(), BallAt(tool, place)), BallOf(geometry),
                           organ.model(), &organ.state(), &place.contact) &&
        complete;
  }
  return complete;
}

void ShaftTracker::AddTips(std::vector<OrganStep>* organs) {
  for (std::size_t p = 0; p < places_.size(); ++p) {
    Place& place = places_[p];
    TipContact& contact = place.contact;
    contact.touching = contact.alone = false;
    contact.force_W.setZero();
    contact.equilibrium_force_W.setZero();
    contact.tip = -1;
    if (contact.organ < 0) continue;
    const OrganModel& model = (*organs)[contact.organ].model();
    OrganState& state = (*organs)[contact.organ].state();
    const bool has_lattice = HasLattice(reaction_, model, state);
    if (contact.row >= 0 && contact.row < state.contacts.size()) {
      const int owner = tool_ * kToolPlaces + kMaxPlaces + static_cast<int>(p);
      AddRowToTip(contact.row, owner, has_lattice, &state, &contact);
      contact.touching = contact.force_W.squaredNorm() > 0;
      continue;
    }
    contact.alone = has_lattice;
    contact.C_wall_W = place.press.WallCompliance(model, contact);
    contact.indentation = place.press.indentation();
    contact.C_loc_W = contact.C_wall_W + contact.indentation.Compliance();
  }
}

// Returns the part of the shaft where the place's contact can begin.
ShaftPart ShaftTracker::PartOf(const Place& place) const {
  ShaftPart part{0, std::max(ends_[place.contact.organ], 0.0), place.from_trocar};
  for (const Place& other : places_) {
    if (&other == &place || other.contact.organ != place.contact.organ) continue;
    const double middle = (place.from_trocar + other.from_trocar) / 2;
    if (place.from_trocar < other.from_trocar) {
      part.to = middle;
    } else {
      part.from = middle;
    }
  }
  return part;
}

void ShaftTracker::FillPatches(const ToolPose& tool, const ToolGeometry& geometry,
                               std::vector<OrganStep>* organs,
                               std::span<ToolPatch, kShaftPlaces> patches) {
  for (std::size_t p = 0; p < places_.size(); ++p) {
    Place& place = places_[p];
    const TipContact& contact = place.contact;
    ToolPatch* const patch = &patches[p];
    PatchBuilder::Clear(tool, patch);
    patch->shaft_contact = touches();
    patch->id = tool_ * kToolPlaces + kMaxPlaces + static_cast<PlaceId>(p);
    if (contact.organ < 0) continue;
    const OrganModel& model = (*organs)[contact.organ].model();
    OrganState& state = (*organs)[contact.organ].state();
    place.patch_builder.Fill(InOrganFrame(state, BallAt(tool, place)), BallOf(geometry), contact,
                             place.press, nullptr, model, &state, patch);
    patch->shaft = PartOf(place);
  }
}

}  // namespace hpdm
