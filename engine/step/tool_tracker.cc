#include "engine/step/tool_tracker.h"

#include <algorithm>
#include <span>

#include "engine/base/check.h"
#include "engine/mesh/curved_surface.h"
#include "engine/step/beside_search.h"

namespace hpdm {
namespace {

// Returns the distance (m) within which a tip can touch an organ before the next patch is in use.
// A patch is used up to 0.1 s after its step began. Tissue that is pushed aside by another press
// can also come nearer.
double BesideReach(const ToolPose& tool) {
  constexpr double kStandingReach = 0.02;  // m
  constexpr double kPatchEnds = 0.1;       // s
  return kStandingReach + kPatchEnds * tool.v_tip_W.norm();
}

// Returns how far from its surface a tip can touch another wall of an organ before the next patch is
// in use, m.
double OthersReach(const ToolPose& tool) {
  constexpr double kStandingReach = 0.008;  // m
  constexpr double kPatchEnds = 0.1;        // s
  constexpr double kMost = 0.03;            // m
  return std::min(kStandingReach + kPatchEnds * tool.v_tip_W.norm(), kMost);
}

}  // namespace

ToolTracker::Place::Place(int tool, int index, const ToolOptions& options)
    : press(tool, index, options.wall_stiffness, options.walls),
      patch_builder(options.prefetch, {.k1 = options.k1, .k2 = options.k2}) {}

void ToolTracker::Place::Take(int organ, const SurfacePoint& at, bool beside) {
  if (contact.organ != organ) {
    contact.touching = false;
    contact.force_W.setZero();
  }
  contact.organ = organ;
  contact.at = at;
  contact.beside = beside;
  taken = true;
}

ToolTracker::ToolTracker(int tool, const ToolOptions& options)
    : tool_(tool),
      reaction_(options.reaction),
      geometries_(options.geometries),
      grasp_(tool),
      shaft_(tool, options) {
  HPDM_CHECK(!geometries_.empty());
  for (int p = 0; p < kMaxPlaces; ++p) places_.emplace_back(tool, p, options);
}

// The haptic loop exchanges only a free tip; a grasp can end here only by the two loops' delay.
void ToolTracker::TakeInstrument(const ToolPose& tool) {
  const auto instrument_index = static_cast<std::size_t>(tool.instrument_index);
  if (instrument_index == instrument_index_) return;
  HPDM_CHECK(instrument_index < geometries_.size());
  instrument_index_ = instrument_index;
  grasp_.Release();
  shaft_.Release();
  for (Place& place : places_) place.contact.touching = false;
  jaw_last_ = tool.jaw;
}

void ToolTracker::LetGo() {
  grasp_.Release();
  shaft_.Release();
  for (Place& place : places_) place.contact = {};
  started_ = false;
  pierced_.fill(true);  // until FindPierced()
}

// Finds the organs that the tool's axis enters, of those that it was in when it let go.
void ToolTracker::FindPierced(const ToolPose& tool, const std::vector<OrganStep>& organs) {
  for (std::size_t o = 0; o < organs.size(); ++o) {
    if (!pierced_[o]) continue;
    const OrganState& state = organs[o].state();
    const SurfaceHit entry = state.tree.FirstEntry(tool.p_trocar_W - state.offset_W,
                                                   tool.X_WT.translation() - state.offset_W);
    pierced_[o] = entry.at.triangle >= 0;
  }
}

void ToolTracker::Track(const ToolPose& tool,
                        const std::array<TickContactPoint, kToolPlaces>& contact_points,
                        std::vector<OrganStep>* organs) {
  TakeInstrument(tool);
  if (tool.jaw > kJawLetsGo) grasp_.Release();
  grasp_.Slip(contact_points[holding_place_].slip_T, geometry());
  FindPierced(tool, *organs);
  for (std::size_t p = 0; p < places_.size(); ++p) {
    KeepPlace(tool, contact_points[p], *organs, &places_[p]);
  }
  SearchDoublesAgain();
  FindCandidates(tool, *organs);
  GivePlaces(*organs);
  for (Place& place : places_) UpdateContact(tool, organs, &place.contact);
  UpdateGrasp(tool, organs);
  double below = 0;
  for (const Place& place : places_) {
    if (place.contact.organ >= 0) below = std::max(below, -place.contact.gap);
  }
  const int held = grasp_.holds() ? places_[holding_place_].contact.organ : -1;
  shaft_.Track({tool, geometry(), below, held, &grasp_, pierced_},
               std::span(contact_points).last<kShaftPlaces>(), organs);
  p_tip_last_W_ = tool.X_WT.translation();
  jaw_last_ = tool.jaw;
  started_ = true;
}

std::optional<Vector3d> ToolTracker::RestPointOn(int organ, const OrganModel& model) const {
  for (const Place& place : places_) {
    if (place.contact.organ != organ) continue;
    return place.contact.at.Position(model.rest().vertices, model.rest().triangles);
  }
  return std::nullopt;
}

// Keeps the place if its contact continues: in the tick, in the jaws, or from the last step.
void ToolTracker::KeepPlace(const ToolPose& tool, const TickContactPoint& contact_point,
                            const std::vector<OrganStep>& organs, Place* place) {
  TipContact& contact = place->contact;
  const bool holds = Holds(*place);
  contact.normal_W.setZero();
  contact.friction_W.setZero();
  contact.from_tick = !holds && contact_point.organ >= 0 && contact_point.triangle >= 0 &&
                      !pierced_[ToSize(contact_point.organ)];
  // The tick has lost the contact or holds it on the coarse surface.
  const bool lost = contact_point.known_organ != contact.organ ||
                    (contact_point.organ >= 0 && contact_point.triangle < 0);
  const bool pressed = contact.touching && lost;
  place->taken = holds || contact.from_tick || pressed;
  if (contact.from_tick) {
    place->Take(contact_point.organ, {contact_point.triangle, contact_point.weights}, false);
    contact.normal_W = contact_point.normal_W;
    contact.friction_W = contact_point.friction_W;
  } else if (!holds && pressed) {
    const OrganStep& organ = organs[contact.organ];
    contact.at = ClosestIn(contact.around, organ.state().vertices, organ.model().rest().triangles,
                           tool.X_WT.translation() - organ.state().offset_W);
  }  // else the contact is the grasp, or the search finds it
}

// The tick may hold an organ in the place that it had in an older patch. Only presses of the tick
// share an organ; the step's own are searched again beside them.
void ToolTracker::SearchDoublesAgain() {
  for (const Place& place : places_) {
    if (!place.taken) continue;
    for (Place& other : places_) {
      if (&other == &place || other.contact.organ != place.contact.organ || Holds(other)) continue;
      if (other.contact.from_tick && !Holds(place)) continue;
      other.taken = other.contact.from_tick = false;
    }
  }
}

bool ToolTracker::IsTaken(int organ) const {
  return std::any_of(places_.begin(), places_.end(), [organ](const Place& place) {
    return place.taken && place.contact.organ == organ;
  });
}

// Lists the places that the tip may touch next, the first ones first.
void ToolTracker::FindCandidates(const ToolPose& tool, const std::vector<OrganStep>& organs) {
  candidates_.count = 0;
  for (std::size_t o = 0; o < organs.size(); ++o) {
    const int organ = static_cast<int>(o);
    if (pierced_[o]) continue;
    if (!IsTaken(organ)) {
      Candidate& candidate = candidates_.list[candidates_.count];
      candidate = {};
      candidate.organ = organ;
      if (!FindFirst(tool, organs[o].state(), &candidate)) continue;
      ++candidates_.count;
    }
    FindOthers(tool, organs[o], organ);
  }
  const auto first = candidates_.list.begin();
  std::sort(first, first + candidates_.count, [](const Candidate& a, const Candidate& c) {
    if (a.entered != c.entered) return a.entered;
    return a.order != c.order ? a.order < c.order : a.organ < c.organ;
  });
  const double beside = BesideReach(tool);
  while (candidates_.count > 1 && !candidates_.list[candidates_.count - 1].entered &&
         candidates_.list[candidates_.count - 1].order > beside) {
    --candidates_.count;
  }
}

// Finds where the tip entered an organ since the last step, or else the nearest point in reach.
bool ToolTracker::FindFirst(const ToolPose& tool, const OrganState& state,
                            Candidate* candidate) const {
  const Vector3d p_tip_W = tool.X_WT.translation();
  if (started_) {
    const SurfaceHit entry =
        state.tree.FirstEntry(p_tip_last_W_ - state.offset_last_W, p_tip_W - state.offset_W);
    candidate->entered = entry.at.triangle >= 0;
    candidate->at = entry.at;
    candidate->order = entry.along;
  }
  if (candidate->entered) return true;
  const SurfaceHit hit = state.tree.Closest(p_tip_W - state.offset_W, kReach);
  if (hit.at.triangle < 0) return false;
  candidate->at = hit.at;
  candidate->order = hit.distance;
  return true;
}

// Lists what the tip may touch of an organ beside the place that it has there, or will have.
void ToolTracker::FindOthers(const ToolPose& tool, const OrganStep& organ, int index) {
  const OrganModel& model = organ.model();
  const OrganState& state = organ.state();
  if (HoldsOrgan(index) || !HasLattice(reaction_, model, state)) return;
  // The metric energy has no local compliance to part presses that are close to each other: after a
  // grasp through the organ, two of them kept 260 mm of displacement.
  if (model.options().energy.type == EnergyType::kMetric) return;
  const Vector3d p_tip_W = tool.X_WT.translation() - state.offset_W;
  std::array<Vector3d, kMaxPlaces> normals;
  std::size_t count = 0;
  const auto add = [&](const SurfacePoint& at) {
    normals[count++] =
        InterpolatedNormal(state.vertices, model.rest().triangles, model.topology(), at);
  };
  for (const Place& place : places_) {
    if (place.taken && place.contact.organ == index) add(place.contact.at);
  }
  if (count == 0) add(candidates_.list[candidates_.count - 1].at);
  const double reach = geometry().tip_radius + OthersReach(tool);
  while (count < kMaxPlaces) {
    const SurfaceHit hit =
        FindBeside(model, state, p_tip_W, reach, std::span(normals).first(count));
    if (hit.at.triangle < 0) return;
    add(hit.at);
    candidates_.list[candidates_.count++] = {
        .organ = index, .at = hit.at, .beside = true, .order = hit.distance};
  }
}

// Gives the places that are not taken to the first candidates. One that had a place keeps it.
void ToolTracker::GivePlaces(const std::vector<OrganStep>& organs) {
  const auto is_free = [](const Place& place) { return !place.taken; };
  const auto free = std::count_if(places_.begin(), places_.end(), is_free);
  const int count = std::min(static_cast<int>(free), candidates_.count);
  std::array<bool, kMaxPlaces> given{};
  const auto take = [&](int i, Place* place) {
    const Candidate& candidate = candidates_.list[i];
    place->Take(candidate.organ, candidate.at, candidate.beside);
    given[i] = true;
  };
  for (int i = 0; i < count; ++i) {
    Place* const place = FreePlaceNear(candidates_.list[i], organs);
    if (place != nullptr) take(i, place);
  }
  for (Place& place : places_) {
    if (!place.taken) place.contact.organ = -1;
  }
  for (int i = 0; i < count; ++i) {
    if (!given[i]) take(i, &*std::find_if(places_.begin(), places_.end(), is_free));
  }
}

// Returns the place that the candidate's organ had nearest to it and that is not taken; nullptr if
// there is none.
ToolTracker::Place* ToolTracker::FreePlaceNear(const Candidate& candidate,
                                               const std::vector<OrganStep>& organs) {
  const SurfaceMesh& rest = organs[candidate.organ].model().rest();
  const Vector3d p = candidate.at.Position(rest.vertices, rest.triangles);
  Place* nearest = nullptr;
  double least = 0;
  for (Place& place : places_) {
    if (place.taken || place.contact.organ != candidate.organ) continue;
    const double distance = (place.contact.at.Position(rest.vertices, rest.triangles) - p).norm();
    if (nearest != nullptr && distance >= least) continue;
    nearest = &place;
    least = distance;
  }
  return nearest;
}

void ToolTracker::UpdateContact(const ToolPose& tool, std::vector<OrganStep>* organs,
                                TipContact* contact) {
  if (contact->organ < 0) return;
  const OrganModel& model = (*organs)[contact->organ].model();
  OrganState& state = (*organs)[contact->organ].state();
  contact->UpdateNeighbourhood(model, &state);
  const Vector3d offset = tool.X_WT.translation() - state.offset_W -
                          contact->at.Position(state.vertices, model.rest().triangles);
  const Vector3d normal =
      InterpolatedNormal(state.vertices, model.rest().triangles, model.topology(), contact->at);
  contact->gap = (normal.dot(offset) < 0 ? -offset.norm() : offset.norm()) - geometry().tip_radius;
}

// The place that holds, or else presses most, or else is nearest.
ToolTracker::Place& ToolTracker::MainPlace() {
  if (grasp_.holds()) return places_[holding_place_];
  Place* main = &places_.front();
  for (Place& place : places_) {
    const TipContact &one = place.contact, &best = main->contact;
    if (one.organ < 0) continue;
    const double force = one.force_W.norm(), most = best.force_W.norm();
    if (best.organ < 0 || force > most || (force == most && one.gap < best.gap)) main = &place;
  }
  return *main;
}

// The jaws take the tissue that the tip presses, or else the nearest.
void ToolTracker::UpdateGrasp(const ToolPose& tool, std::vector<OrganStep>* organs) {
  const bool closes = started_ && tool.jaw < kJawGrasps && jaw_last_ >= kJawGrasps;
  if (!geometry().can_grasp || !closes || grasp_.holds()) return;
  Place& place = MainPlace();
  if (place.contact.organ < 0) return;
  OrganStep& organ = (*organs)[place.contact.organ];
  if (organ.model().rigid()) return;
  ToolPose closed = InOrganFrame(organ.state(), tool);
  closed.X_WT = closed.X_WT * closed.X_TC;
  grasp_.Take(closed, geometry(), place.press, organ.model(), &organ.state(), &place.contact);
  holding_place_ = static_cast<std::size_t>(&place - places_.data());
  for (Place& other : places_) {
    if (&other != &place && other.contact.organ == place.contact.organ) other.contact.organ = -1;
  }
}

bool ToolTracker::AddContacts(const ToolPose& tool, std::vector<OrganStep>* organs) {
  bool complete = true;
  for (Place& place : places_) {
    if (place.contact.organ < 0) continue;
    complete = AddTipRows(tool, &(*organs)[place.contact.organ], &place) && complete;
  }
  CoupleDents(organs);
  return complete;
}

// The tip's presses on one organ sink into each other's dents. The lattice knows what it resolves of
// this; the rest is that of a half-space, with the kernels of both.
void ToolTracker::CoupleDents(std::vector<OrganStep>* organs) {
  dents_.setZero(3 * kMaxPlaces, 3 * kMaxPlaces);
  for (Place& place : places_) place.contact.coupled = {};
  for (int p = 0; p < kMaxPlaces; ++p) {
    for (int q = 0; q < p; ++q) {
      TipContact &one = places_[p].contact, &other = places_[q].contact;
      if (one.organ < 0 || one.organ != other.organ || HoldsOrgan(one.organ)) continue;
      OrganState& state = (*organs)[one.organ].state();
      const LocalIndentation &dent = places_[p].press.indentation(),
                             &other_dent = places_[q].press.indentation();
      if (!dent.indents() || !other_dent.indents() || !state.memory.IsElastic()) continue;
      const SurfaceMesh& rest = (*organs)[one.organ].model().rest();
      const double distance = (one.at.Position(rest.vertices, rest.triangles) -
                               other.at.Position(rest.vertices, rest.triangles))
                                  .norm();
      const double resolved = (dent.resolved_radius() + other_dent.resolved_radius()) / 2;
      const double sinking = KernelPairSinking(distance, dent.radius()).mean -
                             KernelPairSinking(distance, resolved).mean;
      const Matrix3d C = sinking / 2 * (dent.factor_W() + other_dent.factor_W());
      dents_.block<3, 3>(3 * p, 3 * q) = C;
      dents_.block<3, 3>(3 * q, 3 * p) = C.transpose();
      one.coupled = {&dents_, p};
      other.coupled = {&dents_, q};
    }
  }
  for (const Place& place : places_) {
    const TipContact& contact = place.contact;
    if (contact.organ < 0 || contact.row < 0 || contact.coupled.coupling == nullptr) continue;
    (*organs)[contact.organ].state().contacts[contact.row].coupled = contact.coupled;
  }
}

bool ToolTracker::AddShaftContacts(const ToolPose& tool, std::vector<OrganStep>* organs) {
  return shaft_.AddContacts(tool, geometry(), organs);
}

bool ToolTracker::AddTipRows(const ToolPose& tool_W, OrganStep* organ, Place* place) {
  const ToolPose tool = InOrganFrame(organ->state(), tool_W);
  if (Holds(*place)) return grasp_.AddRows(tool, organ->model(), &organ->state());
  return place->press.AddRow(tool, geometry(), organ->model(), &organ->state(), &place->contact);
}

void ToolTracker::AddTips(std::vector<OrganStep>* organs) {
  for (Place& place : places_) {
    TipContact& contact = place.contact;
    contact.touching = false;
    contact.force_W.setZero();
    contact.equilibrium_force_W.setZero();
    contact.C_loc_W.setZero();
    contact.tip = -1;
    if (contact.organ >= 0) AddTip(&(*organs)[contact.organ], &place);
  }
}

void ToolTracker::AddShaftTips(std::vector<OrganStep>* organs) { shaft_.AddTips(organs); }

void ToolTracker::AddTip(OrganStep* organ, Place* place) {
  const OrganModel& model = organ->model();
  OrganState& state = organ->state();
  TipContact& contact = place->contact;
  const ContactConstraints& contacts = state.contacts;
  const int owner = tool_ * kToolPlaces + static_cast<int>(place - places_.data());
  const bool has_lattice = HasLattice(reaction_, model, state);
  if (Holds(*place)) {
    for (int i = 0; i < contacts.size(); ++i) {
      const ContactConstraints::Row& row = contacts[i];
      if (row.tool == tool_ && !row.shaft) AddRowToTip(i, owner, has_lattice, &state, &contact);
    }
  } else if (contact.row >= 0 && contact.row < contacts.size()) {
    AddRowToTip(contact.row, owner, has_lattice, &state, &contact);
  }
  contact.touching = contact.force_W.squaredNorm() > 0;
  if (!has_lattice || contact.tip >= 0 || Holds(*place)) return;
  // Without a row: the tip is too far away in this step, but it may touch before the next one.
  contact.tip = state.tips.AddTip(owner);
  contact.C_wall_W = place->press.WallCompliance(model, contact);
  contact.indentation = place->press.indentation();
  contact.C_loc_W = contact.C_wall_W + contact.indentation.Compliance();
  Vector3d x_W = contact.at.Position(state.vertices, model.rest().triangles) +
                 state.relaxation->Rotation() *
                     CurvedOffset(model.rest(), model.topology(), model.rest_normals(), contact.at);
  for (int i = 0; i < contacts.size(); ++i) {
    x_W += contact.coupled.To(contacts[i].coupled) * contacts[i].force_W;
  }
  auto kernel = state.tips.ScratchRow();
  place->press.AddKernelToRow(model, state, kernel);
  RowMemory memory;
  if (!state.memory.IsElastic()) {
    memory.branches_W = state.memory.BranchesAt(state.tips.Compress(kernel));
    memory.excess_W = state.memory.Excess(memory.branches_W);
  }
  state.tips.AddRow(contact.C_loc_W, x_W, Vector3d::Zero(), contact.coupled, memory) = kernel;
}

void ToolTracker::FillPatches(const ToolPose& tool, std::vector<OrganStep>* organs,
                              ToolPatches* patches) {
  patches->instrument_index = tool.instrument_index;
  patches->main_place = static_cast<int>(&MainPlace() - places_.data());
  shaft_.FillPatches(tool, geometry(), organs, std::span(patches->places).last<kShaftPlaces>());
  for (std::size_t p = 0; p < places_.size(); ++p) {
    Place& place = places_[p];
    ToolPatch* const patch = &patches->places[p];
    PatchBuilder::Clear(tool, patch);
    patch->shaft_contact = shaft_.touches();
    patch->id = tool_ * kToolPlaces + static_cast<PlaceId>(p);
    if (place.contact.organ < 0) continue;
    OrganStep& organ = (*organs)[place.contact.organ];
    place.patch_builder.Fill(InOrganFrame(organ.state(), tool), geometry(), place.contact,
                             place.press, Holds(place) ? &grasp_ : nullptr, organ.model(),
                             &organ.state(), patch);
  }
}

}  // namespace hpdm
