#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/wire/mesh_codec.h"

namespace hpdm {

/// Assembles one organ's HPDM_MESH parts. Parts may be repeated, and may change while a session
/// runs or when another begins. One thread.
class MeshParts {
 public:
  /// Largest memory of the parts that wait for the rest of their mesh, bytes.
  static constexpr std::size_t kMaxWaitingBytes = 32 << 20;
  /// Largest number of control points that a page can show.
  static constexpr double kMaxFunctions = 1e6;

  /// Takes a part. Returns true if it completed a mesh that differs from the previous one.
  bool Take(mesh_t&& part);

  /// The newest complete mesh.
  const std::optional<OrganDescription>& whole() const { return whole_; }
  /// Approximate memory of the mesh and its waiting parts.
  std::size_t bytes() const { return waiting_bytes_ + whole_bytes_; }
  /// The reason why the newest parts made no mesh; empty if they did.
  const std::string& error() const { return error_; }

 private:
  std::map<int, mesh_t> waiting_;  // by part number
  std::size_t waiting_bytes_ = 0;
  std::vector<std::uint64_t> hashes_;  // of the complete mesh's parts
  std::optional<OrganDescription> whole_;
  std::size_t whole_bytes_ = 0;
  std::string error_;
};

}  // namespace hpdm
