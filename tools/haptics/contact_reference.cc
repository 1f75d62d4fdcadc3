#include "tools/haptics/contact_reference.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/check.h"
#include "engine/contact/surface_kernel.h"
#include "engine/mesh/curved_surface.h"
#include "engine/step/tip_press.h"

namespace hpdm {
namespace {

constexpr double kReachBeyondTip = 0.025;  // m: the lattice shows no dent, so the point may be off
constexpr double kMostWay = 0.015;         // m: of a place over the rest surface between two calls
constexpr double kProbe = 5e-4;            // m: to the places whose differences give the normal
constexpr int kSearchRounds =
    1;  // solutions for the normal of a candidate: its neighbour was the last
constexpr int kFinalRounds = 6;
constexpr int kMostMoves = 25;
constexpr std::size_t kRefined = 3;

Vector3d Tangential(const Vector3d& v, const Vector3d& n) { return v - n.dot(v) * n; }

}  // namespace

ContactReference::ContactReference(const std::vector<OrganModel>& organs,
                                   const std::vector<ToolOptions>& tools, double spacing)
    : organs_(organs),
      tools_(tools),
      spacing_(spacing),
      scenes_(SizedSnapshot(organs, static_cast<int>(tools.size()), false)),
      unread_scenes_(scenes_.Front()),
      deformation_(organs, tools,
                   DeformationEdges{tool_states_, patches_, unread_scenes_, scenes_, &steps_}) {
  for (const OrganModel& organ : organs_) {
    rest_trees_.emplace_back(organ.rest().vertices, organ.rest().triangles);
    neighbourhoods_.emplace_back(organ.rest().triangles, organ.topology());
  }
}

const ToolGeometry& ContactReference::Geometry(int tool) const {
  const auto index = static_cast<std::size_t>(given_.tools[tool].instrument_index);
  return tools_[static_cast<std::size_t>(tool)].geometries[index];
}

void ContactReference::Step() {
  deformation_.Step(given_, given_.time_ns);
  HPDM_CHECK(steps_.Pop(&step_));
}

void ContactReference::Set(int tool, int organ, const Press& press) {
  given_.contact_points[tool][0] = {.known_organ = organ,
                                    .organ = organ,
                                    .triangle = press.at.triangle,
                                    .weights = press.at.barycentric,
                                    .normal_W = press.normal_W,
                                    .friction_W = press.friction_W};
}

// Returns the deformed place of a press: its point of the curved rest surface, moved by the mean
// displacement under the kernel that the lattice resolves.
Vector3d ContactReference::DeformedPlace(int organ, const SurfacePoint& at, double radius,
                                         const Vector3d& facing) {
  const OrganModel& model = organs_[static_cast<std::size_t>(organ)];
  const SurfaceMesh& rest = model.rest();
  const Points& deformed = deformation_.organ(organ).vertices;
  Neighbourhood around;
  KernelPatch kernel;
  neighbourhoods_[static_cast<std::size_t>(organ)].Collect(rest.vertices, at, {.reach = radius},
                                                           &around);
  GatherKernel(rest, around, at, facing, radius, &kernel);
  Vector3d place = at.Position(rest.vertices, rest.triangles) +
                   CurvedOffset(rest, model.topology(), model.rest_normals(), at);
  for (int i = 0; i < kernel.vertex_count; ++i) {
    const int v = kernel.vertices[i];
    place += kernel.weights[i] * (deformed.row(v) - rest.vertices.row(v)).transpose();
  }
  return place;
}

// Returns the normal of the surface that the deformed places around a press form, by differences.
Vector3d ContactReference::DeformedNormal(int organ, const SurfacePoint& at, double radius,
                                          const Vector3d& facing) {
  const OrganModel& model = organs_[static_cast<std::size_t>(organ)];
  const Vector3d p = at.Position(model.rest().vertices, model.rest().triangles);
  const Vector3d normal = facing.stableNormalized();
  const Vector3d along = normal.unitOrthogonal(), across = normal.cross(along);
  const auto place = [&](const Vector3d& way) {
    const SurfaceHit hit = rest_trees_[static_cast<std::size_t>(organ)].Closest(p + way, 1);
    return DeformedPlace(organ, hit.at, radius, facing);
  };
  const Vector3d one = place(kProbe * along) - place(-kProbe * along);
  const Vector3d other = place(kProbe * across) - place(-kProbe * across);
  return one.cross(other).stableNormalized();
}

// Returns the lean of the normal that keeps the energy of the dent under a tip that rubs. As the place
// moves by ds, the dent's compliance q H turns with the surface, and the force F does the work
// 1/2 q F . dH F besides what the dent stores: f_n lean . ds takes it back. By differences of H.
Vector3d ContactReference::Lean(int tool, int organ, const Press& press,
                                const Vector3d& facing) const {
  if (press.friction_W.isZero(0) || !(press.force > 0)) return Vector3d::Zero();
  const OrganModel& model = organs_[static_cast<std::size_t>(organ)];
  const double radius = TipPress::KernelRadius(Geometry(tool));
  const Vector3d p = press.at.Position(model.rest().vertices, model.rest().triangles);
  const Vector3d F_W = press.force * (press.friction_W - press.normal_W);
  const double yield = model.Indentation(press.at, radius).BallYield(press.force);
  const auto work = [&](const Vector3d& way) {
    const SurfaceHit hit = rest_trees_[static_cast<std::size_t>(organ)].Closest(p + way, 1);
    return yield / 2 * F_W.dot(model.Indentation(hit.at, radius).factor_W() * F_W);
  };
  const auto slope = [&](const Vector3d& direction) -> Vector3d {
    return (work(kProbe * direction) - work(-kProbe * direction)) / (2 * kProbe) * direction;
  };
  const Vector3d normal = facing.stableNormalized(), along = normal.unitOrthogonal();
  return (slope(along) + slope(normal.cross(along))) / press.force;
}

// Solves the organs for a press at press->at with its friction, `rounds` times, each with the normal
// of the surface that the last one left.
void ContactReference::Evaluate(int tool, int organ, int rounds, Press* press) {
  const OrganModel& model = organs_[static_cast<std::size_t>(organ)];
  const Vector3d facing = press->at.Position(model.rest_normals(), model.rest().triangles);
  const double radius = Geometry(tool).tip_radius;
  const double resolved =
      model.Indentation(press->at, TipPress::KernelRadius(Geometry(tool))).resolved_radius();
  for (int round = 0; round < rounds; ++round) {
    const Vector3d last = press->normal_W;
    press->normal_W =
        (DeformedNormal(organ, press->at, resolved, facing) + Lean(tool, organ, *press, facing))
            .stableNormalized();
    press->friction_W = Tangential(press->friction_W, press->normal_W);
    if (round > kSearchRounds && (press->normal_W - last).norm() < 1e-6) break;
    Set(tool, organ, *press);
    Step();
  }
  const SolvedContact& contact = step_.contacts[tool];
  const Vector3d& n = press->normal_W;
  const Vector3d under_W = given_.tools[tool].X_WT.translation() - radius * n;
  press->force = -n.dot(contact.force_on_tissue_W);
  press->offset_W = Tangential(under_W - contact.contact_W, n);
  Vector3d moved_W = Vector3d::Zero();  // by the other tip
  if (given_.tool_count == 2) {
    moved_W = contact.coupling_W * step_.contacts[1 - tool].force_on_tissue_W;
  }
  press->hold_W = contact.compliance_W.ldlt().solve(under_W - contact.p_original_W - moved_W);
}

// Returns the points of the deformed surface that the tip can press.
std::vector<SurfacePoint> ContactReference::Candidates(int tool, int organ) const {
  const OrganModel& model = organs_[static_cast<std::size_t>(organ)];
  const OrganState& state = deformation_.organ(organ);
  const Vector3d p_tip_W = given_.tools[tool].X_WT.translation() - state.offset_W;
  const double reach = Geometry(tool).tip_radius + kReachBeyondTip;
  const Triangles& triangles = model.rest().triangles;
  std::vector<SurfacePoint> found;
  for (int t = 0; t < static_cast<int>(triangles.rows()); ++t) {
    std::array<Vector3d, 3> p;
    double side = 0, nearest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) p[k] = state.vertices.row(triangles(t, k));
    for (int k = 0; k < 3; ++k) {
      side = std::max(side, (p[(k + 1) % 3] - p[k]).norm());
      nearest = std::min(nearest, (p[k] - p_tip_W).norm());
    }
    if (nearest > reach + side) continue;
    if ((p[1] - p[0]).cross(p[2] - p[0]).dot(tips_[tool].facing_W) <= 0) continue;
    const int parts = std::max(1, static_cast<int>(std::ceil(side / spacing_)));
    for (int i = 0; i < parts; ++i) {
      for (int j = 0; i + j < parts; ++j) {
        const Vector3d weights((i + 1. / 3) / parts, (j + 1. / 3) / parts,
                               1 - (i + j + 2. / 3) / parts);
        const SurfacePoint at{t, weights};
        const Vector3d p_rest_W = at.Position(model.rest().vertices, triangles);
        if ((p_rest_W - tips_[tool].p_last_W).norm() > kMostWay) continue;
        if ((at.Position(state.vertices, triangles) - p_tip_W).norm() < reach) found.push_back(at);
      }
    }
  }
  return found;
}

