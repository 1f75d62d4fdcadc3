#include <bit>
#include <cstring>
#include <utility>
#include <vector>

#include "engine/mesh/files/mesh_file_ply_header.h"

/// Body of the Polygon File Format, text and binary.
namespace hpdm::mesh_file {
namespace {

/// Reads the values of a text body, one token each.
class TextValues {
 public:
  TextValues(std::string_view bytes, const PlyHeader& header, const std::string& path)
      : cursor_(bytes, path, header.body, header.lines), size_(bytes.size()) {}
  double Next(PlyType type) {
    const std::string_view token = cursor_.Next();
    if (token.empty()) cursor_.RefuseHere("the file is truncated; export it again");
    const double value = cursor_.Number(token);
    if (!IsInteger(type)) return value;
    std::int64_t integer = 0;  // a float cannot represent every index
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
  /// Returns the fewest bytes that a value takes: a digit and a separator (none after the last).
  std::int64_t Smallest(PlyType) const { return 2; }
  std::int64_t Left() const { return static_cast<std::int64_t>(size_ - cursor_.position()) + 1; }

 private:
  TextCursor cursor_;
  std::size_t size_;
};

/// Reads the values of a binary body.
class BinaryValues {
 public:
  BinaryValues(std::string_view bytes, const PlyHeader& header, const std::string& path)
      : bytes_(bytes),
        at_(header.body),
        swap_((header.encoding == PlyEncoding::kBigEndian) ==
              (std::endian::native == std::endian::little)),
        path_(path) {}
  double Next(PlyType type) {
    const std::size_t size = SizeOf(type);
    if (bytes_.size() - at_ < size) Refuse(path_, "the file is truncated; export it again");
    std::array<char, 8> raw{};
    std::memcpy(raw.data(), bytes_.data() + at_, size);
    if (swap_) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
    at_ += size;
    switch (type) {
      case PlyType::kInt8:
        return As<std::int8_t>(raw);
      case PlyType::kUint8:
        return As<std::uint8_t>(raw);
      case PlyType::kInt16:
        return As<std::int16_t>(raw);
      case PlyType::kUint16:
        return As<std::uint16_t>(raw);
      case PlyType::kInt32:
        return As<std::int32_t>(raw);
      case PlyType::kUint32:
        return As<std::uint32_t>(raw);
      case PlyType::kFloat:
        return As<float>(raw);
      case PlyType::kDouble:
        return As<double>(raw);
    }
    return 0;
  }
  /// Accepts a few more bytes (a line end, padding), but none that could be a vertex or a face.
  void ExpectEnd() const {
    if (Left() < 12) return;
    Refuse(path_, "byte " + std::to_string(at_) + ": " + std::to_string(Left()) +
                      " bytes more than the header claims; the counts are wrong, export it again");
  }
  std::int64_t Smallest(PlyType type) const { return static_cast<std::int64_t>(SizeOf(type)); }
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
  PlyReducer(std::string_view bytes, const PlyHeader& header, const std::string& path)
      : values_(bytes, header, path), header_(header), path_(path) {}

  MeshFile Reduce() {
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex") {
        file_.vertices = element.count;
        textured_ = element.Count(PlyRole::kU) > 0 && element.Count(PlyRole::kV) > 0;
      }
      if (element.name == "face") file_.faces = element.count;
    }
    CheckLimits(file_, path_);
    is_referenced_.resize(static_cast<std::size_t>(file_.vertices));
    for (const PlyElement& element : header_.elements) {
      CheckClaim(element);
      if (element.properties.empty()) continue;
      for (std::int64_t row = 0; row < element.count; ++row) {
        if (element.name == "vertex") {
          ReadVertex(element, row);
        } else if (element.name == "face") {
          ReadFace(element, row);
        } else {
          for (const PlyProperty& property : element.properties) SkipProperty(property);
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
  /// Refuses a count of the header that cannot fit into the bytes that follow.
  void CheckClaim(const PlyElement& element) const {
    std::int64_t smallest = 0;
    for (const PlyProperty& property : element.properties) {
      smallest += values_.Smallest(property.is_list ? property.count_type : property.type);
    }
    if (smallest > 0 && element.count > values_.Left() / smallest) {
      Refuse(path_, "claims " + std::to_string(element.count) + " of element " +
                        QuotedToken(element.name) +
                        ", more than the file can hold; the file is truncated, export it again");
    }
  }

  std::int64_t ReadCount(const PlyProperty& property) {
    const double count = values_.Next(property.count_type);
    if (count < 0 || count > static_cast<double>(values_.Left())) {
      Refuse(path_, "a list is longer than the file; the file is damaged, export it again");
    }
    return static_cast<std::int64_t>(count);
  }

  void SkipProperty(const PlyProperty& property) {
    const std::int64_t count = property.is_list ? ReadCount(property) : 1;
    for (std::int64_t i = 0; i < count; ++i) values_.Next(property.type);
  }

  void ReadVertex(const PlyElement& element, std::int64_t row) {
    std::array<double, 5> value{};
    for (const PlyProperty& property : element.properties) {
      if (property.role == PlyRole::kIgnored) {
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

  void ReadFace(const PlyElement& element, std::int64_t row) {
    for (const PlyProperty& property : element.properties) {
      if (property.role != PlyRole::kIndices) {
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

  /// Writes a guard byte before each vertex: assimp 5.2.5 skips a first coordinate that looks like
  /// the line feed of a "\r\n".
  std::string HeaderText() const {
    return "ply\nformat binary_little_endian 1.0\nelement vertex " +
           std::to_string(file_.vertices) +
           "\nproperty uchar guard\nproperty float x\nproperty float y\nproperty float z\n" +
           (textured_ ? "property float s\nproperty float t\n" : "") + "element face " +
           std::to_string(file_.faces) + "\nproperty list int int vertex_indices\nend_header\n";
  }

  Values values_;
  const PlyHeader& header_;
  const std::string& path_;
  MeshFile file_;
  bool textured_ = false;
  std::string vertex_bytes_, face_bytes_;
  std::vector<bool> is_referenced_;
};

}  // namespace

MeshFile ReducePly(std::string_view bytes, const std::string& path) {
  bytes = WithoutByteOrderMark(bytes);
  const PlyHeader header = ParsePlyHeader(bytes, path);
  if (header.encoding == PlyEncoding::kText) {
    return PlyReducer<TextValues>(bytes, header, path).Reduce();
  }
  return PlyReducer<BinaryValues>(bytes, header, path).Reduce();
}

}  // namespace hpdm::mesh_file
