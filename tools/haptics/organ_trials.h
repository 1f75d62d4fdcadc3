#pragma once

#include "tools/shared/organ_bench.h"

/// Trials of the contact between organs, in the deformation step. The tables of `hpdm haptics`
/// (organ_tables.h), `hpdm stress` and the tests share them.
namespace hpdm {

/// Two equal bodies with spherical caps, pressed together by the motion of their far sides. The
/// caps' radius is 0.3 m, the bodies are 0.15 m wide and 0.09 m high.
struct SphereCase {
  double poisson = 0.3;
  double approach = 0.01;  ///< Over the effective radius, half of the caps'.
  int cells = 10;          ///< Of the lattices, along a side.
  int squares = 30;        ///< Of the surfaces, along a side.
  int functions = 0;       ///< Of each lattice, with finer ones where the spheres touch; 0: none.
};
/// The ratios to Hertz's solution.
struct SpherePress {
  double force = 0;  ///< At the approach of the centres of whole spheres.
  /// Radius of the contact, from the second moment of the forces on the rows' samples.
  double radius = 0;
  double third_law = 0;    ///< |sum of both organs' forces| over the force.
  double finite_size = 0;  ///< Share of the approach that the bodies' ends change (see below).
};
/// The far side of the body is held, where that of a whole sphere gives way. By how much more or
/// less the body yields than a half-space is measured under an even pressure on a square, whose
/// solution on the half-space is known (Love 1929); that times the force is taken off the approach.
SpherePress PressSpheres(const SphereCase& given);

/// Two bars of 50 mm width on each other, the lower 50 mm and the upper 30 mm high, pressed by
/// `press` (m).
struct BarsCase {
  double young_below = 5000, young_above = 5000;  ///< Pa.
  double poisson = 0;
  int squares_below = 14, squares_above = 14;
  double press = 0.002;  ///< m.
  double friction = 0;
};
struct BarsPress {
  double force = 0;  ///< Over that of their stiffnesses in series, each solved alone.
  double flatness =
      0;  ///< Largest distance of the two faces from their mean plane, over the press.
  double third_law = 0;
};
BarsPress PressBars(const BarsCase& given);

/// How deep organs are in each other after the steps of a press.
struct Penetration {
  double mean = 0;      ///< m, of all samples in another organ, in all steps.
  double largest = 0;   ///< m.
  double touching = 0;  ///< m^2: largest area of the samples of two organs in each other.
  int steps = 0;        ///< With a contact between organs.
};
/// Measures the drawn surfaces at samples at most 2 mm apart. A sample is in another organ by the
/// winding number of that organ's outer surface, and so deep as the nearest point of it is far. So
/// a surface that went through a wall into the cavity counts.
class PenetrationMeter {
 public:
  /// Measures a step: the organs whose contact the bench's organs name.
  void Measure(OrganBench* bench);
  /// The same of two drawn surfaces, m.
  void Measure(const SurfaceMesh& first, const SurfaceMesh& second);
  Penetration result() const;

 private:
  void MeasureSamples(const SurfaceMesh& samples, const SurfaceMesh& body, double* area);
  double sum_ = 0, weight_ = 0;
  Penetration result_;
};

}  // namespace hpdm