// Moves the place along the surface until the pressed point lies under the tip. True if it does.
bool ContactReference::Refine(int tool, int organ, Press* press) {
  const OrganModel& model = organs_[static_cast<std::size_t>(organ)];
  const SurfaceMesh& rest = model.rest();
  double share = 1;
  for (int move = 0; move < kMostMoves; ++move) {
    const double off = press->offset_W.norm();
    if (off < kUnder) return press->force > 0;
    Press next = *press;
    const Vector3d p_W =
        press->at.Position(rest.vertices, rest.triangles) + share * press->offset_W;
    next.at = rest_trees_[static_cast<std::size_t>(organ)].Closest(p_W, 1).at;
    Evaluate(tool, organ, kFinalRounds, &next);
    if (next.offset_W.norm() < off) {
      *press = next;
      share = std::min(1.0, 1.5 * share);
    } else {
      share /= 2;
    }
  }
  // Across an edge of the mesh the offset may have no zero; half a tenth of a millimetre will do.
  return press->offset_W.norm() < 10 * kUnder && press->force > 0;
}

bool ContactReference::FindFrictionless(int tool, int organ, Press* found) {
  std::vector<Press> presses;
  for (const SurfacePoint& at : Candidates(tool, organ)) {
    Press press{.at = at};
    Evaluate(tool, organ, kSearchRounds, &press);
    if (press.force > 0) presses.push_back(press);
  }
  const auto better = [](const Press& a, const Press& b) {
    return a.offset_W.squaredNorm() < b.offset_W.squaredNorm();
  };
  const std::size_t kept = std::min(kRefined, presses.size());
  std::partial_sort(presses.begin(), presses.begin() + static_cast<std::ptrdiff_t>(kept),
                    presses.end(), better);
  bool fulfils = false;
  for (std::size_t i = 0; i < kept; ++i) {
    Press press = presses[i];
    Evaluate(tool, organ, kFinalRounds, &press);
    if (!Refine(tool, organ, &press) || (fulfils && press.force <= found->force)) continue;
    *found = press;
    fulfils = true;
  }
  if (!fulfils && kept > 0) {
    ++unsolved_;
    *found = presses[0];
    fulfils = presses[0].offset_W.norm() < spacing_;
  }
  return fulfils;
}

