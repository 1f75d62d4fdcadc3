#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "engine/mesh/files/mesh_file_formats.h"

/// Polygon File Format (Greg Turk, "The PLY Polygon File Format", 1994), text and binary.
namespace hpdm::mesh_file {
namespace {

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };
enum class Role { kIgnored, kX, kY, kZ, kU, kV, kIndices };
enum class Encoding { kText, kLittleEndian, kBigEndian };

struct Property {
  bool is_list = false;
  Type count_type = Type::kUint8;  ///< Lists only.
  Type type = Type::kFloat;
  Role role = Role::kIgnored;
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
  std::int64_t Count(Role role) const {
    return std::count_if(properties.begin(), properties.end(),
                         [role](const Property& p) { return p.role == role; });
  }
};

struct Header {
  Encoding encoding = Encoding::kText;
  std::vector<Element> elements;
  std::size_t body = 0;  ///< Where the values begin, bytes.
  int lines = 0;
};

bool IsInteger(Type type) { return type != Type::kFloat && type != Type::kDouble; }

std::size_t SizeOf(Type type) {
  constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

Type ParseType(const TextCursor& cursor, std::string_view name) {
  constexpr std::array<std::pair<std::string_view, Type>, 16> kNames = {
      {{"char", Type::kInt8},
       {"int8", Type::kInt8},
       {"uchar", Type::kUint8},
       {"uint8", Type::kUint8},
       {"short", Type::kInt16},
       {"int16", Type::kInt16},
       {"ushort", Type::kUint16},
       {"uint16", Type::kUint16},
       {"int", Type::kInt32},
       {"int32", Type::kInt32},
       {"uint", Type::kUint32},
       {"uint32", Type::kUint32},
       {"float", Type::kFloat},
       {"float32", Type::kFloat},
       {"double", Type::kDouble},
       {"float64", Type::kDouble}}};
  for (const auto& [known, type] : kNames) {
    if (name == known) return type;
  }
  cursor.RefuseHere("unknown type " + QuotedToken(name) + " of a property; export the mesh again");
}

Role RoleOf(const std::string& element, std::string_view name, bool is_list) {
  if (element == "face" && is_list && (name == "vertex_indices" || name == "vertex_index")) {
    return Role::kIndices;
  }
  if (element != "vertex" || is_list) return Role::kIgnored;
  if (name == "x") return Role::kX;
  if (name == "y") return Role::kY;
  if (name == "z") return Role::kZ;
  if (name == "s" || name == "u" || name == "tx" || name == "texture_u") return Role::kU;
  if (name == "t" || name == "v" || name == "ty" || name == "texture_v") return Role::kV;
  return Role::kIgnored;
}

Property ParseProperty(TextCursor* cursor, const std::string& element) {
  Property property;
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
  if (property.role == Role::kIndices && !IsInteger(property.type)) {
    cursor->RefuseHere("vertex indices must be integers; export the mesh again");
  }
  return property;
}

Element ParseElement(TextCursor* cursor) {
  Element element;
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

Encoding ParseEncoding(TextCursor* cursor) {
  const std::string_view name = cursor->NextInLine();
  if (name == "ascii") return Encoding::kText;
  if (name == "binary_little_endian") return Encoding::kLittleEndian;
  if (name == "binary_big_endian") return Encoding::kBigEndian;
  cursor->RefuseHere("unknown format " + QuotedToken(name) + "; export as ascii or binary PLY");
}

Header ParseHeader(std::string_view bytes, const std::string& path) {
  TextCursor cursor(bytes, path);
  if (cursor.NextInLine() != "ply") {
    Refuse(path, "does not begin with 'ply'; name a PLY file or correct the extension");
  }
  cursor.SkipLine();
  Header header;
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
      Element& element = header.elements.back();
      element.properties.push_back(ParseProperty(&cursor, element.name));
    } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
      cursor.RefuseHere("unknown header line " + QuotedToken(keyword) + "; export the mesh again");
    }
    cursor.SkipLine();
  }
  Refuse(path, "the header has no 'end_header'; the file is truncated, export it again");
}

