#pragma once

#include "haptics/device/instrument_options.h"
#include "render/instrument/instrument_renderer.h"
#include "scenes/generator/shapes/instrument_mesh.h"

namespace hpdm {

/// What is drawn of an instrument: its own meshes, or else its type's
/// (scenes/generator/shapes/instrument_mesh.h) where its radii are those of a 5 mm instrument, or
/// else nothing, for a capsule of its radii. Set-up; throws InputError for a mesh that cannot be
/// read.
InstrumentMeshes LoadInstrumentMeshes(const InstrumentDescription& instrument);

/// The same as the render loop takes it. `meshes` must outlive the visual.
InstrumentVisual VisualOf(const InstrumentDescription& instrument, const InstrumentMeshes& meshes);

}  // namespace hpdm
