#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>

#include "engine/mesh/files/mesh_file_formats.h"

/// Stereolithography: text, or binary with an 80-byte header, a 32-bit count and 50 bytes a facet.
namespace hpdm::mesh_file {
namespace {

constexpr std::size_t kHeader = 84;
constexpr std::size_t kFacet = 50;

std::uint32_t ReadCount(std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof(count));
  return count;
}

/// Collects facets as binary STL with an empty header, without normals or colours.
class FacetWriter {
 public:
  FacetWriter() { file_.bytes.assign(kHeader, '\0'); }

  void Add(const std::array<float, 9>& corners, const std::string& path) {
    std::array<char, kFacet> facet{};
    std::memcpy(facet.data() + 12, corners.data(), sizeof(corners));
    file_.bytes.append(facet.data(), facet.size());
    ++file_.faces;
    file_.corners = file_.vertices = file_.referenced = 3 * file_.faces;
    CheckLimits(file_, path);
  }

  MeshFile Finish() {
    const auto count = static_cast<std::uint32_t>(file_.faces);
    std::memcpy(file_.bytes.data() + 80, &count, sizeof(count));
    file_.format = "stl";
    return std::move(file_);
  }

 private:
  MeshFile file_;
};

/// True if the file begins as text, which no binary STL written on purpose does.
bool BeginsAsText(std::string_view bytes) {
  const std::string_view begin = bytes.substr(0, kHeader);
  return begin.starts_with("\xFF\xFE") || begin.starts_with("\xFE\xFF") ||
         std::all_of(begin.begin(), begin.end(),
                     [](unsigned char c) { return c >= ' ' || std::isspace(c) != 0; });
}

MeshFile ReduceBinary(std::string_view bytes, const std::string& path) {
  if (bytes.size() < kHeader) {
    Refuse(path, "too short for a binary STL and not a text STL; export the mesh again");
  }
  // A few more bytes than claimed may follow, but no whole triangles that would stay unread.
  const std::uint32_t count = ReadCount(bytes);
  const std::size_t held = (bytes.size() - kHeader) / kFacet;
  if (count != held) {
    if (BeginsAsText(bytes)) {
      Refuse(path,
             "begins as text (perhaps UTF-16), but not with 'solid'; name an STL file or save "
             "it as UTF-8");
    }
    Refuse(path, "byte 80: claims " + std::to_string(count) + " triangles but holds " +
                     std::to_string(held) + "; the file is truncated or damaged, export it again");
  }
  FacetWriter writer;
  for (std::size_t f = 0; f < count; ++f) {
    std::array<float, 9> corners;
    std::memcpy(corners.data(), bytes.data() + kHeader + f * kFacet + 12, sizeof(corners));
    if (!std::all_of(corners.begin(), corners.end(), [](float x) { return std::isfinite(x); })) {
      Refuse(path, "triangle " + std::to_string(f + 1) +
                       ": a coordinate is not finite; export the mesh again");
    }
    writer.Add(corners, path);
  }
  return writer.Finish();
}

std::string Lower(std::string_view token) {
  std::string text(token);
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

void Expect(TextCursor* cursor, const char* keyword) {
  const std::string_view token = cursor->Next();
  if (Lower(token) != keyword) {
    cursor->RefuseHere("expected '" + std::string(keyword) + "', found " +
                       (token.empty() ? "the end of the file" : QuotedToken(token)) +
                       "; export the mesh again");
  }
}

MeshFile ReduceText(std::string_view text, const std::string& path) {
  TextCursor cursor(text, path);
  FacetWriter writer;
  bool inside = false;  // between "solid" and "endsolid"
  for (std::string_view token = cursor.Next(); !token.empty(); token = cursor.Next()) {
    const std::string keyword = Lower(token);
    if (keyword == (inside ? "endsolid" : "solid")) {
      cursor.SkipLine();  // the name
      inside = !inside;
    } else if (inside && keyword == "facet") {
      Expect(&cursor, "normal");
      for (int i = 0; i < 3; ++i) cursor.Next();  // the normal: often wrong or NaN, never needed
      Expect(&cursor, "outer");
      Expect(&cursor, "loop");
      std::array<float, 9> corners;
      for (int c = 0; c < 3; ++c) {
        Expect(&cursor, "vertex");
        for (int i = 0; i < 3; ++i) corners[3 * c + i] = cursor.Number(cursor.Next());
      }
      Expect(&cursor, "endloop");
      Expect(&cursor, "endfacet");
      writer.Add(corners, path);
    } else {
      cursor.RefuseHere("unexpected " + QuotedToken(token) + "; export the mesh again");
    }
  }
  if (inside) cursor.RefuseHere("'endsolid' is missing: the file is truncated; export it again");
  return writer.Finish();
}

/// True for a text STL. Many binary files begin with "solid" too, so the size decides first and
/// zero bytes second.
bool IsText(std::string_view bytes) {
  if (bytes.size() >= kHeader && kHeader + kFacet * ReadCount(bytes) == bytes.size()) return false;
  if (bytes.substr(0, 1024).find('\0') != std::string_view::npos) return false;
  const std::size_t begin = bytes.find_first_not_of(" \t\r\n");
  return begin != std::string_view::npos && Lower(bytes.substr(begin, 5)) == "solid";
}

}  // namespace

MeshFile ReduceStl(std::string_view bytes, const std::string& path) {
  const std::string_view text = WithoutByteOrderMark(bytes);
  return IsText(text) ? ReduceText(text, path) : ReduceBinary(bytes, path);
}

}  // namespace hpdm::mesh_file