// True if friction can hold the place; sets the friction that does.
bool ContactReference::Holds(int tool, int organ, Press* press) {
  for (int round = 0; round < 3; ++round) {
    Evaluate(tool, organ, kSearchRounds, press);
    const double pressing = -press->normal_W.dot(press->hold_W);
    if (!(pressing > 0)) return false;
    press->friction_W = Tangential(press->hold_W, press->normal_W) / pressing;
  }
  return press->friction_W.norm() <= Geometry(tool).friction;
}

// Finds where friction leaves the press of the last call: there, or where it slips to. False if it no
// longer presses.
bool ContactReference::Stick(int tool, int organ, Press* press) {
  const SurfaceMesh& rest = organs_[static_cast<std::size_t>(organ)].rest();
  const double friction = Geometry(tool).friction;
  press->at = tips_[tool].at;
  for (int move = 0; move < kMostMoves; ++move) {
    if (Holds(tool, organ, press)) return press->force > 0;
    // On the cone, against the force that would hold the place.
    const double pressing = -press->normal_W.dot(press->hold_W);
    if (!(pressing > 0)) return false;
    press->friction_W *= friction / press->friction_W.norm();
    Evaluate(tool, organ, kFinalRounds, press);
    if (press->offset_W.norm() < kUnder) return press->force > 0;
    const Vector3d p_W = press->at.Position(rest.vertices, rest.triangles) + press->offset_W;
    press->at = rest_trees_[static_cast<std::size_t>(organ)].Closest(p_W, 1).at;
  }
  ++unsolved_;
  return press->force > 0;
}

