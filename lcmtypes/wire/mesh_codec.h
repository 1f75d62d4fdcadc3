#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/types.h"
#include "engine/organ_options.h"
#include "hpdm/mesh_t.hpp"

namespace hpdm {

/// An organ's lattice as a viewer needs it to turn control displacements into a surface (Eq. 4).
struct LatticeDescription {
  BasisType basis = BasisType::kBSpline;
  std::array<int, 3> degree = {2, 2, 2};
  std::array<int, 3> cells = {4, 4, 4};  ///< 1 in each direction for Bernstein.
  Vector3d origin_W = Vector3d::Zero();  ///< Corner of the box, m.
  Matrix3d axes = Matrix3d::Identity();  ///< Columns: unit vectors of the box's edges, world.
  Vector3d lengths = Vector3d::Ones();   ///< Edge lengths, m.
  std::vector<int> kept;                 ///< Grid index of each row of the displacements, n.
  /// Cells of the finer splines that local functions come from, for each cell and axis; 0: none.
  int local_refinement = 0;
};

/// The constant part of an organ during a session.
struct OrganDescription {
  std::string name;
  Points vertices;      ///< V x 3, rest, world, m; crosses in float.
  Triangles triangles;  ///< F x 3.
  /// If absent, the displacements belong to the vertices (V x 3, or none).
  std::optional<LatticeDescription> lattice;
};

/// Largest encoded part: with default socket buffers messages of several 100 kB are lost.
inline constexpr int kMaxMeshPartBytes = 50'000;
/// Longest name kept; longer ones are cut, so that a part always has room for items.
inline constexpr int kMaxOrganNameBytes = 256;

/// Returns the parts of organ `organ`, at least one, each of at most `max_bytes` (>= 2,000)
/// encoded. The sequence numbers are left at 0 for the sender.
std::vector<mesh_t> SplitMesh(int organ, const OrganDescription& description,
                              int max_bytes = kMaxMeshPartBytes);

/// Joins the parts of one organ, in any order. Returns false, with the reason in `error` and an
/// unspecified `description`, if they are not exactly one whole and sound organ: a part missing,
/// repeated or of another organ, counts that disagree, indices out of range, or a lattice that no
/// engine builds. Totals are checked against the parts' items before memory is allocated.
bool JoinMesh(std::span<const mesh_t> parts, OrganDescription* description, std::string* error);

}  // namespace hpdm
