#include "render/scene_renderer.h"

#include <epoxy/gl.h>

namespace hpdm {

SceneRenderer::SceneRenderer(const std::vector<OrganVisual>& organs,
                             const std::vector<InstrumentVisual>& instruments,
                             const Image* background, const SceneRendererOptions& options,
                             const std::vector<AttachmentVisual>& attachments,
                             const std::vector<DuctVisual>& ducts)
    : organs_(organs, options.levels, options.shadows),
      instruments_(instruments),
      cavity_(background),
      overlays_(organs) {
  if (options.occlusion) occlusion_.emplace();
  if (!attachments.empty()) attachments_.emplace(attachments, organs);
  if (!ducts.empty()) ducts_.emplace(ducts, options.shadows);
}

void SceneRenderer::Draw(const SceneSnapshot& snapshot, const Laparoscope& scope,
                         std::uint32_t overlays) {
  FrameUniforms frame = ScopeUniforms(scope);
  instruments_.AddTo(snapshot, &frame);
  frame_.Upload(frame);

  organs_.Move(snapshot, scope);
  if (attachments_) attachments_->Move(snapshot, &organs_);
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
  if (overlays != 0) overlays_.Draw(snapshot, scope, overlays, &organs_);
}

void SceneRenderer::DrawDepthOf(std::size_t organ) const {
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
  organs_.DrawDepthOf(organ);
}

}  // namespace hpdm
