#pragma once

#include <vector>

#include "engine/duct/duct_model.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/snapshots.h"
#include "render/camera/laparoscope.h"
#include "render/tissue/clip_renderer.h"
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
  /// Fills the vertices of the rings (V x 3, m) and the poses of the clips (ClipMesh; may be null).
  /// Allocates nothing with room for kMaxDuctNodes clips.
  void Sweep(const DuctSnapshot& snapshot, PointsF* vertices,
             std::vector<Isometry3d>* clips_W = nullptr) const;
  /// Returns the mesh of a clip on the tube.
  SurfaceMesh Clip() const;

 private:
  double radius_;
  SurfaceMesh rest_;
};

/// Draws ducts as swept tubes with the look of tissue, and their clips as metal. Render thread only.
class DuctRenderer {
 public:
  /// Throws MachineError if the driver refuses a shader.
  DuctRenderer(const std::vector<DuctVisual>& ducts, const ToolShade& shade);

  /// Moves the tubes to the snapshot's shapes.
  void Move(const SceneSnapshot& snapshot, const Laparoscope& scope);
  void DrawDepth() const { tubes_renderer_.DrawDepth(); }
  /// Draws tubes and clips. `occlusion` (of the same frame) may be null.
  void Draw(const Occlusion* occlusion) const;

 private:
  static std::vector<SweptTube> TubesOf(const std::vector<DuctVisual>& ducts);
  static std::vector<OrganVisual> VisualsOf(const std::vector<DuctVisual>& ducts,
                                            const std::vector<SweptTube>& tubes);
  static std::vector<SurfaceMesh> ClipsOf(const std::vector<SweptTube>& tubes);

  std::vector<int> indices_;  // of each duct in the snapshot
  std::vector<SweptTube> tubes_;
  OrganRenderer tubes_renderer_;
  ClipRenderer clips_renderer_;
  std::vector<std::vector<Isometry3d>> clips_W_;  // of each duct
  SceneSnapshot shapes_;                          // one organ for each tube
};

}  // namespace hpdm
