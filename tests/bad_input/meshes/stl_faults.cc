#include <cctype>
#include <limits>

#include "tests/bad_input/meshes/mesh_faults.h"
#include "tests/support/mesh_bytes.h"

namespace hpdm {
namespace {

void AddStlTexts(MeshFaults* faults) {
  const std::string text = StlText(SoundBody());
  faults->Add("sound_text.stl", text);
  std::string shouted = text;
  for (char& c : shouted) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  faults->Add("upper_case.stl", shouted);
  std::string blanks = text;
  for (char& c : blanks) c = c == '\n' ? '\r' : c;
  faults->Add("old_mac_line_ends.stl", blanks);
  faults->Add("byte_order_mark.stl", "\xef\xbb\xbf" + text);
  std::string wide = "\xff\xfe";
  for (const char c : text) wide += {c, '\0'};
  faults->Add("utf16.stl", wide);
  faults->Add("cut_off_text.stl", text.substr(0, text.rfind("vertex") + 6));
  faults->Add("solid_without_end.stl", text.substr(0, text.size() - 14));
  faults->Add("solid_without_facets.stl", "solid\nendsolid\n");
  faults->Add("prose.stl", "solid ground is what this is\n");
  for (const auto& [name, from, to] : std::initializer_list<std::array<const char*, 3>>{
           {"facet_after_the_solid", "facet", "endsolid\nfacet"},
           {"facet_with_normals_of_nan", "normal 0 0 0", "normal nan -nan(ind) 1e999"},
           {"facet_without_normal", "normal 0 0 0", ""},
           {"facet_without_loop", "outer loop\n", ""},
           {"facet_of_four_corners", "endloop", "vertex 0 0 0\nendloop"},
           {"facet_of_two_corners", "vertex", "endloop\nvertex"},
           {"facet_with_nan", "vertex ", "vertex nan "},
           {"facet_with_a_decimal_comma", "vertex 0.", "vertex 0,"},
           {"facet_with_a_long_word", "endloop",
            "endlooooooooooooooooooooooooooooooooooooooooooooooooooooooooooooooooooooooooooooooooo"
            "p"},
           {"facet_with_a_control_character", "endloop", "endl\1op"}}) {
    faults->Add(std::string(name) + ".stl", Replaced(text, from, to));
  }
}

void AddBinaries(MeshFaults* faults) {
  const SurfaceMesh body = SoundBody();
  const std::string bytes = StlBytes(body);
  faults->Add("sound_binary.stl", bytes);
  faults->Add("header_cut_off.stl", bytes.substr(0, 50));
  faults->Add("header_without_facets.stl", bytes.substr(0, 84));
  faults->Add("cut_off_binary.stl", bytes.substr(0, bytes.size() - 1));
  faults->Add("count_of_zero.stl", StlBytes(body, 0));
  faults->Add("count_too_large.stl", StlBytes(body, 81));
  faults->Add("count_of_four_thousand_million.stl", StlBytes(body, 4'000'000'000u));
  faults->Add("count_too_small.stl", StlBytes(body, 79));
  faults->Add("trailing_bytes.stl", bytes + "trailing");
  const auto with = [&](float number) {
    return std::string(bytes).replace(84 + 50 * faults->Draw(80) + 12 + 4 * faults->Draw(9), 4,
                                      Raw(number));
  };
  faults->Add("nan_binary.stl", with(std::numeric_limits<float>::quiet_NaN()));
  faults->Add("infinity_binary.stl", with(std::numeric_limits<float>::infinity()));
  faults->Add("a_corner_at_the_largest_float.stl", with(std::numeric_limits<float>::max()));
  faults->Add("a_corner_at_a_denormal.stl", with(std::numeric_limits<float>::denorm_min()));
}

}  // namespace

void AddStlFaults(MeshFaults* faults) {
  AddStlTexts(faults);
  AddBinaries(faults);
}

}  // namespace hpdm
