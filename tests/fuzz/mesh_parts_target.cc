#include <algorithm>
#include <string>
#include <vector>

#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/mesh_codec.h"
#include "tests/fuzz/input_file.h"

namespace hpdm::fuzz {
namespace {

std::vector<mesh_t> Parts(Bytes bytes) {
  std::vector<mesh_t> parts;
  while (bytes.size() >= 2) {
    const std::size_t length = std::min<std::size_t>(bytes[0] | bytes[1] << 8, bytes.size() - 2);
    mesh_t part{};
    if (DecodeMessage(bytes.subspan(2, length), &part)) parts.push_back(std::move(part));
    bytes = bytes.subspan(2 + length);
  }
  return parts;
}

void EnsureSound(const OrganDescription& organ) {
  HPDM_ENSURE(organ.vertices.allFinite());
  for (Eigen::Index t = 0; t < organ.triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c) {
      HPDM_ENSURE(organ.triangles(t, c) >= 0 && organ.triangles(t, c) < organ.vertices.rows());
    }
  }
  if (!organ.lattice) return;
  const LatticeDescription& lattice = *organ.lattice;
  HPDM_ENSURE(lattice.origin_W.allFinite() && lattice.lengths.allFinite());
  HPDM_ENSURE(lattice.lengths.minCoeff() > 0 && lattice.axes.allFinite());
  HPDM_ENSURE(lattice.local_refinement >= 0);
  int functions = 1;
  for (std::size_t d = 0; d < 3; ++d) {
    HPDM_ENSURE(lattice.degree[d] >= 1 && lattice.cells[d] >= 1);
    functions *= lattice.degree[d] + lattice.cells[d];
  }
  for (const int index : lattice.kept) HPDM_ENSURE(index >= 0 && index < functions);
}

void EnsureSame(const OrganDescription& a, const OrganDescription& b) {
  HPDM_ENSURE(a.name == b.name);
  HPDM_ENSURE(a.vertices == b.vertices && a.triangles == b.triangles);
  HPDM_ENSURE(a.lattice.has_value() == b.lattice.has_value());
  if (!a.lattice) return;
  HPDM_ENSURE(a.lattice->basis == b.lattice->basis && a.lattice->degree == b.lattice->degree);
  HPDM_ENSURE(a.lattice->cells == b.lattice->cells && a.lattice->kept == b.lattice->kept);
  HPDM_ENSURE(a.lattice->origin_W == b.lattice->origin_W && a.lattice->axes == b.lattice->axes);
  HPDM_ENSURE(a.lattice->lengths == b.lattice->lengths);
  HPDM_ENSURE(a.lattice->local_refinement == b.lattice->local_refinement);
}

}  // namespace

bool MeshParts(Bytes bytes) {
  std::vector<mesh_t> parts = Parts(bytes);
  OrganDescription organ;
  std::string error;
  if (!JoinMesh(parts, &organ, &error)) {
    HPDM_ENSURE(!error.empty());
    return false;
  }
  EnsureSound(organ);
  OrganDescription again;
  std::reverse(parts.begin(), parts.end());
  HPDM_ENSURE(JoinMesh(parts, &again, &error));
  EnsureSame(organ, again);
  HPDM_ENSURE(JoinMesh(SplitMesh(parts[0].organ, organ), &again, &error));
  EnsureSame(organ, again);
  return true;
}

}  // namespace hpdm::fuzz
