#include <limits>

#include "tests/bad_input/meshes/mesh_faults.h"
#include "tests/support/mesh_bytes.h"

namespace hpdm {
namespace {

constexpr PlyEncoding kText = PlyEncoding::kText, kLittle = PlyEncoding::kLittleEndian,
                      kBig = PlyEncoding::kBigEndian;

/// The text with the first `from` in it replaced.
/// Replaces a random coordinate in a file of either byte order.
std::string WithNumber(PlyEncoding encoding, float number, MeshFaults* faults) {
  const SurfaceMesh body = SoundBody();
  const std::size_t struck = PlyHeader(encoding, body).size() + 4 * faults->Draw(3 * 42);
  return PlyBytes(encoding, body).replace(struck, 4, Raw(number, encoding == kBig));
}

/// Replaces a corner of a triangle in a file of either byte order.
std::string WithIndex(PlyEncoding encoding, std::int32_t index, MeshFaults* faults) {
  const SurfaceMesh body = SoundBody();
  const std::size_t struck =
      PlyHeader(encoding, body).size() + 12 * 42 + 13 * faults->Draw(80) + 1 + 4 * faults->Draw(3);
  return PlyBytes(encoding, body).replace(struck, 4, Raw(index, encoding == kBig));
}

void AddHeaders(MeshFaults* faults) {
  const std::string text = PlyBytes(kText, SoundBody());
  faults->Add("header_cut_off.ply", text.substr(0, text.find("property")));
  faults->Add("header_alone.ply", PlyHeader(kText, SoundBody()));
  faults->Add("header_of_one_word.ply", "ply");
  for (const auto& [name, from, to] : std::initializer_list<std::array<const char*, 3>>{
           {"without_format", "format ascii 1.0\n", ""},
           {"of_an_unknown_format", "ascii", "binary_middle_endian"},
           {"with_an_unknown_word", "element vertex", "vertices 42\nelement vertex"},
           {"with_an_unknown_type", "float y", "real y"},
           {"without_x", "property float x\n", ""},
           {"with_x_twice", "float x\n", "float x\nproperty float x\n"},
           {"with_a_list_of_x", "float x", "list uchar float x"},
           {"with_indices_of_float", "uchar int", "uchar float"},
           {"with_a_count_of_float", "uchar int", "float int"},
           {"without_indices", "property list uchar int vertex_indices\n", ""},
           {"with_one_index_alone", "list uchar int", "int"},
           {"with_a_property_first", "element vertex", "property float x\nelement vertex"},
           {"with_vertices_twice", "element face",
            "element vertex 3\nproperty int x\nelement face"},
           {"without_faces", "element face", "element facet"},
           {"with_a_count_of_minus_one", "face 80", "face -1"},
           {"with_a_count_of_3.5e17_vertices", "vertex 42", "vertex 353535235358353535"},
           {"with_a_count_of_ten_million_vertices", "vertex 42", "vertex 10000001"},
           {"with_a_count_of_nine_million_faces", "face 80", "face 9000000"},
           {"with_a_count_beyond_64_bits", "face 80", "face 99999999999999999999"},
           {"with_a_count_of_nothing", "face 80", "face"},
           {"with_too_few_vertices", "vertex 42", "vertex 41"},
           {"with_too_few_faces", "face 80", "face 79"},
           {"with_too_many_faces", "face 80", "face 81"}}) {
    faults->Add(std::string("header_") + name + ".ply", Replaced(text, from, to));
  }
  faults->Add("header_with_a_zero_byte.ply", Replaced(text, "vertex", std::string("ver\0tex", 7)));
  faults->Add(
      "header_with_an_element_of_9e18_nothings.ply",
      Replaced(text, "element vertex", "element nothing 9000000000000000000\nelement vertex"));

  // The file has as many elements as vertices: work for each pair would take hours.
  std::string elements, origins;
  for (int i = 0; i < 200'000; ++i) elements += "element e 0\n", origins += "0 0 0\n";
  faults->Add("header_of_many_elements.ply",
              elements.insert(0, "ply\nformat ascii 1.0\n") +
                  "element vertex 200000\nproperty float x\nproperty float y\nproperty float z\n"
                  "element face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                  origins + "3 0 1 2\n");
}

void AddBodies(MeshFaults* faults) {
  const SurfaceMesh body = SoundBody();
  for (const auto& [encoding, name] : std::initializer_list<std::pair<PlyEncoding, std::string>>{
           {kText, "text"}, {kLittle, "little_endian"}, {kBig, "big_endian"}}) {
    const std::string bytes = PlyBytes(encoding, body);
    faults->Add("sound_" + name + ".ply", bytes);
    faults->Add("cut_off_" + name + ".ply", bytes.substr(0, bytes.size() - 6));
    faults->Add("trailing_bytes_" + name + ".ply", bytes + "0 1 2 3 4 5 6 7 8 9");
  }
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  faults->Add("nan_little_endian.ply", WithNumber(kLittle, nan, faults));
  faults->Add("nan_big_endian.ply", WithNumber(kBig, nan, faults));
  faults->Add("infinity_little_endian.ply", WithNumber(kLittle, -infinity, faults));
  faults->Add("index_minus_one_big_endian.ply", WithIndex(kBig, -1, faults));
  faults->Add("index_beyond_the_last_little_endian.ply", WithIndex(kLittle, 42, faults));
  faults->Add("index_of_the_other_byte_order.ply", WithIndex(kLittle, 1 << 24, faults));
  faults->Add("the_other_byte_order.ply", PlyHeader(kLittle, body) + PlyBody(kBig, body));
  faults->Add("text_that_claims_to_be_binary.ply", PlyHeader(kLittle, body) + PlyBody(kText, body));
  faults->Add("binary_that_claims_to_be_text.ply", PlyHeader(kText, body) + PlyBody(kBig, body));
  faults->Add("a_double_beyond_a_float.ply",
              Replaced(PlyHeader(kLittle, "1", "1"), "float z", "double z") + Raw(0.f) + Raw(0.f) +
                  Raw(1e300) + '\3' + std::string(12, '\0'));

  const std::string text = PlyBytes(kText, body);
  faults->Add("a_decimal_comma.ply", Replaced(text, "0.0", "0,0"));
  faults->Add("an_index_with_a_fraction.ply", text.substr(0, text.size() - 1) + ".5\n");
  faults->Add("all_values_on_one_line.ply", [&] {
    std::string values = PlyBody(kText, body);
    std::replace(values.begin(), values.end(), '\n', ' ');
    return PlyHeader(kText, body) + values;
  }());
  faults->Add("dos_line_ends.ply", [&] {
    std::string ends;
    for (const char c : text) ends += c == '\n' ? std::string("\r\n") : std::string(1, c);
    return ends;
  }());
  faults->Add("byte_order_mark.ply", "\xef\xbb\xbf" + text);
  const auto face = [&](const std::string& face_bytes) {
    return PlyHeader(kLittle, "3", "1") + Raw(0.f) + Raw(0.f) + Raw(0.f) + Raw(.1f) + Raw(0.f) +
           Raw(0.f) + Raw(0.f) + Raw(.1f) + Raw(0.f) + face_bytes;
  };
  faults->Add("a_face_of_two_corners.ply", face('\2' + std::string(8, '\0')));
  faults->Add("a_face_of_no_corners.ply", face(std::string(1, '\0')));
  faults->Add("a_face_longer_than_the_file.ply", face('\xff' + std::string(12, '\0')));
  faults->Add("a_face_of_minus_one_corners.ply",
              Replaced(face('\xff' + std::string(12, '\0')), "uchar", "char"));
  faults->Add("faces_before_vertices.ply",
              "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\n"
              "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
              "3 0 1 2\n0 0 0\n.1 0 0\n0 .1 0\n");
}

}  // namespace

void AddPlyFaults(MeshFaults* faults) {
  AddHeaders(faults);
  AddBodies(faults);
}

}  // namespace hpdm
