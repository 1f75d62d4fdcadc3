#pragma once

#include <string>
#include <vector>

#include "scenes/loader/scene.h"

namespace hpdm {

/// One trial of the felt force: a scene and the time for which its hands work.
struct AccuracyCase {
  std::string name;
  Scene scene;
  double seconds = 0;
};

/// Returns the cases: hands that press, slide, tap and pull grasped tissue, alone, two at once and
/// with friction. Each runs in small and in finite strain, the latter without local functions.
/// `scene` gives the organ, an instrument and a second one that can grasp; throws InputError if it
/// has fewer. `quick`: small strain only, and shorter.
std::vector<AccuracyCase> AccuracyCases(const Scene& scene, bool quick);

}  // namespace hpdm
