#pragma once

#include "engine/mesh/surface_mesh.h"
#include "haptics/device/hand_script.h"
#include "haptics/device/instrument_options.h"

namespace hpdm {

/// Returns the place on an organ that an instrument's hand goes to. It is the surface point closest
/// to the hand's target. Without a target it is the point where the line from the trocar to the
/// centre of the tissue enters the surface. `rest`: posed, world, m. Throws InputError if there is
/// no such point.
HandSite SiteOnOrgan(const InstrumentOptions& instrument, const SurfaceMesh& rest,
                     const Vector3d& centre_of_volume_W);

}  // namespace hpdm
