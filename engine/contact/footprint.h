#pragma once

#include <array>
#include <span>

#include "engine/contact/half_space.h"
#include "engine/contact/local_coupling.h"
#include "engine/contact/surface_kernel.h"
#include "engine/mesh/surface_topology.h"
#include "engine/organ.h"

namespace hpdm {

/// A quadrature point of a footprint: an equal share of the load that a rigid face bonded to an
/// elastic half-space exerts.
struct FootprintPoint {
  SurfacePoint at;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< Coordinates on the face, any unit.
  Eigen::Vector2d sides = Eigen::Vector2d::Zero();  ///< Size of the point's cell, m.
};

/// A patch of an organ's surface that is tied to a rigid face.
///
/// 1. Under a rigid face the traction is singular at the face's edge: 1 / sqrt(1 - r^2) on a disc.
///    The points sample that density, so each one carries the same force. Times 1, x and y it is
///    exact on a half-space for all motions of a bonded disc.
/// 2. Each contact row is a mean over the points with the weight (1 +- x)(1 +- y). A row is thus a
///    contact like any other: its target is the mean of the points' targets. Together the four rows
///    tie the translation and the rotation of the patch.
/// 3. A force with the weights of a row enters the lattice smoothed by the kernel of the radius
///    R_res that the lattice resolves, over the surface. The rest is a half-space's (half_space.h):
///        C_loc(k, l) = sum over points  w_ki w_lj (G(x_i - x_j) - G_res(x_i - x_j)).
///
/// Fixed size. Deformation thread; allocates nothing.
class Footprint {
 public:
  static constexpr int kMaxPoints = 64;

  void Clear() { count_ = 0; }
  void Add(const FootprintPoint& point) {
    if (count_ < kMaxPoints) points_[count_++] = point;
  }
  int size() const { return count_; }
  const FootprintPoint& operator[](int i) const { return points_[i]; }

  /// Fixes the rows' weights, the lattice's samples and the half-space at the points. Needs at
  /// least one point. `thickness` (m): of tissue whose other side is tied to an opposite face, or 0.
  ///
  /// Such a layer is tied on both sides. Its local compliance holds up to any R_res, so it takes
  /// the radius of the finest functions. Elsewhere R_res is at most a third of the tissue's
  /// thickness, because beyond it a wall bends (OrganModel::ResolvedRadius).
  void Resolve(const OrganModel& model, double thickness, NeighbourhoodSearch* search);

  /// Number of rows: 4, or fewer if the points lie on a line or coincide. One, the mean, if rows
  /// have no local compliance to each other: the lattice alone would tell them apart by huge forces.
  int rows() const { return rows_; }
  /// Returns the weighted mean of the points' positions on a row.
  Vector3d Mean(int row, const Points& vertices, const Triangles& triangles) const;
  /// Adds a row's weights in the lattice.
  void AddToRow(int row, const OrganModel& model, const ActiveRefinement& active,
                Eigen::Ref<Eigen::RowVectorXd> weights) const;

  const Vector3d& normal_W() const { return normal_W_; }  ///< Outward, at rest.
  double resolved_radius() const { return resolved_radius_; }

  /// Adds the blocks of C_loc for forces on the rows of `other` (or of this footprint). `at`,
  /// `other_at`: numbers of the first blocks.
  void AddLocalCompliance(const Footprint& other, int at, int other_at,
                          LocalCoupling* coupling) const;

 private:
  void SetWeights();
  void Sample(const OrganModel& model, NeighbourhoodSearch* search);
  using Places = Room<Vector3d, KernelSamples::kMaxSamples>;
  void Spread(int i, Places* p_samples_W);
  Matrix3d Unresolved(int i, const Footprint& other, int j) const;
  PairSinking Images(double along, int first, double radius) const;

  int count_ = 0;
  int rows_ = 0;
  std::array<FootprintPoint, kMaxPoints> points_;
  std::array<Vector3d, kMaxPoints> p_rest_W_;  // m
  std::array<std::array<double, kMaxPoints>, kFootprintRows> weights_;
  Vector3d normal_W_ = Vector3d::UnitZ();
  MaterialOptions material_;
  bool has_local_ = false;
  double resolved_radius_ = 0;  // m
  double thickness_ = 0;        // m, of a layer that is tied on both sides, or 0
  Neighbourhood around_;
  // Samples of the surface around the points, with their areas.
  struct Samples : KernelSamples {
    Samples() : weights(Weights::kUntouched) {}
    Samples(const Samples& other) : Samples() { *this = other; }
    Samples& operator=(const Samples& other) {
      KernelSamples::operator=(other);
      weights.Take(other.weights, sample_count);
      return *this;
    }
    using Weights = Room<std::array<double, kFootprintRows>, kMaxSamples>;
    Weights weights;
  };
  Samples samples_;
};

/// Fills in C_loc over the rows of `footprints`, first to last.
void FillLocalCoupling(std::span<const Footprint> footprints, LocalCoupling* coupling);

}  // namespace hpdm
