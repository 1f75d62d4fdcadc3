#pragma once

#include <string>

#include "engine/attachment/attachment_options.h"

namespace hpdm {

/// Returns a layer like that of a gallbladder's bed between two organs. `reach`: m.
inline AttachmentOptions BedLayer(const std::string& a, const std::string& b, const Region& region,
                                  double reach) {
  AttachmentOptions layer;
  layer.a = a;
  layer.b = b;
  layer.region = region;
  layer.young = 20000;
  layer.thickness = 0.001;
  layer.strength = 10000;
  layer.toughness = 45;
  layer.reach = reach;
  return layer;
}

}  // namespace hpdm
