#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>

#include "engine/mesh/surface_mesh.h"

/// Meshes as files of every kind that the import takes, for tests. Coordinates are floats.
namespace hpdm {

/// A number's bytes, the low one first unless `big`.
template <typename T>
std::string Raw(T value, bool big = false) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (big) std::reverse(bytes.begin(), bytes.end());
  return {bytes.data(), bytes.size()};
}

/// Writes the shortest text that reads back as the same number.
inline std::string Text(double value) {
  std::array<char, 32> digits;
  const auto written =
      std::to_chars(digits.data(), digits.data() + digits.size(), static_cast<float>(value));
  return std::string(digits.data(), written.ptr);
}

inline std::string PointText(const Eigen::RowVector3d& p) {
  return Text(p.x()) + ' ' + Text(p.y()) + ' ' + Text(p.z());
}

/// Lines "v x y z".
inline std::string ObjVertices(const Points& vertices) {
  std::string text;
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
    text += "v " + PointText(vertices.row(v)) + '\n';
  }
  return text;
}

inline std::string ObjText(const SurfaceMesh& mesh) {
  std::string text = ObjVertices(mesh.vertices);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    text += 'f';
    for (int c = 0; c < 3; ++c) text += ' ' + std::to_string(mesh.triangles(t, c) + 1);
    text += '\n';
  }
  return text;
}

inline std::string StlText(const SurfaceMesh& mesh) {
  std::string text = "solid body\n";
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (int c = 0; c < 3; ++c) {
      text += "vertex " + PointText(mesh.vertices.row(mesh.triangles(t, c))) + '\n';
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid body\n";
}

/// `claimed`: the number of triangles that the header states.
inline std::string StlBytes(const SurfaceMesh& mesh, std::uint32_t claimed) {
  std::string bytes = "solid misleading";
  bytes.resize(80);
  bytes += Raw(claimed);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    bytes += std::string(12, '\0');
    for (int c = 0; c < 3; ++c) {
      for (int d = 0; d < 3; ++d) {
        bytes += Raw(static_cast<float>(mesh.vertices(mesh.triangles(t, c), d)));
      }
    }
    bytes += std::string("\xff\xff", 2);
  }
  return bytes;
}
inline std::string StlBytes(const SurfaceMesh& mesh) {
  return StlBytes(mesh, static_cast<std::uint32_t>(mesh.triangles.rows()));
}

enum class PlyEncoding { kText, kLittleEndian, kBigEndian };

/// The header's end and beginning, with numbers or words for the counts.
inline std::string PlyHeader(PlyEncoding encoding, const std::string& vertices,
                             const std::string& faces) {
  constexpr std::array<const char*, 3> kNames = {"ascii", "binary_little_endian",
                                                 "binary_big_endian"};
  return std::string("ply\nformat ") + kNames[static_cast<std::size_t>(encoding)] +
         " 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

inline std::string PlyHeader(PlyEncoding encoding, const SurfaceMesh& mesh) {
  return PlyHeader(encoding, std::to_string(mesh.vertices.rows()),
                   std::to_string(mesh.triangles.rows()));
}

inline std::string PlyBody(PlyEncoding encoding, const SurfaceMesh& mesh) {
  const bool big = encoding == PlyEncoding::kBigEndian;
  std::string body;
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    if (encoding == PlyEncoding::kText) {
      body += PointText(mesh.vertices.row(v)) + '\n';
      continue;
    }
    for (int d = 0; d < 3; ++d) body += Raw(static_cast<float>(mesh.vertices(v, d)), big);
  }
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (encoding == PlyEncoding::kText) {
      body += '3';
      for (int c = 0; c < 3; ++c) body += ' ' + std::to_string(mesh.triangles(t, c));
      body += '\n';
      continue;
    }
    body += '\3';
    for (int c = 0; c < 3; ++c) body += Raw(mesh.triangles(t, c), big);
  }
  return body;
}

inline std::string PlyBytes(PlyEncoding encoding, const SurfaceMesh& mesh) {
  return PlyHeader(encoding, mesh) + PlyBody(encoding, mesh);
}

}  // namespace hpdm
