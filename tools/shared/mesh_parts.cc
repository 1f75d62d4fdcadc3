#include "tools/shared/mesh_parts.h"

#include <algorithm>
#include <utility>

#include "lcmtypes/wire/codec.h"

namespace hpdm {
namespace {

// Returns the 64-bit FNV-1a hash of the encoded part.
std::uint64_t HashOf(const mesh_t& part) {
  std::vector<std::uint8_t> buffer;
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const std::uint8_t byte : EncodeMessage(part, &buffer)) {
    hash = (hash ^ byte) * 0x100000001b3u;
  }
  return hash;
}

std::size_t BytesOf(const mesh_t& part) {
  return sizeof part + part.name.size() +
         4 * (part.vertices.size() + part.triangles.size() + part.kept.size());
}

}  // namespace

bool MeshParts::Take(mesh_t&& part) {
  const int number = part.part;
  if (number < 0 || number >= part.part_count) return false;
  part.sequence = 0;  // the only field that differs when a part is repeated
  const std::uint64_t hash = HashOf(part);
  if (hashes_.size() == static_cast<std::size_t>(part.part_count) && hashes_[number] == hash) {
    return false;
  }
  if (!waiting_.empty() && waiting_.begin()->second.part_count != part.part_count) {
    waiting_.clear();  // parts of a mesh that was replaced
    waiting_bytes_ = 0;
  }
  if (const auto old = waiting_.find(number); old != waiting_.end()) {
    waiting_bytes_ -= BytesOf(old->second);
    waiting_.erase(old);
  }
  waiting_bytes_ += BytesOf(part);
  const int count = part.part_count;
  waiting_.emplace(number, std::move(part));
  if (waiting_bytes_ > kMaxWaitingBytes) {
    error_ = "its mesh is too large to show";
    waiting_.clear();
    waiting_bytes_ = 0;
    return false;
  }
  if (waiting_.size() != static_cast<std::size_t>(count)) return false;

  std::vector<mesh_t> parts;
  for (auto& [key, value] : waiting_) parts.push_back(std::move(value));
  waiting_.clear();
  waiting_bytes_ = 0;
  OrganDescription whole;
  if (!JoinMesh(parts, &whole, &error_)) return false;
  if (whole.lattice) {
    double functions = 1;
    for (int d = 0; d < 3; ++d) {
      const LatticeDescription& lattice = *whole.lattice;
      const bool bernstein = lattice.basis == BasisType::kBernstein;
      const int finest = bernstein ? 1 : lattice.cells[d] * std::max(lattice.local_refinement, 1);
      functions *= finest + lattice.degree[d];
    }
    if (functions > kMaxFunctions) {
      error_ = "its lattice is too fine to show";
      return false;
    }
  }
  error_.clear();
  whole_bytes_ = static_cast<std::size_t>(whole.vertices.size()) * sizeof(double) +
                 static_cast<std::size_t>(whole.triangles.size()) * sizeof(int);
  hashes_.clear();
  for (const mesh_t& one : parts) hashes_.push_back(HashOf(one));
  whole_ = std::move(whole);
  return true;
}

}  // namespace hpdm
