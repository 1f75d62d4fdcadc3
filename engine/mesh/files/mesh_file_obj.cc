#include <algorithm>
#include <utility>
#include <vector>

#include "engine/mesh/files/mesh_file_formats.h"

/// Wavefront OBJ (Alias|Wavefront, "Object Files", appendix B1): the statements v, vt and f.
namespace hpdm::mesh_file {
namespace {

struct Corner {
  std::int64_t vertex = 0;   ///< Counted from 1.
  std::int64_t texture = 0;  ///< Counted from 1; 0 without texture coordinates.
};

/// Appends a space and the number, never beginning with a point: assimp 5.2.5 skips such vertices.
void AppendNumber(std::string* out, float value) {
  char digits[32];
  const auto result = std::to_chars(digits, digits + sizeof(digits), value);
  *out += ' ';
  out->append(digits, result.ptr);
}

class ObjReducer {
 public:
  ObjReducer(std::string_view text, const std::string& path) : cursor_(text, path), path_(path) {}

  MeshFile Reduce() {
    while (!cursor_.AtEnd()) {
      const std::string_view keyword = cursor_.NextInLine();
      if (keyword == "v") {
        AddVertex();
      } else if (keyword == "vt") {
        AddTexture();
      } else if (keyword == "f") {
        AddFace();
      }
      cursor_.SkipLine();
      CheckLimits(file_, path_);
    }
    // Indices may refer to later vertices, so they are checked at the end.
    CheckIndex(largest_.vertex, file_.vertices, vertex_line_, "vertex");
    CheckIndex(largest_.texture, textures_, texture_line_, "texture coordinate");
    std::vector<bool> is_referenced(static_cast<std::size_t>(file_.vertices));
    for (const std::int32_t v : referenced_) is_referenced[static_cast<std::size_t>(v - 1)] = true;
    file_.referenced = std::count(is_referenced.begin(), is_referenced.end(), true);
    file_.format = "obj";
    file_.bytes = "o mesh\n" + vertex_lines_ + texture_lines_ + face_lines_;
    return std::move(file_);
  }

 private:
  void AddVertex() {
    vertex_lines_ += 'v';
    for (int i = 0; i < 3; ++i) AppendNumber(&vertex_lines_, cursor_.Number(cursor_.NextInLine()));
    vertex_lines_ += '\n';
    ++file_.vertices;
  }

  void AddTexture() {
    texture_lines_ += "vt";
    AppendNumber(&texture_lines_, cursor_.Number(cursor_.NextInLine()));
    const std::string_view v = cursor_.NextInLine();
    AppendNumber(&texture_lines_, v.empty() ? 0.f : cursor_.Number(v));
    texture_lines_ += '\n';
    ++textures_;
    if (textures_ > MeshFileLimits::kVertices) {
      Refuse(path_, "more than 10000000 texture coordinates; reduce the mesh");
    }
  }

  void AddFace() {
    corners_.clear();
    bool textured = true;
    for (std::string_view token = cursor_.NextInLine(); !token.empty() && token[0] != '#';
         token = cursor_.NextInLine()) {
      corners_.push_back(ParseCorner(token));
      textured = textured && corners_.back().texture != 0;
      if (corners_.size() > MeshFileLimits::kFaceCorners) {
        cursor_.RefuseHere("a face with more than 256 corners; triangulate the mesh");
      }
    }
    if (corners_.size() < 3) {
      cursor_.RefuseHere("a face with fewer than 3 corners; export the mesh again");
    }
    face_lines_ += 'f';
    for (const Corner& corner : corners_) {
      referenced_.push_back(static_cast<std::int32_t>(corner.vertex));
      face_lines_ += ' ' + std::to_string(corner.vertex);
      if (textured) face_lines_ += '/' + std::to_string(corner.texture);
    }
    face_lines_ += '\n';
    ++file_.faces;
    file_.corners += static_cast<std::int64_t>(corners_.size());
  }

  /// Parses "v", "v/vt", "v//vn" or "v/vt/vn".
  Corner ParseCorner(std::string_view token) {
    Corner corner;
    const std::size_t slash = token.find('/');
    corner.vertex = ParseIndex(token.substr(0, slash), file_.vertices);
    if (corner.vertex > largest_.vertex) {
      largest_.vertex = corner.vertex;
      vertex_line_ = cursor_.line();
    }
    if (slash == std::string_view::npos) return corner;
    const std::string_view rest = token.substr(slash + 1);
    const std::string_view texture = rest.substr(0, rest.find('/'));
    if (texture.empty()) return corner;
    corner.texture = ParseIndex(texture, textures_);
    if (corner.texture > largest_.texture) {
      largest_.texture = corner.texture;
      texture_line_ = cursor_.line();
    }
    return corner;
  }

  /// Parses an index. Positive ones count from 1, negative ones back from the newest of the `count`
  /// items so far.
  std::int64_t ParseIndex(std::string_view token, std::int64_t count) const {
    std::int64_t index = 0;
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), index);
    if (index < 0) index = count + 1 + index;
    if (error != std::errc() || end != token.data() + token.size() || index < 1 ||
        index > MeshFileLimits::kVertices) {
      cursor_.RefuseHere("face index " + QuotedToken(token) +
                         " names nothing; export the mesh again");
    }
    return index;
  }

  void CheckIndex(std::int64_t index, std::int64_t count, int line, const char* what) const {
    if (index > count) {
      Refuse(path_, "line " + std::to_string(line) + ": face index " + std::to_string(index) +
                        " is beyond the last " + what + " " + std::to_string(count) +
                        "; export the mesh again");
    }
  }

  TextCursor cursor_;
  const std::string& path_;
  MeshFile file_;
  std::int64_t textures_ = 0;
  std::string vertex_lines_, texture_lines_, face_lines_;
  std::vector<Corner> corners_;
  std::vector<std::int32_t> referenced_;
  Corner largest_;
  int vertex_line_ = 0, texture_line_ = 0;
};

}  // namespace

MeshFile ReduceObj(std::string_view text, const std::string& path) {
  text = WithoutByteOrderMark(text);
  if (text.substr(0, 4096).find('\0') != std::string_view::npos) {
    Refuse(path, "is not plain text (UTF-16 or binary); save it as UTF-8");
  }
  return ObjReducer(text, path).Reduce();
}

}  // namespace hpdm::mesh_file
