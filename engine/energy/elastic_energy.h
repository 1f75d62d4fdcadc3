#pragma once

#include <memory>

#include "engine/base/types.h"
#include "engine/energy/strain_energy.h"

namespace hpdm {

/// A smooth function of displacements U (n x 3, m): what a line search needs of an energy.
class Potential {
 public:
  virtual ~Potential() = default;
  /// E, J.
  virtual double Energy(const Points& U) = 0;
  /// E, and dE/dU (n x 3, N).
  virtual double Gradient(const Points& U, Points* gradient) = 0;
};

/// The elastic energy E(U) of a lattice, supports included, for displacements of any size: what
/// Newton's method (elastic_relaxation.h, static_newton.h) minimises. U: control displacements,
/// n x 3, m. Zero, with no force, at U = 0. Methods keep scratch space, so one thread uses one
/// object, and allocate nothing after their first call.
class ElasticEnergy : public Potential {
 public:
  /// An object of another thread's own.
  virtual std::unique_ptr<ElasticEnergy> Clone() const = 0;

  /// n.
  virtual int control_points() const = 0;
  /// d^2E/dU^2 (3n x 3n, N/m, symmetric). With `semi_definite`, the part of each point or element
  /// is made positive semi-definite first, so that the sum is, and still exact where they are.
  virtual void Hessian(const Points& U, bool semi_definite, FullStiffness* K) = 0;
  /// Share (0..1) of the tissue that is turned inside out, or compressed so far that its law has
  /// stopped resisting: what lies there and the forces on it are not to be trusted.
  virtual double CollapsedShare(const Points& U) = 0;
};

}  // namespace hpdm
