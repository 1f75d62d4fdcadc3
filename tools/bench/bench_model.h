#pragma once

#include <functional>
#include <memory>
#include <string>

#include "engine/mesh/collision.h"
#include "engine/organ.h"

namespace hpdm {

/// The models that `hpdm bench` measures.

/// A solid organ of soft tissue in one of the project's shapes (`asset`: mesh_assets.h). Its rear
/// 30 % is held, as in a session.
struct BenchOrgan {
  OrganOptions options;  ///< Quadratic B-spline, strain energy, small strain, no local functions.
                         ///< Callers change them.
  SurfaceMesh rest;
};
BenchOrgan MakeBenchOrgan(const std::string& asset);

/// Returns the surface point farthest to the front (z), or farthest to the front at x = `side` (m).
SurfacePoint FrontPoint(const SurfaceMesh& rest, double side);

/// How the surface continuum is stepped.
enum class ContinuumStep {
  kPrefactored,     ///< The constant matrix is factorised once: the fastest way.
  kFactorisedAnew,  ///< Factorised in every step, as a matrix that depends on the shape needs.
  kGaussSeidel,     ///< The static equations, solved iteratively.
};

/// A model pressed by the tip of one instrument, as the session sets it up: one unilateral row at
/// the material point under the tip. A step repositions, relaxes and relocates, as the deformation
/// loop does between collision and patch.
class BenchModel {
 public:
  /// Uses a lattice.
  explicit BenchModel(const BenchOrgan& organ, double side = 0);
  /// Uses the surface continuum on the organ's vertices.
  BenchModel(const BenchOrgan& organ, ContinuumStep step, double side = 0);

  /// Makes one step. The tip is 9 and 10 mm deep in alternate steps.
  void Step();

  /// Returns |K U - B^T f| / |B^T f| of the last step, where K is the model's stiffness. The
  /// measure is the same for all models. With local functions it covers the lattice's own
  /// equations.
  double StaticResidual() const;
  /// Returns the number of control points (without local functions) or of vertices.
  int unknowns() const {
    return organ_ ? organ_->control_points() : static_cast<int>(rest_.rows());
  }
  double setup_ms() const { return setup_ms_; }

 private:
  void AddPress(const BenchOrgan& organ, double side);
  void RefineAtTip();

  std::unique_ptr<OrganModel> organ_;  // on the heap: the relaxation keeps a reference to it
  LatticeStiffness stiffness_;
  std::unique_ptr<Relaxation> relaxation_;
  std::function<void()> before_step_;
  double setup_ms_ = 0;
  ContactConstraints contacts_{0};
  Points rest_;      // V x 3, m
  Points U_;         // (n + slots) x 3, m
  Points vertices_;  // V x 3, m
  bool deep_ = false;
  bool repositions_ = true;
};

}  // namespace hpdm
