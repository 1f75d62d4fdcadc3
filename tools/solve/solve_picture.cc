#include "tools/solve/solve_picture.h"

#include "render/camera/picture_target.h"
#include "render/gl/egl_context.h"
#include "render/image/image_file.h"
#include "render/overlay/overlay_renderer.h"
#include "render/overlay/view_settings.h"
#include "render/scene_renderer.h"

namespace hpdm {
namespace {

constexpr int kWidth = 640, kHeight = 480, kSamples = 4;

}  // namespace

SolvedColours WriteSolvedPicture(const std::string& path, const StaticCase& load_case,
                                 const Points& displacements, const Points* reference) {
  const Points compared = reference != nullptr ? *reference : Points::Zero(displacements.rows(), 3);
  const double largest = (displacements - compared).rowwise().norm().maxCoeff();
  const SolvedColours colours{.error = reference != nullptr, .full_scale = RoundedUp(largest)};

  SceneSnapshot solved;
  solved.organs.resize(1);
  solved.organs[0].vertices = (load_case.rest.vertices + displacements).cast<float>();

  const EglContext context;
  PictureTarget target(kWidth, kHeight, kSamples);
  OrganVisual organ;
  organ.rest = &load_case.rest;
  organ.reference = &compared;
  organ.error_scale = colours.full_scale;
  SceneRenderer view({organ}, {});
  const Laparoscope scope(load_case.scene.laparoscope, kWidth, kHeight);
  target.Bind();
  view.Draw(solved, scope, kOverlayError);
  target.Resolve(scope);
  view.DrawScales(kOverlayError);
  Image image;
  target.Read(&image);
  WritePng(path, image);
  return colours;
}

}  // namespace hpdm
