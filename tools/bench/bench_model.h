#pragma once

#include <functional>
#include <memory>
#include <string>

#include "engine/mesh/collision.h"
#include "engine/organ.h"

namespace hpdm {

/// What the measurements of `hpdm bench` are made on.

/// A solid organ of the project's shapes (`asset`: mesh_assets.h) as soft tissue whose rear 30 % is
/// held, as in a session.
struct BenchOrgan {
  OrganOptions options;  ///< Quadratic B-spline, energy strain, small, no local functions;
                         ///< to be changed.
  SurfaceMesh rest;
};
BenchOrgan MakeBenchOrgan(const std::string& asset);

/// The point of the surface farthest to the front (z), and to its left or right by `side` (m).
SurfacePoint FrontPoint(const SurfaceMesh& rest, double side);

/// How the surface continuum is stepped.
enum class ContinuumStep {
  kPrefactored,     ///< The constant matrix factorised once: as fast as it can be.
  kFactorisedAnew,  ///< Every step, as a matrix asks that follows the shape.
  kGaussSeidel,     ///< The static equations, iteratively.
};

/// A model under the press of one instrument's tip, as the session sets it up: one unilateral row
/// at the material point under the tip. A step is what the deformation loop does between collision
/// and patch: reposition, relax, relocate.
class BenchModel {
 public:
  /// A lattice.
  explicit BenchModel(const BenchOrgan& organ, double side = 0);
  /// The surface continuum of the organ's vertices.
  BenchModel(const BenchOrgan& organ, ContinuumStep step, double side = 0);

  /// One step with the tip 9 and 10 mm deep in turn.
  void Step();

  /// |K U - B^T f| / |B^T f| of the last step, with K the model's stiffness: the same measure for
  /// all. With local functions, of the lattice's own equations.
  double StaticResidual() const;
  /// Control points (without local functions), or vertices.
  int unknowns() const {
    return organ_ ? organ_->control_points() : static_cast<int>(rest_.rows());
  }
  double setup_ms() const { return setup_ms_; }

 private:
  void AddPress(const BenchOrgan& organ, double side);
  void RefineAtTip();

  std::unique_ptr<OrganModel> organ_;  // in its place: the relaxation refers to it
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
