#pragma once

#include <string>
#include <vector>

#include "scenes/loader/scene.h"

namespace hpdm {

/// One trial of the felt force: a scene whose hands work for a while.
struct AccuracyCase {
  std::string name;
  Scene scene;
  double seconds = 0;
};

/// The hands that press, slide, tap and pull what they grasp, alone, two at once and with
/// friction, in small and in finite strain (without local functions, which that lacks). `scene`
/// gives the organ, a first instrument and a second one that can grasp; throws InputError when it
/// has fewer. `quick`: small strain and short.
std::vector<AccuracyCase> AccuracyCases(const Scene& scene, bool quick);

}  // namespace hpdm
