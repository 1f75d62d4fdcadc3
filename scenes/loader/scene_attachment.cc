#include <algorithm>
#include <cstdio>

#include "scenes/loader/scene_keys.h"
#include "scenes/loader/scene_parts.h"

namespace hpdm {
namespace {

constexpr double kMaxThickness = 0.1;  // m
constexpr double kReachOfThickness = 3;
// J/m^3: to heat tissue of 1,000 kg/m^3 from 37 to 100 degrees C and to vaporise its 70 % of water.
constexpr double kVaporisation = 1.9e9;

const OrganOptions& OrganOf(const TableReader& table, std::string_view key,
                            const std::vector<OrganOptions>& organs, std::string* name) {
  table.Require(key, "name the two organs that it joins as a and b");
  table.ReadString(key, name);
  RequireOrgan(table, key, *name, organs);
  const OrganOptions& organ = *std::ranges::find(organs, *name, &OrganOptions::name);
  if (!TakesAttachments(organ)) table.Fail(key, "cannot be attached", kAttachmentRemedy);
  return organ;
}

bool Touches(const OrganOptions& organ, const std::string& other) {
  return std::ranges::any_of(
      organ.contacts, [&](const OrganContactOptions& contact) { return contact.with == other; });
}

}  // namespace

AttachmentOptions ReadAttachment(const TableReader& table,
                                 const std::vector<OrganOptions>& organs) {
  AttachmentOptions attachment;
  table.ReadName("name", &attachment.name);
  const OrganOptions& a = OrganOf(table, "a", organs, &attachment.a);
  const OrganOptions& b = OrganOf(table, "b", organs, &attachment.b);
  if (&a == &b) table.Fail("b", "is the same organ as a", "name another organ");
  if (a.model == OrganModelType::kRigid && b.model == OrganModelType::kRigid) {
    table.Fail("b", "is rigid, as a is", "name at least one organ that deforms");
  }
  if (!a.free && !b.free && (Touches(a, b.name) || Touches(b, a.name))) {
    table.Fail("b", "is in a [[contact]] with a",
               "remove one of the two: the layer carries pressure between them itself");
  }
  const std::optional<Region> region = ReadRegion(table);
  if (!region) table.Fail("has no region", "give box, box_fraction or sphere");
  attachment.region = *region;
  table.Require("young", "give the layer's Young's modulus in Pa");
  table.ReadNumber("young", Interval::Positive(1e9, "Pa"), &attachment.young);
  table.Require("thickness", "give the layer's thickness in m");
  table.ReadNumber("thickness", Interval::Positive(kMaxThickness, "m"), &attachment.thickness);
  table.Require("strength", "give the largest traction in Pa");
  table.ReadNumber("strength", Interval::Positive(1e9, "Pa"), &attachment.strength);
  table.Require("toughness", "give the energy that frees a unit of area in J/m^2");
  table.ReadNumber("toughness", Interval::Positive(1e9, "J/m^2"), &attachment.toughness);
  const double least = LeastToughness(attachment);
  if (!(attachment.toughness > least)) {
    char problem[96];
    std::snprintf(problem, sizeof problem,
                  "is not above strength^2 thickness / (2 young) = %.3g J/m^2", least);
    table.Fail("toughness", problem, "give a larger one, or a lower strength");
  }
  attachment.reach = kReachOfThickness * attachment.thickness;
  table.ReadNumber("reach", Interval::Positive(kMaxThickness, "m"), &attachment.reach);
  attachment.burn_energy = kVaporisation * attachment.thickness;
  table.ReadNumber("burn_energy", Interval::Positive(1e12, "J/m^2"), &attachment.burn_energy);
  return attachment;
}

}  // namespace hpdm
