#pragma once

#include <memory>

#include "engine/base/types.h"
#include "engine/energy/strain_energy.h"
#include "engine/lattice/active_refinement.h"

namespace hpdm {

/// A smooth function E of displacements U (n x 3, m), as a line search needs it.
class Potential {
 public:
  virtual ~Potential() = default;
  /// Returns E, J.
  virtual double Energy(const Points& U) = 0;
  /// Returns E and computes dE/dU (n x 3, N).
  virtual double Gradient(const Points& U, Points* gradient) = 0;
};

/// The elastic energy E(U) of a lattice with its supports, for displacements of any size. Newton's
/// method minimises it (elastic_relaxation.h, static_newton.h). U: control displacements, n x 3, m.
/// Energy and forces are zero at U = 0. Methods use scratch space in the object, so each thread
/// needs its own; they allocate nothing after their first call.
class ElasticEnergy : public Potential {
 public:
  /// Returns a copy, for another thread.
  virtual std::unique_ptr<ElasticEnergy> Clone() const = 0;
  /// Takes the state of another one of the same class and lattice. Allocates nothing.
  virtual void Take(const ElasticEnergy& other) = 0;

  /// Returns n.
  virtual int control_points() const = 0;
  /// Sets the local functions in use. Their slots follow the control points in U and in the results
  /// of all other methods: n + slots rows. An energy without local functions ignores it.
  virtual void SetActiveFunctions(const ActiveRefinement& active) { static_cast<void>(active); }
  /// Computes d^2E/dU^2 (N/m, symmetric) over the rows of U. With `semi_definite`, the part of each
  /// point or element is first projected to a positive semi-definite one, so the sum is semi-definite
  /// too. Parts that already are stay exact.
  virtual void Hessian(const Points& U, bool semi_definite, FullStiffness* K) = 0;
  /// Returns the rotation of the tissue as a whole: that of the mean deformation gradient. The
  /// identity if the energy cannot tell.
  virtual Matrix3d MeanRotation(const Points& U) {
    static_cast<void>(U);
    return Matrix3d::Identity();
  }
  /// Returns the share (0..1) of the tissue that is inverted or compressed beyond the resistance of
  /// its law. Displacements and forces there are not reliable.
  virtual double CollapsedShare(const Points& U) = 0;
};

}  // namespace hpdm
