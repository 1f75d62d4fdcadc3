#pragma once

#include <array>
#include <functional>
#include <map>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "engine/organ_options.h"
#include "tools/stress/stress_case.h"

namespace hpdm {

inline const std::vector<StressModel> kAllModels = {
    StressModel::kStrainSmall,     StressModel::kStrainFinite, StressModel::kMetricSmall,
    StressModel::kMetricFinite,    StressModel::kContinuum,    StressModel::kMassSpring,
    StressModel::kLinearTetrahedra};

/// A box of tissue under static loads, for every model. Its surface consists of squares, its
/// tetrahedra of bricks of six.
struct StressBlockFixture {
  Vector3d min = Vector3d::Zero();            ///< m.
  Vector3d max = Vector3d::Zero();            ///< m.
  std::array<int, 3> squares = {10, 10, 10};  ///< Squares of the surface along each axis, two
                                              ///< triangles each.
  std::array<int, 3> bricks = {10, 10, 10};   ///< Bricks of the linear tetrahedra along each axis.
  OrganOptions organ;                         ///< Without the model, which is chosen separately.
  std::vector<LoadOptions> loads;
};

/// Returns a block of soft tissue, 100 x 100 x 60 mm (5 kPa, Poisson's ratio 0.45), whose lowest 12
/// mm are held. It is pressed on top by 0.05 N over 30 mm. Strains are at most 1 %, where small and
/// finite strain agree. The energy "metric" gets the same shear modulus.
StressBlockFixture PressedBlock(bool quick);

/// Returns a cantilever of `length` x `thickness` x `thickness` (m), free in x > 0 and held for 2
/// thicknesses before that. Poisson's ratio is 0, so the held end causes no stress of its own. A
/// force at the free end bends it by a hundredth of its length.
StressBlockFixture Cantilever(double length, double thickness);

/// Returns the surface of the box [min, max], closed and outward.
SurfaceMesh BoxSurface(const Vector3d& min, const Vector3d& max, const std::array<int, 3>& squares);

/// Solution of a model, and its shortcomings.
struct StressAnswer {
  Points displacements;   ///< V x 3, m; empty if there is none.
  double compliance = 0;  ///< At the first load, m/N.
  double share = 1;       ///< Share of the loads that were carried.
  double residual = 0;    ///< Relative residual of the equilibrium.
};

/// Returns the equilibrium of the block's surface. Throws InputError if the model cannot be built.
StressAnswer Rest(const StressBlockFixture& block, StressModel model);
/// Does the same for any surface with the block's organ and loads; not for tetrahedra.
StressAnswer Rest(const OrganOptions& organ, const SurfaceMesh& rest,
                  const std::vector<LoadOptions>& loads, StressModel model);
/// Solves with quadratic tetrahedra in `bricks`: the truth.
StressAnswer QuadraticRest(const StressBlockFixture& block, const std::array<int, 3>& bricks);

/// Judges an answer against a truth (relative L2 over the surface). Its harm: one of our models
/// gives values that are not finite.
StressTrial JudgeAnswer(const SurfaceMesh& rest, const StressAnswer& answer, const Points& truth,
                        StressModel model, double degraded_from, double failed_from);

/// Caches the result for each value, so that the trials of all models share it.
class Remembered {
 public:
  explicit Remembered(std::function<Points(double)> compute) : compute_(std::move(compute)) {}
  const Points& At(double value);

 private:
  std::function<Points(double)> compute_;
  std::map<double, Points> known_;
};

}  // namespace hpdm
