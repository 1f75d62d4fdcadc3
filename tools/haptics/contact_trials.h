#pragma once

#include <vector>

#include "tools/shared/felt_bench.h"

/// Trials of the felt force: given poses, a step every 33 ticks, no device and no guard. The tables
/// of `hpdm haptics` (contact_tables.h) and the tests of the contact share them.
namespace hpdm {

/// An instrument with a tip of `radius`, m.
ToolOptions BallTip(double radius);

/// A block, 200 mm wide and high, of 5 kPa, its lowest tenth held. The top is z = 0. Its finite
/// width changes the force by up to 3 % at a contact of 1/24 of it.
struct WideBlock {
  double poisson = 0.45;
  int cells = 4;
  int local_functions = 0;
  int squares = 8;  ///< Of the surface along each edge; two triangles each.

  OrganOptions Options() const;
  SurfaceMesh Rest() const;
};

/// Returns the force of a rigid ball of `radius` (m) at a depth (m) in a half-space without
/// friction, N. Hertz: the ball is a paraboloid. Sneddon: with a the radius of the contact,
///     d = (a / 2) ln((R + a) / (R - a)),
///     F = E / (1 - nu^2) ((a^2 + R^2) / 2 ln((R + a) / (R - a)) - a R).
double HertzForce(double depth, double radius, const MaterialOptions& material);
double SneddonForce(double depth, double radius, const MaterialOptions& material);

/// The normal force at one depth, N.
struct BallPress {
  double depth = 0;         ///< m.
  double first_tick = 0;    ///< On the patch of a step that had no contact.
  double step = 0;          ///< Of the step's contact.
  double settled_tick = 0;  ///< On that step's patch, after 0.25 s.
};

/// Presses a tip of `radius` (m) to each of the depths (m), each from 0.1 mm above the block.
std::vector<BallPress> PressBall(const WideBlock& block, double radius,
                                 const std::vector<double>& depths);

/// A slab of 200 x 200 x 60 mm, its lowest 9 mm held, with `squares` squares along each edge. The
/// top is z = 0.
OrganOptions SlabOptions();
SurfaceMesh Slab(int squares);

/// The force before the guard in a slide of 20 mm across the slab's triangles, at 0.05 m/s and
/// 10 mm deep. Each new patch comes between two ticks of the same pose.
struct SlideTurn {
  double force = 0;   ///< Largest angle between such two forces, degrees.
  double normal = 0;  ///< The same between the contact's normals: a new patch's force fades in.
  double least_force = 0;  ///< N.
};
SlideTurn TurnOfSlide(double tip_radius, int squares);

/// A hand of 300 N/m and 6.5 N s/m with 150 g that wants to stay where it is, 20 mm deep in the
/// slab, at eight places, some of them near an edge of the triangulation; a device without friction
/// and encoders.
struct StillHandTrial {
  double rms_speed = 0;    ///< m/s, at the worst place.
  double least_force = 0;  ///< N, of all places.
};
StillHandTrial SpeedOfStillHand(double tip_radius, int squares);

/// An ellipsoid with these half-axes (m), held at its lowest quarter. Its mesh has edges of about
/// 80 mm / 2^splits.
inline const Vector3d kEllipsoidAxes(0.1, 0.08, 0.04);
OrganOptions EllipsoidOptions();

/// A default tip that comes down on the ellipsoid, 45 degrees to its surface. It stands still for
/// 0.2 s before, so that the patch is around its start.
struct Approach {
  bool felt = false;
  int ticks_late = 0;  ///< Ticks without force although the tip is 1.5 mm inside the rest surface.
  double deepest = 0;  ///< m below the rest surface before the first force.
};
Approach ComeDown(int splits, double speed);

/// A default tip that slides 40 mm over two ellipsoids that touch each other, from the top of the
/// one to the top of the other, 3 mm deep at a top and deeper in the notch; or over the first one
/// alone, which it leaves.
struct OrganSlide {
  int ticks_without_force = 0;
  double least_force = 0;   ///< N, normal to the tops.
  double largest_step = 0;  ///< N between two ticks.
  double stiffness = 0;     ///< N/m of the press before the slide.
};
OrganSlide SlideOverOrgans(int organs, double speed);

/// A grasp of the edge of a wedge (edge_wedge.h), pulled by 1 mm along the edge, off it and across
/// it.
struct EdgeStiffness {
  bool holds = false;
  double along = 0;   ///< N/m.
  double off = 0;     ///< N/m.
  double across = 0;  ///< N/m: bends the edge.
};
/// `edge`: of the mesh, m. The force is the tick's, after the step at the pulled pose.
EdgeStiffness PullEdge(double edge, int cells, int functions);

}  // namespace hpdm
