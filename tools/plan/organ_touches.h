#pragma once

#include <string>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "scenes/loader/scene.h"

namespace hpdm {

/// What may act on an organ: where a model of it has to be right, and how much at once.
struct OrganTouches {
  /// Loads that act together, one list a case: the scene's own on the organ, or a press at each of
  /// a few places that instruments reach.
  std::vector<std::vector<LoadOptions>> cases;
  /// At once, as a step may meet them: the loads, or a press of each instrument that reaches it.
  std::vector<LoadOptions> patches;
  std::vector<std::size_t> instruments;  ///< Of the scene, that reach the organ.
  bool from_scene = false;               ///< The cases are the scene's loads.

  bool Touched() const { return !cases.empty(); }
};

/// One for each organ of the scene; `rests`: their posed surfaces.
///
/// An instrument reaches an organ where its shaft, turned about the trocar and pushed in within the
/// device's limits, brings the tip to a vertex that faces the trocar within 60 degrees and that no
/// support holds; what else lies on the way is not asked, because soft organs give way. Presses are
/// along the normal, with the kernel of the tip, one newton: first where each hand goes, then at
/// the vertices farthest from all chosen before, within a quarter of the organ's size of where a
/// hand goes if one goes there. A rigid organ is not touched: it has no model to choose. Throws
/// InputError for a pressure, which no instrument's patch gives.
std::vector<OrganTouches> FindTouches(const Scene& scene, const std::vector<SurfaceMesh>& rests);

}  // namespace hpdm
