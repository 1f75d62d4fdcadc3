#pragma once

#include <string>
#include <vector>

#include "engine/base/types.h"

namespace hpdm {

/// A duct or a vessel: a tube that bends, twists and stretches between two organs (rod.h).
struct DuctOptions {
  std::string name;
  std::string label;  ///< What it is to a score, such as "do not touch"; or empty.
  /// Names of the organs that hold its ends; empty: the world holds that end.
  std::string a, b;
  Points path_W;      ///< Its axis from a to b at rest, at least two points, m.
  double radius = 0;  ///< Of the outer surface, m.
  double wall = 0;    ///< Thickness, m.
  double young = 0;   ///< Pa.
  Vector3d colour = Vector3d(0.66, 0.50, 0.36);  ///< As drawn: red, green and blue, 0..1.
};

/// True if one of the ducts ends in the organ.
inline bool HoldsDuct(const std::vector<DuctOptions>& ducts, const std::string& organ) {
  for (const DuctOptions& duct : ducts) {
    if (duct.a == organ || duct.b == organ) return true;
  }
  return false;
}

/// Poisson's ratio of every duct: tissue hardly changes its volume.
inline constexpr double kDuctPoisson = 0.45;
/// Segments of a duct.
inline constexpr int kDuctSegments = 40;

}  // namespace hpdm
