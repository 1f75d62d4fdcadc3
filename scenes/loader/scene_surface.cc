// Fillings and layers of an organ.

#include "scenes/loader/scene_keys.h"
#include "scenes/loader/scene_parts.h"

namespace hpdm {

std::vector<LumenOptions> ReadLumens(const TableReader& organ) {
  std::vector<LumenOptions> lumens;
  for (const TableReader& table : organ.Tables("lumen", kLumenKeys)) {
    LumenOptions& lumen = lumens.emplace_back();
    lumen.region = ReadRegion(table);
    table.ReadBoolean("filled", &lumen.filled);
    table.ReadNumber("bulk_modulus", Interval::Positive(1e12, "Pa"), &lumen.bulk_modulus);
    table.ReadNumber("pressure", {.min = 0, .max = 1e5, .unit = "Pa"}, &lumen.pressure);
    table.ReadNumber("leak_resistance", Interval::Positive(1e15, "Pa s/m^3"),
                     &lumen.leak_resistance);
    double perforated_at = 0;
    if (table.ReadNumber("perforated_at", {.min = 0, .max = 36000, .unit = "s"}, &perforated_at)) {
      lumen.perforated_at = perforated_at;
    }
  }
  return lumens;
}

std::vector<LayerOptions> ReadLayers(const TableReader& organ) {
  std::vector<LayerOptions> layers;
  for (const TableReader& table : organ.Tables("layer", kLayerKeys)) {
    LayerOptions& layer = layers.emplace_back();
    layer.region = ReadRegion(table);
    table.Require("stiffness", "give its Young's modulus times its thickness in N/m");
    table.ReadNumber("stiffness", Interval::Positive(1e9, "N/m"), &layer.stiffness);
    table.ReadNumber("poisson", {.min = 0, .max = 0.5, .below_max = true}, &layer.poisson);
    double strength = 0;
    if (table.ReadNumber("strength", Interval::Positive(1e9, "N/m"), &strength)) {
      layer.strength = strength;
    }
  }
  return layers;
}

}  // namespace hpdm
