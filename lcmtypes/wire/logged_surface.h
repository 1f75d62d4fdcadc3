#pragma once

#include <optional>

#include "engine/base/types.h"
#include "engine/lattice/lattice.h"
#include "engine/snapshots.h"
#include "lcmtypes/wire/mesh_codec.h"

namespace hpdm {

/// Computes the surface of one organ from its messages, as lcmtypes/README.md describes. One
/// thread.
class LoggedSurface {
 public:
  /// `organ` as JoinMesh returns it.
  explicit LoggedSurface(OrganDescription organ);

  const OrganDescription& organ() const { return organ_; }

  /// Sets `vertices` (V x 3, world, m) to the surface of `shape`. Returns false, with unspecified
  /// `vertices`, if the shape has other control points or local functions than the organ, or
  /// values that are not finite.
  bool Deform(const OrganSnapshot& shape, Points* vertices) const;

 private:
  bool AddLocalFunctions(const OrganSnapshot& shape, Points* vertices) const;
  void AddIndentation(const IndentationSnapshot& indentation, Points* vertices) const;

  OrganDescription organ_;
  Points normals_;               ///< V x 3, at rest.
  WeightMatrix weights_;         ///< V x n; empty without a lattice.
  std::optional<Lattice> fine_;  ///< Of the local functions.
};

}  // namespace hpdm
