#pragma once

#include <string>
#include <vector>

#include "engine/base/oriented_box.h"
#include "engine/lattice/cut_surface.h"
#include "engine/organ_options.h"

namespace hpdm {

/// Returns an organ's cuts and, after them, its narrow notches (FindNotches) if the model takes them
/// (TakesNotches); nullptr if there are none. `rest_W`: posed. `bounds`: the posed organ's
/// axis-aligned box. `box_W`: the lattice's. `cell`: as FindNotches takes it, m. Set-up only.
///
/// Throws InputError for a cut that CutSurface refuses, or that runs along a fixed support, whose
/// penalty would hold both its sides. Such a notch is left out, with a warning.
CutSurfaces CutsOf(const OrganOptions& organ, const SurfaceMesh& rest_W, const Box& bounds,
                   const OrientedBox& box_W, double cell, std::vector<std::string>* warnings);

}  // namespace hpdm
