#pragma once

#include <array>
#include <optional>
#include <vector>

#include "engine/attachment/attachment_bed.h"
#include "engine/snapshots.h"
#include "render/camera/laparoscope.h"
#include "render/overlay/mark_renderer.h"
#include "render/overlay/nearest_fibre.h"
#include "render/tissue/organ_renderer.h"

namespace hpdm {

/// An attachment to draw. The bed must outlive the visual.
struct AttachmentVisual {
  const AttachmentBed* bed = nullptr;
  std::array<int, 2> organs{};  ///< a and b, by their index in the snapshot.
};

/// The layers that an exercise asks to free next, and the instruments that can free them.
struct FreeingGuide {
  std::vector<int> attachments = {};  ///< By their index in the scene.
  Colour colour = Colour::Ones();
  /// The tips of the instruments that can free it, m.
  std::array<std::optional<Vector3d>, kMaxInstruments> tips_W = {};
  /// Output: the fibre nearest to each tip among those that still hold; none if none does.
  std::array<std::optional<NearestFibre>, kMaxInstruments> nearest = {};
  /// Output: the largest share of the way to tearing that a fibre has gone, 0..1.
  double tautness = 0;
};

/// Draws the layers of attachments: fibres where a layer holds and its surfaces have moved apart, which
/// turn white before they tear, and a raw surface on both organs where it has torn, charred where it
/// was burnt. A leaf is drawn as a sheet of fibres wherever it holds. Render thread only.
class AttachmentRenderer {
 public:
  /// `organs`: those of the attachments, at rest. Throws MachineError if the driver refuses a
  /// shader.
  AttachmentRenderer(std::vector<AttachmentVisual> attachments,
                     const std::vector<OrganVisual>& organs);

  /// Takes the damage. True if it has changed since the last call.
  bool Follow(const SceneSnapshot& snapshot);
  /// Raises the rawness of the organs' vertices (MeshRenderer::SetRaw) to that of their layers.
  void AddRaw(std::vector<std::vector<float>>* raw) const;

  /// Draws the fibres into a picture that has just been drawn of `snapshot`.
  void Draw(const SceneSnapshot& snapshot, const Laparoscope& scope);
  /// Draws a dot wherever a layer of the guide still holds, and a line from each tip to the
  /// nearest point on its fibres, which it keeps in the guide. Hidden parts are fainter.
  void DrawLeft(const SceneSnapshot& snapshot, const Laparoscope& scope, FreeingGuide* guide);

 private:
  struct Layer {
    AttachmentVisual visual;
    std::array<Triangles, 2> triangles;           // of the samples' surface points, M x 3
    std::array<std::vector<int>, 2> nearest;      // sample of each vertex, -1: outside the bed
    std::vector<std::array<Vector3d, 2>> across;  // M: two tangents, half a sample long, m
    std::vector<float> damage, burnt;             // as last shown
  };
  Vector3d EndOf(const Layer& layer, std::size_t side, std::size_t sample,
                 const SceneSnapshot& snapshot) const;

  void AddStrip(const Layer& layer, std::size_t sample, const Vector3d& a_W, const Vector3d& b_W,
                double px_per_m);

  std::vector<Layer> layers_;
  MarkRenderer mark_renderer_;
  Marks fibres_;  // scratch
};

}  // namespace hpdm
