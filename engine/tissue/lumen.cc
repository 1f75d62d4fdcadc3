#include "engine/tissue/lumen.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/base/error.h"
#include "engine/mesh/mesh_edges.h"
#include "engine/tissue/support.h"

namespace hpdm {
namespace {

// Share of the largest volume that a flat part may seem to have.
constexpr double kNoVolume = 1e-9;

// A connected part of a surface.
struct WallPart {
  std::vector<int> triangles;
  int open_vertex = -1;  // of an edge that is not between two triangles; -1: closed
  double volume = 0;     // m^3, negative if it faces inwards
  bool is_lumen = false;
};

std::vector<WallPart> ConnectedParts(const SurfaceMesh& rest) {
  DisjointSets sets(static_cast<int>(rest.vertices.rows()));
  for (Eigen::Index t = 0; t < rest.triangles.rows(); ++t) {
    for (int c = 1; c < 3; ++c) sets.Merge(rest.triangles(t, 0), rest.triangles(t, c));
  }
  std::vector<WallPart> parts;
  std::vector<int> number(ToSize(rest.vertices.rows()), -1);
  const Vector3d origin = rest.vertices.colwise().mean();
  const auto part_of = [&](int vertex) -> int& { return number[ToSize(sets.Find(vertex))]; };
  for (int t = 0; t < rest.triangles.rows(); ++t) {
    int& part = part_of(rest.triangles(t, 0));
    if (part < 0) {
      part = static_cast<int>(parts.size());
      parts.emplace_back();
    }
    parts[ToSize(part)].triangles.push_back(t);
    const Vector3d a = rest.vertices.row(rest.triangles(t, 0)).transpose() - origin;
    parts[ToSize(part)].volume += a.dot(TwiceAreaNormal(rest.vertices, rest.triangles, t)) / 6;
  }
  ForEachEdge(SortedEdgeUses(rest.triangles), [&](auto first, auto last) {
    if (last - first != 2) parts[ToSize(part_of(first->low))].open_vertex = first->low;
  });
  double largest = 0;
  for (const WallPart& part : parts) largest = std::max(largest, std::abs(part.volume));
  for (WallPart& part : parts) {
    part.is_lumen = part.open_vertex < 0 && part.volume < -kNoVolume * largest;
  }
  return parts;
}

bool RegionHolds(const std::optional<Region>& region, const Box& bounds, const SurfaceMesh& rest,
                 const WallPart& part) {
  if (!region) return true;
  return std::ranges::all_of(part.triangles, [&](int t) {
    for (int c = 0; c < 3; ++c) {
      if (!InRegion(*region, bounds, rest.vertices.row(rest.triangles(t, c)))) return false;
    }
    return true;
  });
}

[[noreturn]] void RefuseLumen(const OrganOptions& organ, std::size_t number,
                              const std::string& text) {
  const std::string key = "lumen[" + std::to_string(number) + "]";
  throw InputError("organ \"" + organ.name + "\": " + key + text, {"organ", organ.name, key});
}

[[noreturn]] void RefuseOpenLumen(const OrganOptions& organ, std::size_t number,
                                  const SurfaceMesh& rest, const WallPart* open) {
  if (open == nullptr) {
    RefuseLumen(
        organ, number,
        " has no closed lumen in its region: fluid stays only in a cavity that tissue encloses; "
        "close its wall, or remove the table");
  }
  char text[160];
  const auto at = rest.vertices.row(open->open_vertex);
  std::snprintf(text, sizeof text,
                " is open at [%.3f, %.3f, %.3f]: an edge there is not between two triangles; close "
                "the wall, or remove the table",
                at.x(), at.y(), at.z());
  RefuseLumen(organ, number, text);
}

Lumen LumenOf(const SurfaceMesh& rest, const WallPart& part, const LumenOptions& options) {
  Lumen lumen{.volume = -part.volume,
              .bulk_modulus = options.bulk_modulus,
              .pressure = options.pressure,
              .leak_resistance = options.leak_resistance,
              .perforated_at = options.perforated_at,
              .vertices = {},
              .areas_W = {}};
  for (const int t : part.triangles) {
    for (int c = 0; c < 3; ++c) lumen.vertices.push_back(rest.triangles(t, c));
  }
  std::sort(lumen.vertices.begin(), lumen.vertices.end());
  lumen.vertices.erase(std::unique(lumen.vertices.begin(), lumen.vertices.end()),
                       lumen.vertices.end());
  lumen.areas_W = Points::Zero(static_cast<Eigen::Index>(lumen.vertices.size()), 3);
  for (const int t : part.triangles) {
    const Vector3d share = TwiceAreaNormal(rest.vertices, rest.triangles, t) / 6;
    for (int c = 0; c < 3; ++c) {
      const auto at = std::ranges::lower_bound(lumen.vertices, rest.triangles(t, c));
      lumen.areas_W.row(at - lumen.vertices.begin()) -= share.transpose();
    }
  }
  return lumen;
}

}  // namespace

std::vector<bool> TrianglesOfLumens(const SurfaceMesh& rest) {
  std::vector<bool> inner(ToSize(rest.triangles.rows()));
  for (const WallPart& part : ConnectedParts(rest)) {
    if (!part.is_lumen) continue;
    for (const int t : part.triangles) inner[ToSize(t)] = true;
  }
  return inner;
}

std::vector<Lumen> FilledLumens(const SurfaceMesh& rest, const OrganOptions& organ) {
  if (organ.lumens.empty()) return {};
  const Box bounds = AxisAlignedBounds(rest.vertices);
  const std::vector<WallPart> parts = ConnectedParts(rest);
  std::vector<const LumenOptions*> filling(parts.size(), nullptr);
  for (std::size_t i = 0; i < organ.lumens.size(); ++i) {
    bool found = false;
    const WallPart* open = nullptr;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      if (!RegionHolds(organ.lumens[i].region, bounds, rest, parts[p])) continue;
      if (parts[p].open_vertex >= 0) open = &parts[p];
      if (!parts[p].is_lumen) continue;
      found = true;
      filling[p] = &organ.lumens[i];
    }
    if (!found) RefuseOpenLumen(organ, i, rest, open);
  }
  std::vector<Lumen> lumens;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (filling[p] == nullptr || !filling[p]->filled) continue;
    lumens.push_back(LumenOf(rest, parts[p], *filling[p]));
  }
  return lumens;
}

double RelativeChange(const Lumen& lumen, const Points& displacements) {
  double change = 0;
  for (std::size_t i = 0; i < lumen.vertices.size(); ++i) {
    change +=
        lumen.areas_W.row(static_cast<Eigen::Index>(i)).dot(displacements.row(lumen.vertices[i]));
  }
  return change / lumen.volume;
}

}  // namespace hpdm
