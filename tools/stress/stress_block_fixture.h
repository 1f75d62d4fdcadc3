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

/// A box of tissue under static loads, for every model: its surface in squares, its tetrahedra in
/// bricks of six.
struct StressBlockFixture {
  Vector3d min = Vector3d::Zero();            ///< m.
  Vector3d max = Vector3d::Zero();            ///< m.
  std::array<int, 3> squares = {10, 10, 10};  ///< Of the surface along each axis, two triangles.
  std::array<int, 3> bricks = {10, 10, 10};   ///< Of the linear tetrahedra.
  OrganOptions organ;                         ///< Without the model, which is chosen apart.
  std::vector<LoadOptions> loads;
};

/// 100 x 100 x 60 mm of soft tissue (5 kPa, Poisson's ratio 0.45) whose lowest 12 mm are held,
/// pressed on top by 0.05 N over 30 mm: strains of a per cent at most, where the models for small
/// and for finite strain agree. The energy "metric" gets the same shear modulus.
StressBlockFixture PressedBlock(bool quick);

/// A cantilever: `length` x `thickness` x `thickness` (m) free in x > 0 and 2 thicknesses held
/// beyond, with Poisson's ratio 0, so that the held end hinders nothing. A force at the free end
/// bends it by a hundredth of its length.
StressBlockFixture Cantilever(double length, double thickness);

/// Of a box [min, max]: closed, outwards.
SurfaceMesh BoxSurface(const Vector3d& min, const Vector3d& max, const std::array<int, 3>& squares);

/// Of the models, and what they did not do.
struct StressAnswer {
  Points displacements;   ///< V x 3, m; empty: there is none.
  double compliance = 0;  ///< Of the first load, m/N.
  double share = 1;       ///< Of the loads that were carried.
  double residual = 0;    ///< Of the equilibrium, relative.
};

/// Where the block's surface rests. Throws InputError where the model refuses to be built.
StressAnswer Rest(const StressBlockFixture& block, StressModel model);
/// The same of any surface with the block's organ and loads; not for tetrahedra.
StressAnswer Rest(const OrganOptions& organ, const SurfaceMesh& rest,
                  const std::vector<LoadOptions>& loads, StressModel model);
/// Quadratic tetrahedra in `bricks`: the truth.
StressAnswer QuadraticRest(const StressBlockFixture& block, const std::array<int, 3>& bricks);

/// Judge() of an answer against a truth (relative L2 over the surface), with its harm: a model of
/// ours that does not answer with finite numbers.
StressTrial JudgeAnswer(const SurfaceMesh& rest, const StressAnswer& answer, const Points& truth,
                        StressModel model, double degraded_from, double failed_from);

/// What was computed once for a value, for the trials of all models.
class Remembered {
 public:
  explicit Remembered(std::function<Points(double)> compute) : compute_(std::move(compute)) {}
  const Points& At(double value);

 private:
  std::function<Points(double)> compute_;
  std::map<double, Points> known_;
};

}  // namespace hpdm
