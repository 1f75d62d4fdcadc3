#pragma once

#include <utility>
#include <vector>

#include "engine/organ.h"

namespace hpdm {

/// The organs of a scene with one organ.
inline std::vector<OrganModel> OneOrgan(const OrganOptions& options, SurfaceMesh rest) {
  std::vector<OrganModel> organs;
  organs.emplace_back(options, std::move(rest));
  return organs;
}

}  // namespace hpdm
