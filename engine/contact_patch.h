#pragma once

#include <array>
#include <cstdint>

#include "engine/base/room.h"
#include "engine/base/types.h"
#include "engine/contact/half_space.h"
#include "engine/contact/patch_surface.h"
#include "engine/organ_motion.h"
#include "engine/scene_limits.h"

/// Surface, compliance and memory of the organs around a tool until the next deformation step
/// (ContactPatch in snapshots.h). All types have a fixed size.
namespace hpdm {

/// A mass-spring node (Eq. 29): a spring k1 to the released position p_original, and N springs
/// k2_i of rest length d_i to fixed neighbours p_i.
struct ReactionNode {
  static constexpr int kMaxNeighbours = 12;
  struct Neighbour {
    Vector3d edge = Vector3d::Zero();  ///< p_original - p_i, m.
    double rest_length = 0;            ///< d_i, m.
    double k2 = 0;                     ///< N/m.
  };
  double k1 = 0;  ///< N/m.
  int neighbour_count = 0;
  std::array<Neighbour, kMaxNeighbours> neighbours;
};

/// Source of a tool's reaction force: the lattice's own compliance, or springs set by hand.
enum class ReactionType : std::uint8_t { kLattice = 0, kPaper = 1 };

/// Stiffness of a rigid organ's virtual wall, N/m.
struct WallStiffness {
  double normal = 0;      ///< Along the contact's normal.
  double tangential = 0;  ///< Across it, against a tip that friction holds.

