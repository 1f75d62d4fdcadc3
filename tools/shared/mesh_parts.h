#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/wire/mesh_codec.h"

namespace hpdm {

/// Gathers one organ's HPDM_MESH parts, repeated or changed while a session runs or another begins.
/// One thread.
class MeshParts {
 public:
  /// Bytes of parts that may wait for the rest of their mesh.
  static constexpr std::size_t kMaxWaitingBytes = 32 << 20;
  /// Control points along all axes that a page has room for.
  static constexpr double kMaxFunctions = 1e6;

  /// Takes a part; true when it completed a mesh other than the one before.
  bool Take(mesh_t&& part);

  /// The newest whole mesh.
  const std::optional<OrganDescription>& whole() const { return whole_; }
  /// Memory that the mesh and its waiting parts take, about.
  std::size_t bytes() const { return waiting_bytes_ + whole_bytes_; }
  /// Why the newest parts made no mesh; empty when they did.
  const std::string& error() const { return error_; }

 private:
  std::map<int, mesh_t> waiting_;  // by part number
  std::size_t waiting_bytes_ = 0;
  std::vector<std::uint64_t> hashes_;  // of the whole's parts
  std::optional<OrganDescription> whole_;
  std::size_t whole_bytes_ = 0;
  std::string error_;
};

}  // namespace hpdm
