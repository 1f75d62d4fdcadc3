#pragma once

#include <vector>

#include "engine/duct/duct_model.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/snapshots.h"
#include "render/camera/laparoscope.h"
#include "render/tissue/organ_renderer.h"

namespace hpdm {

/// A duct to draw. The model must outlive the visual.
struct DuctVisual {
  const DuctModel* model = nullptr;
  Colour colour = Colour(0.66f, 0.50f, 0.36f);
};

/// The surface of a duct with room for its cuts: two rings of vertices for each node, so that a cut
/// end gets a flat cap.
class SweptTube {
 public:
  static constexpr int kSides = 14;

  /// `snapshot`: at rest; `radius`: m.
  SweptTube(const DuctSnapshot& snapshot, double radius);

  const SurfaceMesh& rest() const { return rest_; }
  /// Fills the vertices of the rings (V x 3, m). Allocates nothing.
  void Sweep(const DuctSnapshot& snapshot, PointsF* vertices) const;

 private:
  double radius_;
  SurfaceMesh rest_;
};

/// Draws ducts as swept tubes with the look of tissue. Render thread only.
class DuctRenderer {
 public:
  /// Throws MachineError if the driver refuses a shader.
  DuctRenderer(const std::vector<DuctVisual>& ducts, bool shadows);

  /// Moves the tubes to the snapshot's shapes.
  void Move(const SceneSnapshot& snapshot, const Laparoscope& scope);
  void DrawDepth() const { tubes_renderer_.DrawDepth(); }
  /// Draws the tubes. `occlusion` (of the same frame) may be null.
  void Draw(const Occlusion* occlusion) const { tubes_renderer_.Draw(occlusion); }

 private:
  static std::vector<SweptTube> TubesOf(const std::vector<DuctVisual>& ducts);
  static std::vector<OrganVisual> VisualsOf(const std::vector<DuctVisual>& ducts,
                                            const std::vector<SweptTube>& tubes);

  std::vector<int> indices_;  // of each duct in the snapshot
  std::vector<SweptTube> tubes_;
  OrganRenderer tubes_renderer_;
  SceneSnapshot shapes_;  // one organ for each tube
};

}  // namespace hpdm
