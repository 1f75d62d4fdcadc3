#include "render/scene_renderer.h"

#include <epoxy/gl.h>

#include <algorithm>

namespace hpdm {
namespace {

std::vector<int> VertexCounts(const std::vector<OrganVisual>& organs) {
  std::vector<int> counts;
  for (const OrganVisual& organ : organs) {
    counts.push_back(static_cast<int>(organ.rest->vertices.rows()));
  }
  return counts;
}

std::vector<Triangles> TrianglesOf(const std::vector<OrganVisual>& organs) {
  std::vector<Triangles> triangles;
  for (const OrganVisual& organ : organs) triangles.push_back(organ.rest->triangles);
  return triangles;
}

ToolShade ShadeOf(const std::vector<InstrumentVisual>& instruments,
                  const SceneRendererOptions& options) {
  return {.tools = static_cast<int>(instruments.size()), .shadows = options.shadows};
}

}  // namespace

SceneRenderer::SceneRenderer(const std::vector<OrganVisual>& organs,
                             const std::vector<InstrumentVisual>& instruments,
                             const Image* background, const SceneRendererOptions& options,
                             const std::vector<AttachmentVisual>& attachments,
                             const std::vector<DuctVisual>& ducts)
    : organs_(organs, ShadeOf(instruments, options), options.levels),
      instruments_(instruments),
      burns_(TrianglesOf(organs), VertexCounts(organs)),
      has_raw_(organs.size(), false),
      cavity_(background),
      overlays_(organs) {
  if (options.occlusion) occlusion_.emplace();
  if (!attachments.empty()) attachments_.emplace(attachments, organs);
  for (std::size_t o = 0; o < organs.size(); ++o) raw_.emplace_back(burns_.Of(o).size());
  if (!ducts.empty()) ducts_.emplace(ducts, ShadeOf(instruments, options));
}

void SceneRenderer::Draw(const SceneSnapshot& snapshot, const Laparoscope& scope,
                         std::uint32_t overlays, FreeingGuide* guide) {
  FrameUniforms frame = ScopeUniforms(scope);
  instruments_.AddTo(snapshot, &frame);
  frame_.Upload(frame);

  organs_.Move(snapshot, scope);
  const bool torn = attachments_ && attachments_->Follow(snapshot);
  if (burns_.Follow(snapshot) || torn) ShowRaw();
  if (ducts_) ducts_->Move(snapshot, scope);
  glDepthFunc(GL_LEQUAL);
  if (occlusion_) {
    occlusion_->Update(scope, [this] {
      organs_.DrawDepth();
      if (ducts_) ducts_->DrawDepth();
    });
  }

  glEnable(GL_DEPTH_TEST);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);

  // Nearest first, so that hidden pixels and those outside the circle are not shaded.
  mask_.Draw();
  instruments_.Draw(snapshot);
  organs_.Draw(occlusion_ ? &*occlusion_ : nullptr);
  if (ducts_) ducts_->Draw(occlusion_ ? &*occlusion_ : nullptr);
  cavity_.Draw(scope);
  if (attachments_) attachments_->Draw(snapshot, scope);
  smoke_.Draw(snapshot, scope);
  if (attachments_ && guide != nullptr) attachments_->DrawLeft(snapshot, scope, guide);
  if (overlays != 0) overlays_.Draw(snapshot, scope, overlays, &organs_);
}

// Gives the organs' meshes the surfaces that layers have left raw and hooks charred.
void SceneRenderer::ShowRaw() {
  for (std::size_t o = 0; o < raw_.size(); ++o) {
    std::ranges::transform(burns_.Of(o), raw_[o].begin(), [](float black) { return 2 * black; });
  }
  if (attachments_) attachments_->AddRaw(&raw_);
  for (std::size_t o = 0; o < raw_.size(); ++o) {
    const bool is_raw = std::ranges::any_of(raw_[o], [](float value) { return value > 0; });
    if (is_raw || has_raw_[o]) organs_.mesh(o).SetRaw(raw_[o]);
    has_raw_[o] = has_raw_[o] || is_raw;
  }
}

void SceneRenderer::DrawDepthOf(std::size_t organ) const {
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
  organs_.DrawDepthOf(organ);
}

}  // namespace hpdm
