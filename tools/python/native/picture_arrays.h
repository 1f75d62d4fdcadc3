#pragma once

#include <pybind11/numpy.h>

#include "tools/python/native/session_pictures.h"

namespace hpdm {

/// Returns "rgb" (height x width x 3, uint8) and, where `wish` has them, "depth" (float, m) and
/// "organs" (int32), height x width.
pybind11::dict PictureArrays(const PictureWish& wish, const SessionPicture& picture);

/// Returns the "pose" of the scene's camera (4 x 4: camera in the world, m), its "intrinsics" (3 x
/// 3), "circle_radius" (pixels) and "distortion", for a picture of that size in pixels.
pybind11::dict CameraOf(const SessionModel& model, int width, int height);

}  // namespace hpdm
