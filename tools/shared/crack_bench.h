#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "engine/energy/strain_energy.h"
#include "engine/lattice/lattice.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/tissue/interior.h"

/// Bodies with a crack whose opening or energy is known in closed form (`hpdm chart --cracks`).
namespace hpdm {

/// How a body with a crack is modelled.
struct CrackModelOptions {
  double cell = 0.02;                            ///< m.
  Vector3d offset = Vector3d(0.23, 0.37, 0.41);  ///< Of the lattice from the body's corner, cells.
  Matrix3d axes = Matrix3d::Identity();          ///< Of the lattice.
  double poisson = 0.3;
  bool splits = true;  ///< Functions split by the cut.
  bool fronts = true;  ///< Functions of its front.
};

/// A point of a flat face and its share of the area.
struct FacePoint {
  Vector3d p;
  double area;
};

/// Returns points of the face of the box [low, high] across `axis` at its lower or upper end, at
/// most `spacing` (m) apart.
std::vector<FacePoint> FaceOf(const Vector3d& low, const Vector3d& high, int axis, bool upper,
                              double spacing);

/// A body with cuts on the engine's own lattice. Young's modulus is kYoung.
class CrackModel {
 public:
  static constexpr double kYoung = 5000;  ///< Pa.

  CrackModel(const SurfaceMesh& mesh, const std::vector<CutOptions>& cuts,
             const CrackModelOptions& options);

  /// Holds the component of the displacement along `direction` (unit) with stiff springs.
  void Hold(const std::vector<FacePoint>& face, const Vector3d& direction);
  /// Adds a traction, Pa.
  void Pull(const std::vector<FacePoint>& face, const Vector3d& traction);
  /// Keeps a body that is not held in its place, by springs a millionth as stiff as itself.
  void HoldWeakly();
  /// Finds the equilibrium.
  void Solve();

  /// Returns the displacement of the tissue at `p` on the side of `side`, m.
  Vector3d Displacement(const Vector3d& p, const Vector3d& side) const;
  /// Returns half the work of the loads, J.
  double Energy() const { return U_.dot(loads_) / 2; }

  const Lattice& lattice() const { return lattice_; }
  const TissueQuadrature& tissue() const { return tissue_; }
  const FullStiffness& stiffness() const { return K_; }

 private:
  double cell_;
  Lattice lattice_;
  TissueQuadrature tissue_;
  FullStiffness K_;
  Eigen::VectorXd loads_, U_;
};

/// A crack's opening over the closed form's, and the model that gave it.
struct CrackOpening {
  double opening = 0;  ///< Over the closed form.
  double energy = 0;   ///< J.
  int functions = 0;
  int front_functions = 0;
};

/// A strip 40 mm wide and 120 mm long with an edge crack of length `a` (m), pulled at its ends
/// between plane-strain rollers, one cell thick. `opening`: of the mouth, over Tada's
/// 4 sigma a V1(a / W) / E'. `turn`: of the strip about z against the lattice, radians.
CrackOpening EdgeCrack(const CrackModelOptions& options, double a, double turn = 0);
/// Returns the energy release rate of that crack between the lengths a and a + da, J/m^2, over that
/// of Tada's stress intensity in the middle.
double EdgeCrackRelease(const CrackModelOptions& options, double a, double da);

/// A crack of radius 20 mm in the middle of a cube of 100 mm, pulled at two faces. `opening`: at its
/// centre over 8 (1 - nu^2) sigma a / (pi E).
CrackOpening PennyCrack(const CrackModelOptions& options);

/// Double cantilever: two arms of height h = 20 mm, held apart by `a` over h, plane strain, one
/// cell wide, 20 h long. Returns the compliance over 8 (a + 0.67 h)^3 / (E' B h^3) + 2.4 a / (G B h), and the
/// energy release rate over K^2 / E' with K = 2 sqrt(3) P (a + 0.69 h) / (B h^1.5).
struct DoubleCantileverRatios {
  double compliance = 0, release = 0;
  int functions = 0;
};
DoubleCantileverRatios DoubleCantilever(const CrackModelOptions& options, double a_over_h);

}  // namespace hpdm
