#pragma once

#include <cstdint>
#include <vector>

#include "scenes/generator/shapes/implicit_shapes.h"

namespace hpdm {

/// Parameters of the growth of vessels.
struct VesselOptions {
  int targets = 0;           ///< Number of places on the surface that attract vessels.
  double step = 0;           ///< m: length of a segment.
  double sight = 0;          ///< m: range of a target's attraction; below the organ's thickness.
  double reached = 0;        ///< m: a target this near to a vessel is supplied.
  double finest_radius = 0;  ///< m: radius of a twig.
  std::uint64_t seed = 0;
};

/// A tree of vessels on an organ's surface, as distances to its lumen.
class VesselTree {
 public:
  /// Grows vessels from the trunks (polylines near the surface, m) towards targets scattered over
  /// the surface. Each target attracts the nearest vessel until one reaches it (space colonisation:
  /// Runions, Lane and Prusinkiewicz 2007). Radii follow Murray's law: r^3 is the sum of the
  /// branches' r^3. The same bits on every x86-64 machine.
  VesselTree(const ImplicitShape& shape, const std::vector<std::vector<Vector3d>>& trunks,
             const VesselOptions& options);

  /// Returns the share of a spot of the given radius (m) around p that is vessel, 0 to 1.
  double Coverage(const Vector3d& p, double spot) const;

 private:
  struct Node {
    Vector3d p;
    int parent;
    double radius;
  };

  int AddNode(const Vector3d& p, int parent);
  void Grow(const ImplicitShape& shape, std::vector<Vector3d> targets,
            const VesselOptions& options);
  void SetRadii(double finest_radius);
  void SortIntoCells(double step);
  std::size_t Number(const Eigen::Vector3i& cell) const;

  std::vector<Node> nodes_;  ///< Parents before their children.
  std::vector<std::vector<int>> cells_;
  Vector3d origin_;
  double cell_ = 0;
  Eigen::Vector3i count_;
};

}  // namespace hpdm
