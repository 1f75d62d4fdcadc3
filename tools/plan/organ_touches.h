#pragma once

#include <string>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "scenes/loader/scene.h"

namespace hpdm {

/// Places where instruments or loads may act on an organ, and their number in one step.
struct OrganTouches {
  /// Loads that act together, one list per case: the scene's own loads on the organ, or one press
  /// at each of a few places that instruments reach.
  std::vector<std::vector<LoadOptions>> cases;
  /// Patches that a step may have at once: the loads, or a press of each instrument that reaches
  /// it.
  std::vector<LoadOptions> patches;
  std::vector<std::size_t> instruments;  ///< Scene indices of the instruments that reach the organ.
  bool from_scene = false;               ///< The cases are the scene's loads.

  bool Touched() const { return !cases.empty(); }
};

/// Returns the touches of each organ of the scene; `rests`: their posed surfaces.
///
/// An instrument reaches a vertex if its shaft, turned about the trocar and pushed in within the
/// device's limits, brings the tip there. The vertex must face the trocar within 60 degrees, and no
/// support may hold it. Soft organs give way, so obstacles are ignored.
///
/// Presses are along the normal, with the tip's kernel and one newton. The first ones are at the
/// hands' targets. Others are at the vertices farthest from all chosen before; if a hand has a
/// target on the organ, within a quarter of the organ's size of it. A rigid organ has no model to
/// choose and gets no touches.
///
/// Throws InputError for a pressure, which no instrument can exert.
std::vector<OrganTouches> FindTouches(const Scene& scene, const std::vector<SurfaceMesh>& rests);

}  // namespace hpdm
