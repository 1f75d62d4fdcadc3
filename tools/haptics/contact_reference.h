#pragma once

#include <array>
#include <vector>

#include "engine/deformation_loop.h"

namespace hpdm {

/// Finds the contacts of tools with organs without the haptic tick: the organs are solved wholly for
/// every candidate place of a tip, and the place is the one that fulfils the contact's conditions.
///
/// 1. Candidates are points of the deformed surface, `spacing` apart, on all triangles that the tip
///    can reach and that face the side from which it came, up to 15 mm from its own last place.
/// 2. A candidate is a frictionless press. Its normal is that of the surface that the deformed places
///    around it form: their means over the kernel that the lattice resolves. No other normal keeps the
///    energy of a slide (engine/README.md, section 4). It is found by differences of positions, together
///    with the solution; a tick turns it by mean normals.
/// 3. Conditions: f_n >= 0, the gap is closed, and the pressed point lies under the tip along the
///    normal: (I - n n^T)(x_tip - x_c) = 0. The three candidates that are nearest to this are moved
///    along the surface until they fulfil it to kUnder. The solution of the largest force counts:
///    any other place would leave the tip in the tissue.
/// 4. Friction: the normal leans as the energy of the dent wants it (Lean). The place of the last
///    call stays if the force that holds it lies within the cone.
///    Otherwise it slips, with the friction on the cone against that force, until the pressed point
///    lies under the tip (a return mapping). A search of the frictionless place would not do: a deep
///    press of curved tissue has none, though friction holds it.
/// 5. What the jaws hold is taken where the tip presses when they close. It follows the steps.
///
/// Calls must follow the motion with gaps of some 20 ms at most. One thread; offline.
class ContactReference {
 public:
  static constexpr double kUnder = 1e-5;  ///< m.

  /// `organs` must outlive it. `spacing`: m.
  ContactReference(const std::vector<OrganModel>& organs, const std::vector<ToolOptions>& tools,
                   double spacing);

  /// Returns the contacts of the tools at their poses in `tools`, whose contact points are not used.
  const std::array<SolvedContact, kMaxInstruments>& Solve(const ToolState& tools);

  /// Calls so far in which a tip pressed but no place fulfilled the conditions.
  int unsolved() const { return unsolved_; }

 private:
  // A place that a tip may press, after the organs were solved for it.
  struct Press {
    SurfacePoint at;
    Vector3d normal_W = Vector3d::Zero();
    Vector3d friction_W = Vector3d::Zero();  // tangential force over the normal one
    double force = 0;                        // N, along the normal
    Vector3d offset_W = Vector3d::Zero();    // tangential: from the pressed point to the tip, m
    Vector3d hold_W = Vector3d::Zero();  // force on the tissue that holds the point under the tip
  };
  // State of a tool between calls.
  struct Tip {
    int organ = -1;                        // -1: presses nothing
    SurfacePoint at;                       // if it presses
    Vector3d facing_W = Vector3d::Zero();  // surface normal where the tip was last free
    Vector3d p_last_W = Vector3d::Zero();  // rest point under the tip, m: the search is around it
    bool holds = false;
    double jaw = 1;
  };

  const ToolGeometry& Geometry(int tool) const;
  void Step();
  void Set(int tool, int organ, const Press& press);
  Vector3d DeformedPlace(int organ, const SurfacePoint& at, double radius, const Vector3d& facing);
  Vector3d DeformedNormal(int organ, const SurfacePoint& at, double radius, const Vector3d& facing);
  Vector3d Lean(int tool, int organ, const Press& press, const Vector3d& facing) const;
  void Evaluate(int tool, int organ, int rounds, Press* press);
  std::vector<SurfacePoint> Candidates(int tool, int organ) const;
  bool Refine(int tool, int organ, Press* press);
  bool FindFrictionless(int tool, int organ, Press* found);
  bool Holds(int tool, int organ, Press* press);
  bool Stick(int tool, int organ, Press* press);
  void FindPress(int tool);

  const std::vector<OrganModel>& organs_;
  std::vector<ToolOptions> tools_;
  double spacing_;
  TripleBuffer<ToolState> tool_states_;
  TripleBuffer<ContactPatch> patches_;
  TripleBuffer<SceneSnapshot> scenes_;
  TripleBuffer<SceneSnapshot> unread_scenes_;
  SpscQueue<StepSample> steps_{4};
  DeformationLoop deformation_;
  std::vector<SurfaceTree> rest_trees_;
  std::vector<NeighbourhoodSearch> neighbourhoods_;
  ToolState given_;  // the poses of this call with the contact points to be solved for
  StepSample step_;
  std::array<Tip, kMaxInstruments> tips_;
  std::array<SolvedContact, kMaxInstruments> contacts_;
  int unsolved_ = 0;
};

}  // namespace hpdm
