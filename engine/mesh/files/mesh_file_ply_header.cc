#include "engine/mesh/files/mesh_file_ply_header.h"

#include <charconv>
#include <utility>

namespace hpdm::mesh_file {
namespace {

PlyType ParseType(const TextCursor& cursor, std::string_view name) {
  constexpr std::array<std::pair<std::string_view, PlyType>, 16> kNames = {
      {{"char", PlyType::kInt8},
       {"int8", PlyType::kInt8},
       {"uchar", PlyType::kUint8},
       {"uint8", PlyType::kUint8},
       {"short", PlyType::kInt16},
       {"int16", PlyType::kInt16},
       {"ushort", PlyType::kUint16},
       {"uint16", PlyType::kUint16},
       {"int", PlyType::kInt32},
       {"int32", PlyType::kInt32},
       {"uint", PlyType::kUint32},
       {"uint32", PlyType::kUint32},
       {"float", PlyType::kFloat},
       {"float32", PlyType::kFloat},
       {"double", PlyType::kDouble},
       {"float64", PlyType::kDouble}}};
  for (const auto& [known, type] : kNames) {
    if (name == known) return type;
  }
  cursor.RefuseHere("unknown type " + QuotedToken(name) + " of a property; export the mesh again");
}

PlyRole RoleOf(const std::string& element, std::string_view name, bool is_list) {
  if (element == "face" && is_list && (name == "vertex_indices" || name == "vertex_index")) {
    return PlyRole::kIndices;
  }
  if (element != "vertex" || is_list) return PlyRole::kIgnored;
  if (name == "x") return PlyRole::kX;
  if (name == "y") return PlyRole::kY;
  if (name == "z") return PlyRole::kZ;
  if (name == "s" || name == "u" || name == "tx" || name == "texture_u") return PlyRole::kU;
  if (name == "t" || name == "v" || name == "ty" || name == "texture_v") return PlyRole::kV;
  return PlyRole::kIgnored;
}

PlyProperty ParseProperty(TextCursor* cursor, const std::string& element) {
  PlyProperty property;
  std::string_view type = cursor->NextInLine();
  if (type == "list") {
    property.is_list = true;
    property.count_type = ParseType(*cursor, cursor->NextInLine());
    if (!IsInteger(property.count_type)) {
      cursor->RefuseHere("a list's count must be an integer; export the mesh again");
    }
    type = cursor->NextInLine();
  }
  property.type = ParseType(*cursor, type);
  const std::string_view name = cursor->NextInLine();
  if (name.empty()) cursor->RefuseHere("a property without a name; export the mesh again");
  property.role = RoleOf(element, name, property.is_list);
  if (property.role == PlyRole::kIndices && !IsInteger(property.type)) {
    cursor->RefuseHere("vertex indices must be integers; export the mesh again");
  }
  return property;
}

PlyElement ParseElement(TextCursor* cursor) {
  PlyElement element;
  element.name = cursor->NextInLine();
  const std::string_view count = cursor->NextInLine();
  const auto [end, error] =
      std::from_chars(count.data(), count.data() + count.size(), element.count);
  if (element.name.empty() || error != std::errc() || end != count.data() + count.size() ||
      element.count < 0) {
    cursor->RefuseHere("expected 'element NAME COUNT'; export the mesh again");
  }
  return element;
}

PlyEncoding ParseEncoding(TextCursor* cursor) {
  const std::string_view name = cursor->NextInLine();
  if (name == "ascii") return PlyEncoding::kText;
  if (name == "binary_little_endian") return PlyEncoding::kLittleEndian;
  if (name == "binary_big_endian") return PlyEncoding::kBigEndian;
  cursor->RefuseHere("unknown format " + QuotedToken(name) + "; export as ascii or binary PLY");
}

PlyHeader ParseHeader(std::string_view bytes, const std::string& path) {
  TextCursor cursor(bytes, path);
  if (cursor.NextInLine() != "ply") {
    Refuse(path, "does not begin with 'ply'; name a PLY file or correct the extension");
  }
  cursor.SkipLine();
  PlyHeader header;
  bool has_format = false;
  while (!cursor.AtEnd()) {
    const std::string_view keyword = cursor.NextInLine();
    if (keyword == "end_header") {
      cursor.SkipLine();
      if (!has_format) cursor.RefuseHere("the header names no format; export the mesh again");
      header.body = cursor.position();
      header.lines = cursor.line();
      return header;
    }
    if (keyword == "format") {
      header.encoding = ParseEncoding(&cursor);
      has_format = true;
    } else if (keyword == "element") {
      header.elements.push_back(ParseElement(&cursor));
    } else if (keyword == "property") {
      if (header.elements.empty()) {
        cursor.RefuseHere("a property before any element; export the mesh again");
      }
      PlyElement& element = header.elements.back();
      element.properties.push_back(ParseProperty(&cursor, element.name));
    } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
      cursor.RefuseHere("unknown header line " + QuotedToken(keyword) + "; export the mesh again");
    }
    cursor.SkipLine();
  }
  Refuse(path, "the header has no 'end_header'; the file is truncated, export it again");
}

void CheckElements(const PlyHeader& header, const std::string& path) {
  int vertices = 0, faces = 0;
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex") {
      ++vertices;
      if (element.Count(PlyRole::kX) != 1 || element.Count(PlyRole::kY) != 1 ||
          element.Count(PlyRole::kZ) != 1) {
        Refuse(path, "element 'vertex' needs one x, one y and one z; export the mesh again");
      }
    } else if (element.name == "face") {
      ++faces;
      if (element.Count(PlyRole::kIndices) != 1) {
        Refuse(path, "element 'face' needs one list 'vertex_indices'; export the mesh again");
      }
    }
  }
  if (vertices != 1 || faces != 1) {
    Refuse(path, "needs one element 'vertex' and one element 'face'; export as a triangle mesh");
  }
}

}  // namespace

PlyHeader ParsePlyHeader(std::string_view bytes, const std::string& path) {
  PlyHeader header = ParseHeader(bytes, path);
  CheckElements(header, path);
  return header;
}

}  // namespace hpdm::mesh_file
