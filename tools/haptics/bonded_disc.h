#pragma once

#include "engine/contact/footprint.h"
#include "engine/organ.h"

/// A rigid disc bonded to a block, whose stiffness is known in closed form.
namespace hpdm {

inline constexpr double kDiscRadius = 0.005;  ///< m.

/// A cube of side 40 kDiscRadius below z = 0, of 5 kPa, held on all sides but the top. The held
/// sides make it 3 to 4 % stiffer than a half-space.
struct DiscCase {
  double poisson = 0.3;
  int squares = 20;    ///< Of the surface along each edge; two triangles each.
  int cells = 4;       ///< Of the lattice along each edge.
  int functions = 27;  ///< Local functions.
};

OrganModel DiscBlock(const DiscCase& disc);

/// Adds 64 points of the disc about `centre` (m, on z = 0), each of which carries the same force:
/// the density is 1 / sqrt(1 - r^2).
void AddDisc(const OrganModel& model, const Vector3d& centre, Footprint* footprint);

struct DiscStiffness {
  double normal = 0;      ///< N/m.
  double tangential = 0;  ///< N/m.
  double rocking = 0;     ///< N m.
  double twist = 0;       ///< N m.
};

/// Returns that of the disc on the half-space, from its shear modulus G and Poisson's ratio:
///     normal 4 G a ln(3 - 4 nu) / (1 - 2 nu),   tangential 8 G a / (2 - nu),
///     rocking 8 G a^3 / (3 (1 - nu)),           twist 16 G a^3 / 3
DiscStiffness ExactDiscStiffness(double poisson);

/// Returns that of the disc on its block. The disc is tied as jaws are, by the rows of a Footprint.
/// It moves by 10 um or turns by 1 mrad, and the step's contact solver gives the rows' forces.
DiscStiffness MeasureDisc(const DiscCase& disc);

}  // namespace hpdm