  /// Returns n n^T / normal + (I - n n^T) / tangential, m/N, for the unit normal n.
  Matrix3d Compliance(const Vector3d& normal_W) const {
    if (normal == tangential) return Matrix3d::Identity() / normal;
    const Matrix3d along = normal_W * normal_W.transpose();
    return along / normal + (Matrix3d::Identity() - along) / tangential;
  }
};

/// The memory of viscoelastic tissue at a point, one vector for each term.
using BranchStrains = std::array<Vector3d, PronySeries::kMaxTerms>;

/// Tissue without memory.
inline BranchStrains NoBranchStrains() {
  return {Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
}

/// A surface vertex near a tool, prefetched for the haptic loop.
struct PatchPoint {
  /// Released position: without the tools' forces, after the tissue's memory has faded, m.
  Vector3d p_original_W = Vector3d::Zero();
  Vector3d normal_W = Vector3d::Zero();  ///< Outward unit normal there.
  /// kLattice: compliance C of a contact at this vertex without ToolPatch::indentation, m/N,
  /// symmetric positive definite.
  Matrix3d compliance_W = Matrix3d::Zero();
  Matrix3d coupling_W = Matrix3d::Zero();  ///< kLattice: compliance to ToolPatch::other, m/N.
  /// kLattice: compliance to the other place of this tip, m/N; only with ToolPatch::beside.
  Matrix3d beside_W = Matrix3d::Zero();
  /// Viscoelastic organ: present position without ToolPatch::series_W times the contact's force, m.
  Vector3d tissue_W = Vector3d::Zero();
  /// Viscoelastic organ: w_k there (maxwell_law.h), m.
  BranchStrains branches_W = NoBranchStrains();
  WallStiffness wall;  ///< Rigid organ.
};

/// A jaw that closes past this grasps. Opened beyond the other it lets go. Both hold in tick and step.
inline constexpr double kJawGrasps = 0.3;
inline constexpr double kJawLetsGo = 0.5;

enum class ContactKind : std::uint8_t { kNone = 0, kPress = 1, kGrasp = 2 };

/// The contact of one tool's tip with one organ as the step solved it.
struct SolvedContact {
  int organ = -1;  ///< Index of the organ, -1 when none is near.
  ContactKind kind = ContactKind::kNone;
  ReactionType reaction = ReactionType::kPaper;
  bool rigid = false;                             ///< The organ is rigid.
  bool shaft_contact = false;                     ///< The shaft touches tissue too.
  Vector3d contact_W = Vector3d::Zero();          ///< Deformed contact point x_c, m.
  Vector3d force_on_tissue_W = Vector3d::Zero();  ///< f_c, from the lattice's energy, N.

  // kLattice: with x the contact point, the force on the tissue is C^-1 (x - p_original).
  Vector3d p_original_W = Vector3d::Zero();  ///< Released position of x_c: without tools, m.
  Vector3d normal_W = Vector3d::Zero();      ///< Press: the outward unit normal of the contact.
  Matrix3d compliance_W = Matrix3d::Zero();  ///< C, m/N; of a press at its force.
  Matrix3d coupling_W = Matrix3d::Zero();    ///< C_ac, m/N: displacement of x per force on
                                             ///< another tool's tip, of those on the organ the
                                             ///< one that presses most; zero without one.
  double kernel_radius = 0;                  ///< R, m; press.
};

/// A bounded set of connected triangles of an organ's surface, with the parameters of Eq. 29 at
/// their corners. Positions exclude the organ's breathing offset. A copy takes over what is in use.
struct SurfacePatch {
  static constexpr int kMaxPoints = PatchSurface::kMaxPoints;
  static constexpr int kMaxTriangles = PatchSurface::kMaxTriangles;
  using PatchPoints = Room<PatchPoint, kMaxPoints>;
  using Nodes = Room<ReactionNode, kMaxPoints>;

  SurfacePatch() = default;
  SurfacePatch(const SurfacePatch& other)
      : points(PatchPoints::kUntouched), nodes(Nodes::kUntouched) {
    *this = other;
  }
  SurfacePatch& operator=(const SurfacePatch& other) {
    point_count = other.point_count;
    triangle_count = other.triangle_count;
    points.Take(other.points, point_count);
    triangles = other.triangles;
    mesh_triangles = other.mesh_triangles;
    node_count = other.node_count;
    nodes.Take(other.nodes, node_count);
    if (triangle_count > 0) {
      packed = other.packed;
    } else {
      Pack();
    }
    return *this;
  }

  int point_count = 0;
  int triangle_count = 0;
  PatchPoints points;
  std::array<std::array<std::uint8_t, 3>, kMaxTriangles> triangles;
  std::array<int, kMaxTriangles> mesh_triangles{};  ///< Triangle numbers in the organ's mesh; -1:
                                                    ///< a triangle of the coarse surface.
  PatchSurface packed;  ///< The triangles, packed for the searches of every tick: call Pack().
  int node_count = 0;   ///< kPaper: as many as points; kLattice: 0.
  Nodes nodes;          ///< kPaper: of each point.

  /// Packs the surface again after a change of points or triangles.
  void Pack() noexcept { packed.Build(*this); }
};

/// The part of a shaft where a contact can begin, by its distance from the trocar, m. The contact
/// keeps this distance while the instrument slides through the trocar.
struct ShaftPart {
  double from = 0;
  double to = 0;
  double near = 0;  ///< Where the step expects or has the contact.
};

/// A place of a tool: the tool's number times kToolPlaces, and the index in ToolPatches::places.
using PlaceId = int;

/// The coupling of a contact to another place on the same organ.
struct PlaceCoupling {
  PlaceId to = -1;
  /// Displacement of the contact by a unit force at the other place, m/N.
  Matrix3d compliance_W = Matrix3d::Zero();
};

/// The surface of one organ around a tool, for the haptic loop between two deformation steps.
///
/// 1. The patch itself has the mesh's triangles around the predicted tip position. Its caps give it
///    a radius of about 5 mesh edges: 6 mm for edges of 1.25 mm.
/// 2. `far` has large triangles (coarse_surface.h) within about 50 mm. Contacts beyond the patch
///    begin and slide there until the next patch brings the mesh's own triangles.
/// 3. Until the next patch, a contact that slides to the border of `far` stays on the border, and
///    no new contact is made beyond it.
/// 4. `motion` gives the organ's breathing offset.
struct ToolPatch : SolvedContact, SurfacePatch {
  OrganMotion motion;
  SurfacePatch far;  ///< No triangles if the mesh's own are large.

  // kLattice, viscoelastic organ: its law, the time of the tool pose that the step used, and the
  // contact's memory there. `compliance_W` and `p_original_W` are those after relaxation.
  PronySeries prony;  ///< No terms: elastic.
  /// Part of `compliance_W` that does not relax: of elastic supports, in series with the tissue.
  Matrix3d series_W = Matrix3d::Zero();
  Nanoseconds time_ns = 0;
  BranchStrains branches_W = NoBranchStrains();  ///< Grasp: w_k of contact_W, m.
  /// Press: force on the tissue that would remain after relaxation in this position, N.
  Vector3d equilibrium_force_W = Vector3d::Zero();

  /// kLattice, press: local indentation under the tip. Its compliance, which depends on the force,
  /// is that of the contact less the mean of the points' over its triangle.
  LocalIndentation indentation;

  // kLattice, press: pressed normal minus released normal, both means over the kernel of the
  // radius that the lattice resolves.
  Vector3d tilt_W = Vector3d::Zero();  ///< Under the step's forces.
  /// 1/N: change per further equilibrium force at this tip.
  Matrix3d tilt_compliance_W = Matrix3d::Zero();

  // Grasp: place of the grasped tissue in the jaws; it moves rigidly with them.
  Vector3d p_grasp_T = Vector3d::Zero();  ///< m, tool frame.
  Matrix3d R_WT = Matrix3d::Identity();   ///< kLattice: the jaws' orientation in the step.
  /// kLattice: displacement of the held point that acts like a rotation of the jaws since the step,
  /// m/rad. The force on the tissue is C^-1 (p_grasp + turn rotation - p_original).
  Matrix3d turn_W = Matrix3d::Zero();
  Vector3d slip_T = Vector3d::Zero();  ///< TickContactPoint::slip_T that the step used, m.
  double hold = 0;          ///< N, largest pull along the jaws' faces; beyond it the tissue slips.
  ReactionNode grasp_node;  ///< kPaper; p_original_W is its released position.

  ShaftPart shaft;

  // kLattice: the places on the same organ. Contacts of two tips are coupled by the points' values,
  // which follow the contact; others by `couplings`, those between the step's places.
  PlaceId id = -1;                          ///< Of this patch.
  PlaceId other = -1;                       ///< The tip of PatchPoint::coupling_W.
  PlaceId beside = -1;                      ///< The tip of PatchPoint::beside_W.
  Matrix3d to_beside_W = Matrix3d::Zero();  ///< PatchPoint::beside_W at the step's place, m/N.
  int coupling_count = 0;
  std::array<PlaceCoupling, kMaxInstruments * kToolPlaces - 1> couplings;
};

/// The surfaces around one tool: one for each place that its tip touches or may touch next, and
/// those where its shaft does.
struct ToolPatches {
  int instrument_index = 0;  ///< The instrument they are made for (ToolPose::instrument_index).
  int main_place = 0;        ///< The tip's place that holds or presses most, or else the nearest.
  /// [0, kMaxPlaces): the tip's. An organ keeps its place as long as the tip stays near. Several
  /// places on one organ lie on surfaces that face different ways. The others are the shaft's.
  std::array<ToolPatch, kToolPlaces> places;

  const ToolPatch& main() const { return places[static_cast<std::size_t>(main_place)]; }
};

}  // namespace hpdm