/// Values of a text body, one token each.
class TextValues {
 public:
  TextValues(std::string_view bytes, const Header& header, const std::string& path)
      : cursor_(bytes, path, header.body, header.lines), size_(bytes.size()) {}
  double Next(Type type) {
    const std::string_view token = cursor_.Next();
    if (token.empty()) cursor_.RefuseHere("the file is truncated; export it again");
    const double value = cursor_.Number(token);
    if (!IsInteger(type)) return value;
    std::int64_t integer = 0;  // a float does not hold every index
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), integer);
    if (error != std::errc() || end != token.data() + token.size()) {
      cursor_.RefuseHere("expected an integer, found " + QuotedToken(token) + "; export it again");
    }
    return static_cast<double>(integer);
  }
  void ExpectEnd() {
    if (!cursor_.Next().empty()) {
      cursor_.RefuseHere("more than the header claims; the counts are wrong, export it again");
    }
  }
  /// Fewest bytes that a value takes: a digit and a separator, without one after the last.
  std::int64_t Smallest(Type) const { return 2; }
  std::int64_t Left() const { return static_cast<std::int64_t>(size_ - cursor_.position()) + 1; }

 private:
  TextCursor cursor_;
  std::size_t size_;
};

/// Values of a binary body.
class BinaryValues {
 public:
  BinaryValues(std::string_view bytes, const Header& header, const std::string& path)
      : bytes_(bytes),
        at_(header.body),
        swap_((header.encoding == Encoding::kBigEndian) ==
              (std::endian::native == std::endian::little)),
        path_(path) {}
  double Next(Type type) {
    const std::size_t size = SizeOf(type);
    if (bytes_.size() - at_ < size) Refuse(path_, "the file is truncated; export it again");
    std::array<char, 8> raw{};
    std::memcpy(raw.data(), bytes_.data() + at_, size);
    if (swap_) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
    at_ += size;
    switch (type) {
      case Type::kInt8:
        return As<std::int8_t>(raw);
      case Type::kUint8:
        return As<std::uint8_t>(raw);
      case Type::kInt16:
        return As<std::int16_t>(raw);
      case Type::kUint16:
        return As<std::uint16_t>(raw);
      case Type::kInt32:
        return As<std::int32_t>(raw);
      case Type::kUint32:
        return As<std::uint32_t>(raw);
      case Type::kFloat:
        return As<float>(raw);
      case Type::kDouble:
        return As<double>(raw);
    }
    return 0;
  }
  /// Few bytes may follow, a line's end or padding, but not what could be a vertex or a face.
  void ExpectEnd() const {
    if (Left() < 12) return;
    Refuse(path_, "byte " + std::to_string(at_) + ": " + std::to_string(Left()) +
                      " bytes more than the header claims; the counts are wrong, export it again");
  }
  std::int64_t Smallest(Type type) const { return static_cast<std::int64_t>(SizeOf(type)); }
  std::int64_t Left() const { return static_cast<std::int64_t>(bytes_.size() - at_); }

 private:
  template <typename T>
  static double As(const std::array<char, 8>& raw) {
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return static_cast<double>(value);
  }

  std::string_view bytes_;
  std::size_t at_;
  bool swap_;
  const std::string& path_;
};