void ContactReference::FindPress(int tool) {
  Tip& tip = tips_[tool];
  given_.contact_points[tool] = {};
  const Vector3d p_tip_W = given_.tools[tool].X_WT.translation();
  const double radius = Geometry(tool).tip_radius;
  Press best;
  int on = -1;
  for (int o = 0; o < static_cast<int>(organs_.size()); ++o) {
    const OrganModel& model = organs_[static_cast<std::size_t>(o)];
    // A tip that does not touch the organ at rest is on the outer side of its nearest surface.
    const SurfaceHit near = rest_trees_[static_cast<std::size_t>(o)].Closest(
        p_tip_W - deformation_.organ(o).offset_W, radius + kReachBeyondTip);
    if (near.at.triangle < 0) continue;
    const SurfacePoint& last = tip.organ == o ? tip.at : near.at;
    tip.p_last_W = last.Position(model.rest().vertices, model.rest().triangles);
    if (tip.organ != o) {
      tip.facing_W = near.at.Position(model.rest_normals(), model.rest().triangles);
    }
    Press press;
    const bool rubs = Geometry(tool).friction > 0 && tip.organ == o;
    if (rubs ? !Stick(tool, o, &press) : !FindFrictionless(tool, o, &press)) continue;
    if (on >= 0 && press.force <= best.force) continue;
    on = o;
    best = press;
  }
  tip.organ = on;
  given_.contact_points[tool] = {};
  if (on < 0) return;
  tip.at = best.at;
  Evaluate(tool, on, kFinalRounds, &best);
}

const std::array<SolvedContact, kMaxInstruments>& ContactReference::Solve(const ToolState& tools) {
  given_ = tools;
  given_.contact_points = {};
  for (int t = 0; t < tools.tool_count; ++t) {
    tips_[t].holds = tips_[t].holds && tools.tools[t].jaw <= kJawLetsGo;
    if (!tips_[t].holds) given_.tools[t].jaw = tips_[t].jaw;  // they close in the last step only
  }
  const int rounds = tools.tool_count > 1 ? 2 : 1;  // each tip is found beside the other
  for (int round = 0; round < rounds; ++round) {
    for (int t = 0; t < tools.tool_count; ++t) {
      if (!tips_[t].holds) FindPress(t);
    }
  }
  for (int t = 0; t < tools.tool_count; ++t) {
    given_.tools[t].jaw = tips_[t].jaw = tools.tools[t].jaw;
  }
  constexpr int kToSettle = 3;  // Newton's method continues from the last step's solution
  for (int i = 0; i < kToSettle; ++i) Step();
  for (int t = 0; t < tools.tool_count; ++t) {
    contacts_[t] = step_.contacts[t];
    tips_[t].holds = contacts_[t].kind == ContactKind::kGrasp;
    if (tips_[t].holds) tips_[t].organ = -1;
  }
  return contacts_;
}

}  // namespace hpdm
