#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/lattice/cut_surface.h"

namespace hpdm {

/// An axis-aligned part of the sampled box.
struct Block {
  Vector3d centre;
  Vector3d half;  ///< Half its size.

  /// Returns one of its eighths, which has the number 1 for the upper half along x, plus 2 and 4.
  Block Octant(int octant) const {
    const Vector3d side(octant & 1 ? 1 : -1, octant & 2 ? 1 : -1, octant & 4 ? 1 : -1);
    return {centre + side.cwiseProduct(half) / 2, half / 2};
  }
  /// Returns its lower and upper half along an axis.
  std::array<Block, 2> Halves(int axis) const {
    std::array<Block, 2> halves = {*this, *this};
    for (Block& part : halves) part.half[axis] /= 2;
    halves[0].centre[axis] -= halves[0].half[axis];
    halves[1].centre[axis] += halves[1].half[axis];
    return halves;
  }
};

/// The quadrature of the cells that cuts cross and of those near a cut's front (interior.h). Works in
/// the sampler's frame: the box's own, scaled so that its longest side is 1. Set-up only; one thread.
class CutCells {
 public:
  /// A quadrature point and, last, its weight.
  using Sample = Eigen::Vector4d;

  /// `box`: longest side `scale` (m), divided into `cells`.
  CutCells(const OrientedBox& box, const std::array<int, 3>& cells, CutSurfaces cuts);

  /// True if a cut may cross the block.
  bool Crosses(const Block& block) const { return !Crossing(block).empty(); }
  /// True if a cell gets its points from here: crossed, or within a cell of a front.
  bool Takes(const Block& cell) const;
  /// Returns the links that are cut between the voxels of a cell (PieceFinder::SetCutLinks), `side`
  /// along each axis.
  std::array<std::vector<std::uint8_t>, 3> CutLinks(int cell, int side) const;

  /// Adds points of a block that is all tissue.
  void AddBlock(const Block& block, std::vector<Sample>* samples) const;
  /// Adds points of a thin column along an axis, from `begin` to `end` there, beside `p`. `area`:
  /// its cross-section.
  void AddColumn(const Vector3d& p, Eigen::Index along, double begin, double end, double area,
                 std::vector<Sample>* samples) const;

  /// Reduces the samples of a cell to fewer with the same moments, in parts that shrink towards a
  /// front. Keeps those near the cuts themselves.
  void Reduce(const Block& cell, std::vector<Sample>* samples) const;

 private:
  void ReducePart(const Block& part, std::vector<Sample> in_part,
                  std::vector<Sample>* samples) const;
  std::vector<int> Crossing(const Block& block) const;
  double FrontDistance(const Vector3d& p) const;
  int AxisToHalve(const Block& block, bool crossed) const;
  void AddPart(const Vector3d& p, Eigen::Index along, double begin, double end, double area,
               int gauss, const std::vector<int>& triangles, std::vector<Sample>* samples) const;

  const OrientedBox& box_;
  std::array<int, 3> cells_;
  double scale_;
  Vector3d cell_size_;
  CutSurfaces cuts_;
  std::vector<CutSurface::Triangle> triangles_;
};

/// Changes the weights of a rule (points: N x 3 within [-1, 1]^3; weights: N, > 0) by a factor that
/// is a polynomial, close to 1, such that it has the integrals of `target` for all monomials
/// x^i y^j z^k with i, j, k <= 4: those in the energy of quadratic splines. If a weight would fall
/// below a tenth, as in cells whose target was compressed, it keeps those of CompressMoments() for
/// degree 3, or of a lower degree, at least the volume. Deterministic.
void FitMoments(const Points& target_points, const Eigen::VectorXd& target_weights,
                const Points& points, Eigen::VectorXd* weights);

}  // namespace hpdm
