#pragma once

#include <string>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "engine/organ_options.h"

namespace hpdm {

/// Returns a cut for each narrow notch of an organ: a gap between two facing walls that ends in
/// tissue. The cut lies in the gap, and its front just below the gap's end, so that the functions of a
/// crack's front (Lattice::AddFrontFunctions) let the gap open.
///
/// 1. A place of the surface faces a wall if the ray along its outward normal enters the surface
///    within 1.5 `cell`, against a normal that is opposite within 37 degrees. Neighbouring places with
///    like normals are one gap.
/// 2. Parallel lines along the gap's mean normal show how far it reaches: over neighbouring lines
///    whose parts between two walls overlap. It ends in tissue where the next line has tissue at the
///    gap's middle.
/// 3. The cut is a strip from that end along the middle of the gap, at most 1.5 `cell` long and
///    nowhere in a wall. Its front lies 0.07 of the gap's mean width below the end. A gap narrower
///    than 1/64 of the organ, which the tissue's voxels may miss, is cut along its whole length.
/// 4. A gap less deep than half of `cell` or 1.5 of its width is no notch, nor is one that tissue
///    closes all round. A mesh with holes has none.
///
/// `rest_W`: closed, m. `cell`: mean edge of the lattice's cells, m. Deterministic. Set-up only.
std::vector<CutOptions> FindNotches(const SurfaceMesh& rest_W, const std::string& organ,
                                    double cell);

}  // namespace hpdm
