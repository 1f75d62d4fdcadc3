#pragma once

#include "engine/mesh/surface_mesh.h"
#include "haptics/device/hand_script.h"
#include "haptics/device/instrument_options.h"

namespace hpdm {

/// Where an instrument's hand goes on its organ (`rest`: posed, m): its target, or, where the scene
/// names none, the place where the line from the trocar to the middle of the organ's tissue enters
/// the surface. Throws InputError when it finds no surface.
HandSite SiteOnOrgan(const InstrumentOptions& instrument, const SurfaceMesh& rest,
                     const Vector3d& centre_of_volume_W);

}  // namespace hpdm
