#pragma once

#include "haptics/instrument_options.h"
#include "render/instrument_view.h"
#include "scenes/instrument_mesh.h"

namespace hpdm {

/// What is drawn of an instrument: its own meshes, or else its type's (scenes/instrument_mesh.h)
/// where its radii are those of a 5 mm instrument, or else nothing, for a capsule of its radii.
/// Set-up; throws InputError for a mesh that cannot be read.
InstrumentModel LoadLooks(const HeldInstrument& instrument);

/// The same as the render loop takes it. `looks` must outlive the view.
InstrumentView ViewOf(const HeldInstrument& instrument, const InstrumentModel& looks);

}  // namespace hpdm
