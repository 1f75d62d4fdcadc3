#include "lcmtypes/wire/mesh_codec.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"

namespace hpdm {
namespace {

enum BasisCode : std::int8_t { kNoLattice = 0, kBSplineCode = 1, kBernsteinCode = 2 };

constexpr int kVertexBytes = 3 * 4;
constexpr int kTriangleBytes = 3 * 4;
constexpr int kIndexBytes = 4;

/// Caps on what a sound description can hold, far above any real organ: they keep products of
/// received numbers within an int.
constexpr int kMaxFunctionsPerAxis = 1000;
constexpr int kMaxBernsteinDegree = 60;

mesh_t Header(int organ, const OrganDescription& description) {
  mesh_t part{};
  part.organ = organ;
  part.name = description.name.substr(0, kMaxOrganNameBytes);
  part.total_vertices = static_cast<std::int32_t>(description.vertices.rows());
  part.total_triangles = static_cast<std::int32_t>(description.triangles.rows());
  if (!description.lattice) return part;
  const LatticeDescription& lattice = *description.lattice;
  part.total_kept = static_cast<std::int32_t>(lattice.kept.size());
  part.local_refinement = lattice.local_refinement;
  part.basis = lattice.basis == BasisType::kBSpline ? kBSplineCode : kBernsteinCode;
  for (int d = 0; d < 3; ++d) {
    part.degree[d] = lattice.degree[d];
    part.cells[d] = lattice.cells[d];
    part.origin[d] = lattice.origin_W[d];
    part.lengths[d] = lattice.lengths[d];
    for (int k = 0; k < 3; ++k) part.axes[d][k] = lattice.axes(k, d);
  }
  return part;
}

/// Returns how many of `remaining` items fit into `room` bytes, and subtracts their bytes from
/// `room`.
int Take(int remaining, int item_bytes, int* room) {
  const int count = std::min(remaining, *room / item_bytes);
  *room -= count * item_bytes;
  return count;
}

/// True if all bytes agree: NaN equals the same NaN, and 0 differs from -0.
template <typename Array>
bool SameBits(const Array& a, const Array& b) {
  const auto a_bytes = std::as_bytes(std::span(a)), b_bytes = std::as_bytes(std::span(b));
  return std::equal(a_bytes.begin(), a_bytes.end(), b_bytes.begin());
}

bool SameWhole(const mesh_t& a, const mesh_t& b) {
  return a.organ == b.organ && a.part_count == b.part_count && a.name == b.name &&
         a.total_vertices == b.total_vertices && a.total_triangles == b.total_triangles &&
         a.total_kept == b.total_kept && a.basis == b.basis &&
         a.local_refinement == b.local_refinement && std::equal(a.degree, a.degree + 3, b.degree) &&
         std::equal(a.cells, a.cells + 3, b.cells) && SameBits(a.origin, b.origin) &&
         SameBits(a.axes, b.axes) && SameBits(a.lengths, b.lengths);
}

/// The lattice of a part's header without its kept indices; an error text or null.
const char* ReadLattice(const mesh_t& part, LatticeDescription* lattice) {
  if (part.basis != kBSplineCode && part.basis != kBernsteinCode) return "unknown basis";
  const bool bspline = part.basis == kBSplineCode;
  lattice->basis = bspline ? BasisType::kBSpline : BasisType::kBernstein;
  std::int64_t functions = 1;
  for (int d = 0; d < 3; ++d) {
    const int degree = part.degree[d];
    const int cells = part.cells[d];
    if (degree < 1 || degree > (bspline ? 3 : kMaxBernsteinDegree)) return "degree out of range";
    if (cells < 1 || cells > (bspline ? kMaxFunctionsPerAxis : 1)) return "cells out of range";
    functions *= cells + degree;
    lattice->degree[d] = degree;
    lattice->cells[d] = cells;
    lattice->origin_W[d] = part.origin[d];
    lattice->lengths[d] = part.lengths[d];
    for (int k = 0; k < 3; ++k) lattice->axes(k, d) = part.axes[d][k];
  }
  if (part.local_refinement < 0 || part.local_refinement > kMaxFunctionsPerAxis) {
    return "refinement out of range";
  }
  lattice->local_refinement = part.local_refinement;
  if (!lattice->origin_W.allFinite()) return "box not finite";
  if (!lattice->lengths.allFinite() || lattice->lengths.minCoeff() <= 0)
    return "box without volume";
  // Axes are unit vectors to a rounding; 1e-6 admits those of a sender that computes in float.
  if (!((lattice->axes.transpose() * lattice->axes - Matrix3d::Identity()).norm() < 1e-6)) {
    return "box axes not perpendicular unit vectors";
  }
  if (part.total_kept > functions) return "more control points kept than the lattice has";
  return nullptr;
}

/// The parts in order of their number; an error text or null.
const char* Order(std::span<const mesh_t> parts, std::vector<const mesh_t*>* ordered) {
  if (parts.empty()) return "no part";
  if (static_cast<std::size_t>(std::max(parts[0].part_count, 0)) != parts.size()) {
    return "parts missing or too many";
  }
  ordered->assign(parts.size(), nullptr);
  std::int64_t vertices = 0, triangles = 0, kept = 0;
  for (const mesh_t& part : parts) {
    if (!SameWhole(part, parts[0])) return "parts of different wholes";
    if (part.part < 0 || part.part >= part.part_count) return "part number out of range";
    if ((*ordered)[part.part] != nullptr) return "part repeated";
    if (part.vertices.size() % 3 != 0 || part.triangles.size() % 3 != 0) {
      return "part with a fraction of a vertex or triangle";
    }
    (*ordered)[part.part] = &part;
  }
  for (const mesh_t* part : *ordered) {
    if (part->first_vertex != vertices || part->first_triangle != triangles ||
        part->first_kept != kept) {
      return "parts do not follow each other";
    }
    vertices += static_cast<std::int64_t>(part->vertices.size() / 3);
    triangles += static_cast<std::int64_t>(part->triangles.size() / 3);
    kept += static_cast<std::int64_t>(part->kept.size());
  }
  if (vertices != parts[0].total_vertices || triangles != parts[0].total_triangles ||
      kept != parts[0].total_kept) {
    return "totals disagree with the parts";
  }
  return nullptr;
}

const char* Join(std::span<const mesh_t> parts, OrganDescription* description) {
  std::vector<const mesh_t*> ordered;
  if (const char* error = Order(parts, &ordered)) return error;
  const mesh_t& whole = parts[0];
  if (whole.organ < 0) return "organ number out of range";
  description->name = whole.name;
  description->lattice.reset();
  if (whole.basis == kNoLattice) {
    if (whole.total_kept != 0) return "control points without a lattice";
  } else {
    description->lattice.emplace();
    if (const char* error = ReadLattice(whole, &*description->lattice)) return error;
  }

  description->vertices.resize(whole.total_vertices, 3);
  description->triangles.resize(whole.total_triangles, 3);
  double* vertex = description->vertices.data();
  int* index = description->triangles.data();
  for (const mesh_t* part : ordered) {
    vertex = std::copy(part->vertices.begin(), part->vertices.end(), vertex);
    index = std::copy(part->triangles.begin(), part->triangles.end(), index);
    if (description->lattice) {
      std::vector<int>& kept = description->lattice->kept;
      kept.insert(kept.end(), part->kept.begin(), part->kept.end());
    }
  }
  if (!description->vertices.allFinite()) return "vertex not finite";
  if (description->triangles.size() > 0 &&
      (description->triangles.minCoeff() < 0 ||
       description->triangles.maxCoeff() >= whole.total_vertices)) {
    return "triangle index out of range";
  }
  if (description->lattice && !description->lattice->kept.empty()) {
    const LatticeDescription& lattice = *description->lattice;
    int functions = 1;
    for (int d = 0; d < 3; ++d) functions *= lattice.cells[d] + lattice.degree[d];
    const auto [least, most] = std::minmax_element(lattice.kept.begin(), lattice.kept.end());
    if (*least < 0 || *most >= functions) return "control point index out of range";
  }
  return nullptr;
}

}  // namespace

std::vector<mesh_t> SplitMesh(int organ, const OrganDescription& description, int max_bytes) {
  const mesh_t header = Header(organ, description);
  const int room_per_part = max_bytes - header.getEncodedSize();
  HPDM_CHECK(room_per_part >= kVertexBytes);
  const std::vector<int> no_indices;
  const std::vector<int>& kept = description.lattice ? description.lattice->kept : no_indices;

  std::vector<mesh_t> parts;
  int vertex = 0, triangle = 0, index = 0;
  do {
    mesh_t part = header;
    part.part = static_cast<std::int32_t>(parts.size());
    part.first_vertex = vertex;
    part.first_triangle = triangle;
    part.first_kept = index;
    int room = room_per_part;
    const int vertices = Take(header.total_vertices - vertex, kVertexBytes, &room);
    const int triangles = Take(header.total_triangles - triangle, kTriangleBytes, &room);
    const int indices = Take(header.total_kept - index, kIndexBytes, &room);

    const double* v = description.vertices.data() + 3 * static_cast<std::ptrdiff_t>(vertex);
    part.vertices.resize(3 * static_cast<std::size_t>(vertices));
    std::transform(v, v + part.vertices.size(), part.vertices.begin(),
                   [](double x) { return static_cast<float>(x); });
    const int* t = description.triangles.data() + 3 * static_cast<std::ptrdiff_t>(triangle);
    part.triangles.assign(t, t + 3 * static_cast<std::ptrdiff_t>(triangles));
    part.kept.assign(kept.begin() + index, kept.begin() + index + indices);
    part.vertex_value_count = static_cast<std::int32_t>(part.vertices.size());
    part.triangle_value_count = static_cast<std::int32_t>(part.triangles.size());
    part.kept_count = static_cast<std::int32_t>(part.kept.size());
    vertex += vertices;
    triangle += triangles;
    index += indices;
    parts.push_back(std::move(part));
  } while (vertex < header.total_vertices || triangle < header.total_triangles ||
           index < header.total_kept);
  for (mesh_t& part : parts) part.part_count = static_cast<std::int32_t>(parts.size());
  return parts;
}

bool JoinMesh(std::span<const mesh_t> parts, OrganDescription* description, std::string* error) {
  const char* problem = Join(parts, description);
  if (problem != nullptr) *error = problem;
  return problem == nullptr;
}

}  // namespace hpdm
