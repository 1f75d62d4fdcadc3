#pragma once

#include "haptics/device/instrument_options.h"
#include "render/instrument/instrument_renderer.h"
#include "scenes/generator/shapes/instrument_mesh.h"

namespace hpdm {

/// Loads the meshes that are drawn for an instrument, the first that apply:
///   1. the instrument's own meshes;
///   2. those of its type (scenes/generator/shapes/instrument_mesh.h) if its radii are those of a
///      5 mm instrument;
///   3. none: a capsule of its radii is drawn.
/// Set-up. Throws InputError for a mesh that cannot be read.
InstrumentMeshes LoadInstrumentMeshes(const InstrumentDescription& instrument);

/// Returns the same for the render loop. `meshes` must outlive the visual.
InstrumentVisual VisualOf(const InstrumentDescription& instrument, const InstrumentMeshes& meshes);

}  // namespace hpdm
