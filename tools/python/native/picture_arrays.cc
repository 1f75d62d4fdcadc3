#include "tools/python/native/picture_arrays.h"

#include "render/camera/laparoscope.h"
#include "tools/python/native/array_views.h"

namespace hpdm {

namespace py = pybind11;

py::dict PictureArrays(const PictureWish& wish, const SessionPicture& picture) {
  const py::ssize_t h = wish.height, w = wish.width;
  py::dict arrays;
  arrays["rgb"] = py::array_t<std::uint8_t>(ArrayShape{h, w, 3}, picture.image.rgb.data());
  if (wish.depth) arrays["depth"] = py::array_t<float>(ArrayShape{h, w}, picture.depth.data());
  if (wish.organs)
    arrays["organs"] = py::array_t<std::int32_t>(ArrayShape{h, w}, picture.organs.data());
  return arrays;
}

py::dict CameraOf(const SessionModel& model, int width, int height) {
  const Laparoscope scope(model.scene().laparoscope, width, height);
  // x to the right, y down, z along the view: the axes of the intrinsics.
  Eigen::Matrix4d pose = scope.X_WC().matrix();
  pose.col(1) *= -1;
  pose.col(2) *= -1;
  const double f = scope.focal_length_px();
  py::array_t<double> poses(ArrayShape{4, 4}), intrinsics(ArrayShape{3, 3});
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) poses.mutable_at(i, j) = pose(i, j);
  }
  const double K[3][3] = {{f, 0, width / 2.0}, {0, f, height / 2.0}, {0, 0, 1}};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) intrinsics.mutable_at(i, j) = K[i][j];
  }
  py::dict camera;
  camera["pose"] = poses;
  camera["intrinsics"] = intrinsics;
  camera["circle_radius"] = scope.circle_radius_px();
  camera["distortion"] = scope.distortion();
  return camera;
}

}  // namespace hpdm
