#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/snapshots.h"
#include "render/camera/circle_mask.h"
#include "render/camera/frame_uniforms.h"
#include "render/camera/laparoscope.h"
#include "render/instrument/instrument_renderer.h"
#include "render/overlay/overlay_renderer.h"
#include "render/tissue/attachment_renderer.h"
#include "render/tissue/burn_marks.h"
#include "render/tissue/cavity_renderer.h"
#include "render/tissue/duct_renderer.h"
#include "render/tissue/occlusion.h"
#include "render/tissue/organ_renderer.h"
#include "render/tissue/smoke_renderer.h"

namespace hpdm {

/// Parts of the picture that a slow machine may omit.
struct SceneRendererOptions {
  bool occlusion = true;  ///< Shade in crevices.
  bool shadows = true;    ///< Shadow of the instruments.
  bool levels = true;     ///< Fewer triangles for organs that are small (mesh_levels.h).
};

/// Draws a whole scene into the bound framebuffer, for pictures and windows alike. Render thread
/// only, from construction to destruction.
class SceneRenderer {
 public:
  /// Compiles the programs and uploads meshes and textures. `background` (may be null) is the
  /// picture on the cavity's wall; it need not outlive the call. Throws MachineError if the driver
  /// refuses a shader.
  SceneRenderer(const std::vector<OrganVisual>& organs,
                const std::vector<InstrumentVisual>& instruments, const Image* background = nullptr,
                const SceneRendererOptions& options = {},
                const std::vector<AttachmentVisual>& attachments = {},
                const std::vector<DuctVisual>& ducts = {});

  /// Draws the snapshot as the scope sees it, into a viewport of the scope's picture size. Ignores
  /// organs and tools beyond those given at construction; fewer organs or another vertex count is
  /// a bug. `overlays`: Overlay (view_settings.h), or-ed. `guide` (may be null) is drawn, and its nearest
  /// points are set. Allocates nothing without overlays.
  void Draw(const SceneSnapshot& snapshot, const Laparoscope& scope, std::uint32_t overlays = 0,
            FreeingGuide* guide = nullptr);

  /// Clears the depth and draws that of one organ alone, as the last Draw() did.
  void DrawDepthOf(std::size_t organ) const;

  /// Draws the overlays' colour scales beside a resolved picture.
  void DrawScales(std::uint32_t overlays) { overlays_.DrawScales(overlays); }

 private:
  void ShowRaw();

  FrameBlock frame_;
  OrganRenderer organs_;
  InstrumentRenderer instruments_;
  std::optional<AttachmentRenderer> attachments_;
  BurnMarks burns_;
  std::vector<std::vector<float>> raw_;  // of each organ's vertices
  std::vector<bool> has_raw_;            // of each organ: some of it is, or was
  std::optional<DuctRenderer> ducts_;
  CavityRenderer cavity_;
  SmokeRenderer smoke_;
  std::optional<Occlusion> occlusion_;
  CircleMask mask_;
  OverlayRenderer overlays_;
};

}  // namespace hpdm
