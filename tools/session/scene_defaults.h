#pragma once

#include <string>

#include "engine/mesh/surface_mesh.h"
#include "scenes/loader/scene.h"

namespace hpdm {

/// Holds the rear 30 % of a deformable organ that has no support, in a scene with instruments.
/// Without it an organ would yield to the lightest touch. The rear is the side of its box away from
/// the trocars' mean, along x or y, whichever is longer; z points up (scenes/README.md). `rest`:
/// posed, world, m. Returns a line for the user, or "" if nothing was added.
std::string HoldRear(const Scene& scene, const SurfaceMesh& rest, OrganOptions* organ);

/// Points a laparoscope at its default place at the organs: moves its tip and its target by the
/// centre of their boxes' union. `bounds`: that union, world, m. Leaves any other laparoscope
/// alone.
void LookAtOrgans(const Box& bounds, LaparoscopeOptions* scope);

}  // namespace hpdm
