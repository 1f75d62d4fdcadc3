#include <algorithm>
#include <cstdio>

#include "scenes/loader/scene_keys.h"
#include "scenes/loader/scene_parts.h"

namespace hpdm {
namespace {

constexpr double kMaxThickness = 0.1;  // m
constexpr double kReachOfThickness = 3;
constexpr double kReachOfLeaf = 0.005;  // m
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

// Reads the lines of a leaf, if the table has them.
void ReadPaths(const TableReader& table, AttachmentOptions* attachment) {
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string_view key = side == 0 ? "path_a" : "path_b";
    table.ReadPoints(key, kCoordinate, kMaxPathPoints, &attachment->paths_W[side]);
  }
  if (attachment->paths_W[0].empty() != attachment->paths_W[1].empty()) {
    table.Fail("has one of path_a and path_b", "give both: a leaf spans the way between them");
  }
}

}  // namespace

AttachmentOptions ReadAttachment(const TableReader& table,
                                 const std::vector<OrganOptions>& organs) {
  AttachmentOptions attachment;
  table.ReadName("name", &attachment.name);
  table.ReadName("label", &attachment.label);
  const OrganOptions& a = OrganOf(table, "a", organs, &attachment.a);
  const OrganOptions& b = OrganOf(table, "b", organs, &attachment.b);
  if (&a == &b) table.Fail("b", "is the same organ as a", "name another organ");
  if (a.model == OrganModelType::kRigid && b.model == OrganModelType::kRigid) {
    table.Fail("b", "is rigid, as a is", "name at least one organ that deforms");
  }
  ReadPaths(table, &attachment);
  const bool touch = Touches(a, b.name) || Touches(b, a.name);
  if (!attachment.IsLeaf() && !a.free && !b.free && touch) {
    table.Fail("b", "is in a [[contact]] with a",
               "remove one of the two: the layer carries pressure between them itself");
  }
  const std::optional<Region> region = ReadRegion(table);
  if (attachment.IsLeaf() && region) {
    table.Fail("has a region and paths", "give paths for a leaf, or a region for a layer");
  }
  if (!attachment.IsLeaf() && !region) {
    table.Fail("has no region", "give box, box_fraction or sphere, or path_a and path_b of a leaf");
  }
  if (region) attachment.region = *region;
  table.Require("young", "give the layer's Young's modulus in Pa");
  table.ReadNumber("young", Interval::Positive(1e9, "Pa"), &attachment.young);
  table.Require("thickness", "give the layer's thickness in m");
  table.ReadNumber("thickness", Interval::Positive(kMaxThickness, "m"), &attachment.thickness);
  table.Require("strength", "give the largest traction in Pa");
  table.ReadNumber("strength", Interval::Positive(1e9, "Pa"), &attachment.strength);
  table.Require("toughness", "give the energy that frees a unit of area in J/m^2");
  table.ReadNumber("toughness", Interval::Positive(1e9, "J/m^2"), &attachment.toughness);
  const double least = LeastToughness(attachment, attachment.thickness);
  if (!attachment.IsLeaf() && !(attachment.toughness > least)) {  // a leaf: AttachmentBed
    char problem[96];
    std::snprintf(problem, sizeof problem,
                  "is not above strength^2 thickness / (2 young) = %.3g J/m^2", least);
    table.Fail("toughness", problem, "give a larger one, or a lower strength");
  }
  attachment.reach = attachment.IsLeaf() ? kReachOfLeaf : kReachOfThickness * attachment.thickness;
  table.ReadNumber("reach", Interval::Positive(kMaxThickness, "m"), &attachment.reach);
  attachment.burn_energy = kVaporisation * attachment.thickness;
  table.ReadNumber("burn_energy", Interval::Positive(1e12, "J/m^2"), &attachment.burn_energy);
  return attachment;
}

}  // namespace hpdm
