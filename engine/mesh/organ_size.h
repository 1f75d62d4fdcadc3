#pragma once

#include <string>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Size of a surface in metres, and the unit in which it would be an organ.
struct OrganSize {
  double across = 0;        ///< m, longest side of the axis-aligned box.
  double volume = 0;        ///< m^3, at least 0; an estimate for an open surface.
  std::string likely_unit;  ///< "m", "mm" or metres per unit of the file, such as "0.01".

  static constexpr double kMinAcross = 1e-3;  ///< m.
  static constexpr double kMaxAcross = 2;     ///< m.
  static constexpr double kMaxVolume = 0.1;   ///< m^3, of a large adult's whole body.

  /// False if the file most likely has another unit.
  bool IsOrgan() const;
  /// Returns the size in words: "213 m across, 1.83e+06 m^3; an organ is 1 mm to 2 m across and at
  /// most 0.1 m^3".
  std::string Text() const;
};

/// `mesh`: in m. `unit_m`: metres per unit of its file.
OrganSize SizeOfOrgan(const SurfaceMesh& mesh, double unit_m);

}  // namespace hpdm