template <typename T>
void AppendRaw(std::string* out, T value) {
  out->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// Walks the body element by element and collects vertices and faces.
template <typename Values>
class PlyReducer {
 public:
  PlyReducer(std::string_view bytes, const Header& header, const std::string& path)
      : values_(bytes, header, path), header_(header), path_(path) {}

  MeshFile Reduce() {
    for (const Element& element : header_.elements) {
      if (element.name == "vertex") {
        file_.vertices = element.count;
        textured_ = element.Count(Role::kU) > 0 && element.Count(Role::kV) > 0;
      }
      if (element.name == "face") file_.faces = element.count;
    }
    CheckLimits(file_, path_);
    is_referenced_.resize(static_cast<std::size_t>(file_.vertices));
    for (const Element& element : header_.elements) {
      CheckClaim(element);
      if (element.properties.empty()) continue;
      for (std::int64_t row = 0; row < element.count; ++row) {
        if (element.name == "vertex") {
          ReadVertex(element, row);
        } else if (element.name == "face") {
          ReadFace(element, row);
        } else {
          for (const Property& property : element.properties) SkipProperty(property);
        }
      }
    }
    values_.ExpectEnd();
    file_.referenced = std::count(is_referenced_.begin(), is_referenced_.end(), true);
    file_.format = "ply";
    file_.bytes = HeaderText() + vertex_bytes_ + face_bytes_;
    return std::move(file_);
  }

 private:
  /// A header may claim any count: it must fit into the bytes that follow.
  void CheckClaim(const Element& element) const {
    std::int64_t smallest = 0;
    for (const Property& property : element.properties) {
      smallest += values_.Smallest(property.is_list ? property.count_type : property.type);
    }
    if (smallest > 0 && element.count > values_.Left() / smallest) {
      Refuse(path_, "claims " + std::to_string(element.count) + " of element " +
                        QuotedToken(element.name) +
                        ", more than the file can hold; the file is truncated, export it again");
    }
  }

  std::int64_t ReadCount(const Property& property) {
    const double count = values_.Next(property.count_type);
    if (count < 0 || count > static_cast<double>(values_.Left())) {
      Refuse(path_, "a list is longer than the file; the file is damaged, export it again");
    }
    return static_cast<std::int64_t>(count);
  }

  void SkipProperty(const Property& property) {
    const std::int64_t count = property.is_list ? ReadCount(property) : 1;
    for (std::int64_t i = 0; i < count; ++i) values_.Next(property.type);
  }

  void ReadVertex(const Element& element, std::int64_t row) {
    std::array<double, 5> value{};
    for (const Property& property : element.properties) {
      if (property.role == Role::kIgnored) {
        SkipProperty(property);
      } else {
        value[static_cast<std::size_t>(property.role) - 1] = values_.Next(property.type);
      }
    }
    const std::size_t used = textured_ ? 5 : 3;
    vertex_bytes_ += '\1';  // see HeaderText
    for (std::size_t i = 0; i < used; ++i) {
      const auto narrow = static_cast<float>(value[i]);
      if (!std::isfinite(narrow)) {
        Refuse(path_, "vertex " + std::to_string(row + 1) +
                          ": a coordinate is not finite; export the mesh again");
      }
      AppendRaw(&vertex_bytes_, narrow);
    }
  }

  void ReadFace(const Element& element, std::int64_t row) {
    for (const Property& property : element.properties) {
      if (property.role != Role::kIndices) {
        SkipProperty(property);
        continue;
      }
      const std::int64_t count = ReadCount(property);
      if (count < 3 || count > MeshFileLimits::kFaceCorners) {
        RefuseFace(row,
                   "has " + std::to_string(count) + " corners, not 3 to 256; triangulate the mesh");
      }
      file_.corners += count;
      CheckLimits(file_, path_);
      AppendRaw(&face_bytes_, static_cast<std::int32_t>(count));
      for (std::int64_t i = 0; i < count; ++i) {
        const double index = values_.Next(property.type);
        if (!(index >= 0 && index < static_cast<double>(file_.vertices))) {
          RefuseFace(row, "names a vertex beyond the last one; export the mesh again");
        }
        AppendRaw(&face_bytes_, static_cast<std::int32_t>(index));
        is_referenced_[static_cast<std::size_t>(index)] = true;
      }
    }
  }

  [[noreturn]] void RefuseFace(std::int64_t row, const std::string& what) const {
    Refuse(path_, "face " + std::to_string(row + 1) + ": " + what);
  }

  /// The guard byte before each vertex keeps assimp 5.2.5 from eating a first coordinate that looks
  /// like the line feed of a "\r\n".
  std::string HeaderText() const {
    return "ply\nformat binary_little_endian 1.0\nelement vertex " +
           std::to_string(file_.vertices) +
           "\nproperty uchar guard\nproperty float x\nproperty float y\nproperty float z\n" +
           (textured_ ? "property float s\nproperty float t\n" : "") + "element face " +
           std::to_string(file_.faces) + "\nproperty list int int vertex_indices\nend_header\n";
  }

  Values values_;
  const Header& header_;
  const std::string& path_;
  MeshFile file_;
  bool textured_ = false;
  std::string vertex_bytes_, face_bytes_;
  std::vector<bool> is_referenced_;
};

/// Exactly one element "vertex" with x, y, z and one "face" with indices.
void CheckElements(const Header& header, const std::string& path) {
  int vertices = 0, faces = 0;
  for (const Element& element : header.elements) {
    if (element.name == "vertex") {
      ++vertices;
      if (element.Count(Role::kX) != 1 || element.Count(Role::kY) != 1 ||
          element.Count(Role::kZ) != 1) {
        Refuse(path, "element 'vertex' needs one x, one y and one z; export the mesh again");
      }
    } else if (element.name == "face") {
      ++faces;
      if (element.Count(Role::kIndices) != 1) {
        Refuse(path, "element 'face' needs one list 'vertex_indices'; export the mesh again");
      }
    }
  }
  if (vertices != 1 || faces != 1) {
    Refuse(path, "needs one element 'vertex' and one element 'face'; export as a triangle mesh");
  }
}

}  // namespace

MeshFile ReducePly(std::string_view bytes, const std::string& path) {
  bytes = WithoutByteOrderMark(bytes);
  const Header header = ParseHeader(bytes, path);
  CheckElements(header, path);
  if (header.encoding == Encoding::kText) {
    return PlyReducer<TextValues>(bytes, header, path).Reduce();
  }
  return PlyReducer<BinaryValues>(bytes, header, path).Reduce();
}

}  // namespace hpdm::mesh_file
