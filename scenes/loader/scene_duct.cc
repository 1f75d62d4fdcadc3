#include <algorithm>

#include "engine/attachment/attachment_options.h"
#include "scenes/loader/scene_keys.h"
#include "scenes/loader/scene_parts.h"

namespace hpdm {
namespace {

constexpr double kMaxDuctRadius = 0.05;  // m

// True if attachments lead from the organ to one that is not free: they bear its weight.
bool IsBorne(const OrganOptions& organ, const std::vector<OrganOptions>& organs,
             const std::vector<AttachmentOptions>& attachments) {
  std::vector<const OrganOptions*> reached = {&organ};
  for (std::size_t r = 0; r < reached.size(); ++r) {
    if (!reached[r]->free) return true;
    for (const AttachmentOptions& attachment : attachments) {
      const bool is_a = attachment.a == reached[r]->name;
      if (!is_a && attachment.b != reached[r]->name) continue;
      const OrganOptions& other =
          *std::ranges::find(organs, is_a ? attachment.b : attachment.a, &OrganOptions::name);
      if (std::ranges::find(reached, &other) == reached.end()) reached.push_back(&other);
    }
  }
  return false;
}

// Reads the name of the organ that holds an end. Returns nullptr for the world.
const OrganOptions* HolderOf(const TableReader& table, std::string_view key,
                             const std::vector<OrganOptions>& organs,
                             const std::vector<AttachmentOptions>& attachments, std::string* name) {
  if (!table.ReadString(key, name)) return nullptr;
  RequireOrgan(table, key, *name, organs);
  const OrganOptions& organ = *std::ranges::find(organs, *name, &OrganOptions::name);
  if (!TakesAttachments(organ)) table.Fail(key, "cannot hold a duct", kAttachmentRemedy);
  if (organ.free && !IsBorne(organ, organs, attachments)) {
    table.Fail(key, "is free, and ducts do not bear its weight",
               "join it by an [[attachment]] to an organ that is not free");
  }
  return &organ;
}

}  // namespace

DuctOptions ReadDuct(const TableReader& table, const std::vector<OrganOptions>& organs,
                     const std::vector<AttachmentOptions>& attachments) {
  DuctOptions duct;
  table.Require("name", "give the duct a name");
  table.ReadName("name", &duct.name);
  table.ReadName("label", &duct.label);
  const OrganOptions* a = HolderOf(table, "a", organs, attachments, &duct.a);
  const OrganOptions* b = HolderOf(table, "b", organs, attachments, &duct.b);
  if (a == nullptr && b == nullptr) {
    table.Fail("has neither a nor b", "name the organ that holds an end, at least at one of them");
  }
  if (a == b && a->free) {
    table.Fail("b", "is the same free organ as a", "name another organ, or leave the key out");
  }
  table.Require("path", "give the points of its axis from a to b in m");
  std::vector<Vector3d> path;
  table.ReadPoints("path", kCoordinate, kMaxPathPoints, &path);
  duct.path_W.resize(static_cast<Eigen::Index>(path.size()), 3);
  for (std::size_t i = 0; i < path.size(); ++i) {
    duct.path_W.row(static_cast<Eigen::Index>(i)) = path[i].transpose();
  }
  table.Require("radius", "give the radius of its outer surface in m");
  table.ReadNumber("radius", Interval::Positive(kMaxDuctRadius, "m"), &duct.radius);
  table.Require("wall", "give the thickness of its wall in m");
  table.ReadNumber("wall", Interval::Positive(kMaxDuctRadius, "m"), &duct.wall);
  if (duct.wall >= duct.radius) {
    table.Fail("wall", "is not below the radius", "give a thinner wall: a duct has a lumen");
  }
  table.Require("young", "give the wall's Young's modulus in Pa");
  table.ReadNumber("young", Interval::Positive(1e9, "Pa"), &duct.young);
  table.ReadVector("colour", {.min = 0, .max = 1}, &duct.colour);
  return duct;
}

}  // namespace hpdm
