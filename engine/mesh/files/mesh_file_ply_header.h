#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/mesh/files/mesh_file_formats.h"

/// Header of the Polygon File Format (Greg Turk, "The PLY Polygon File Format", 1994); used by
/// mesh_file_ply*.cc only.
namespace hpdm::mesh_file {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };
enum class PlyRole { kIgnored, kX, kY, kZ, kU, kV, kIndices };
enum class PlyEncoding { kText, kLittleEndian, kBigEndian };

struct PlyProperty {
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  ///< Lists only.
  PlyType type = PlyType::kFloat;
  PlyRole role = PlyRole::kIgnored;
};

struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::vector<PlyProperty> properties;
  /// Returns the number of properties with `role`.
  std::int64_t Count(PlyRole role) const {
    return std::count_if(properties.begin(), properties.end(),
                         [role](const PlyProperty& p) { return p.role == role; });
  }
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kText;
  std::vector<PlyElement> elements;
  std::size_t body = 0;  ///< Offset of the first value, bytes.
  int lines = 0;         ///< Number of the first line of values, from 1.
};

inline bool IsInteger(PlyType type) { return type != PlyType::kFloat && type != PlyType::kDouble; }

/// Returns the size of a binary value, bytes.
inline std::size_t SizeOf(PlyType type) {
  constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

/// Parses the header of a PLY file. Refuses one without exactly one element "vertex" with x, y and
/// z and one element "face" with vertex indices.
PlyHeader ParsePlyHeader(std::string_view bytes, const std::string& path);

}  // namespace hpdm::mesh_file
