#pragma once

#include <limits>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "engine/step/tool_geometry.h"
#include "haptics/device/instrument_options.h"

namespace hpdm {

/// Radius of the tip's ball and of the shaft, m.
inline constexpr double kInstrumentRadius = kDefaultToolRadius;

/// A laparoscopic instrument of 5 mm with about 562 triangles in closed parts. Tool frame: origin
/// at the centre of the tip's ball, z along the shaft towards the trocar, y along the jaws' axis.
/// The shaft ends at z = 0.3 m.
struct InstrumentMeshes {
  SurfaceMesh rigid;              ///< m.
  std::vector<SurfaceMesh> jaws;  ///< Closed; the first opens towards +x, the second towards -x.
  double pivot = 0;               ///< m: the jaws turn about the line x = 0, z = pivot.
  double opening = 0;             ///< rad, for each jaw.
  double insulated_from = std::numeric_limits<double>::infinity();  ///< z, m.
};

/// Returns an instrument, with the same bits on every run and x86-64 machine:
///  - kProbe: a steel rod with a half ball at its tip; 562 triangles.
///  - kGrasper: atraumatic, two jaws with six rows of teeth each that interlock.
///  - kScissors: Metzenbaum, two slender blades that shear past each other on a plane curved
///    towards +y.
///  - kHook: a monopolar electrode, a wire of 1 mm bent to an L towards +x.
///  - kClipApplier: two smooth jaws with a channel for the legs of a clip.
InstrumentMeshes MakeInstrument(InstrumentType type);

/// Returns MakeInstrument(kProbe).rigid.
SurfaceMesh ProbeMesh();

}  // namespace hpdm
