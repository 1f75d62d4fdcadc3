#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/bad_input/meshes/mesh_faults.h"
#include "tests/support/mesh_bytes.h"

namespace hpdm {
namespace {

/// Replaces one number of a random vertex line.
std::string WithNumber(const std::string& number, MeshFaults* faults) {
  const SurfaceMesh body = SoundBody();
  const auto struck = static_cast<Eigen::Index>(faults->Draw(42));
  return ObjVertices(body.vertices.topRows(struck)) + "v 0.01 " + number + " 0.02\n" +
         ObjText(body).substr(ObjVertices(body.vertices.topRows(struck + 1)).size());
}

/// Returns the sound body with one more line.
std::string WithLine(const std::string& line) { return ObjText(SoundBody()) + line + '\n'; }

std::string WithLineEnds(std::string text, const std::string& end) {
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += end.size()) {
    text.replace(at, 1, end);
  }
  return text;
}

/// Converts to UTF-16 with its byte-order mark.
std::string Utf16(const std::string& text, bool big) {
  std::string wide = big ? "\xfe\xff" : "\xff\xfe";
  for (const char c : text) wide += big ? std::string{'\0', c} : std::string{c, '\0'};
  return wide;
}

/// Returns a prism over an outline (corner by corner): one OBJ face at each end, and
/// quadrilaterals.
std::string Prism(const std::vector<Eigen::Vector2d>& outline) {
  const std::size_t n = outline.size();
  std::string text, bottom = "f", top = "f", sides;
  for (const double z : {0.0, 0.05}) {
    for (const Eigen::Vector2d& p : outline) {
      text += "v " + PointText(Eigen::RowVector3d(p.x(), p.y(), z)) + '\n';
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t next = (i + 1) % n;
    bottom += ' ' + std::to_string(n - i);
    top += ' ' + std::to_string(n + i + 1);
    sides += "f " + std::to_string(i + 1) + ' ' + std::to_string(next + 1) + ' ' +
             std::to_string(n + next + 1) + ' ' + std::to_string(n + i + 1) + '\n';
  }
  return text + bottom + '\n' + top + '\n' + sides;
}

/// Returns points on a circle, each `step` of n further, every other one nearer by `inner`.
std::vector<Eigen::Vector2d> Star(int n, int step, double inner) {
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i < n; ++i) {
    const double u = 2 * std::numbers::pi * (i * step % n) / n;
    const double r = 0.05 * (i % 2 == 0 ? 1 : inner);
    outline.emplace_back(r * std::cos(u), r * std::sin(u));
  }
  return outline;
}

void AddNumbers(MeshFaults* faults) {
  for (const auto& [name, number] :
       std::initializer_list<std::pair<const char*, const char*>>{{"nan", "nan"},
                                                                  {"inf", "inf"},
                                                                  {"minus_infinity", "-INF"},
                                                                  {"beyond_a_float", "1e39"},
                                                                  {"beyond_a_double", "1e999"},
                                                                  {"denormal", "1e-310"},
                                                                  {"below_a_double", "1e-999"},
                                                                  {"decimal_comma", "0,01"},
                                                                  {"two_points", "0.0.1"},
                                                                  {"hexadecimal", "0x1p-3"},
                                                                  {"exponent_cut_off", "1e"},
                                                                  {"a_word", "north"},
                                                                  {"missing", ""}}) {
    faults->Add(std::string("number_") + name + ".obj", WithNumber(number, faults));
  }
  faults->Add("number_of_a_thousand_digits.obj",
              WithNumber("0.0" + std::string(1000, '3'), faults));
}

void AddIndices(MeshFaults* faults) {
  for (const auto& [name, line] : std::initializer_list<std::pair<const char*, const char*>>{
           {"zero", "f 1 0 2"},
           {"negative_beyond_the_first", "f 1 -43 2"},
           {"beyond_the_last", "f 1 43 2"},
           {"beyond_64_bits", "f 1 18446744073709551617 2"},
           {"with_a_fraction", "f 1 2.5 3"},
           {"a_word", "f one two three"},
           {"of_no_texture", "f 1/1 2/2 3/3"},
           {"slash_alone", "f 1 / 3"},
           {"in_a_face_of_two", "f 1 2"},
           {"in_a_face_of_none", "f"}}) {
    faults->Add(std::string("index_") + name + ".obj", WithLine(line));
  }
}

void AddPolygons(MeshFaults* faults) {
  const std::string corners =
      "v 0 0 0\nv .1 0 0\nv .1 .1 0\nv 0 .1 0\nv 0 0 .1\nv .1 0 .1\n"
      "v .1 .1 .1\nv 0 .1 .1\n";
  faults->Add("quadrilaterals.obj", corners +
                                        "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\n"
                                        "f 3 4 8 7\nf 4 1 5 8\n");
  faults->Add("mixed_polygons.obj", corners +
                                        "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7\nf 2 7 6\n"
                                        "f 3 4 8 7\nf 4 1 5\nf 4 5 8\n");
  faults->Add("a_quadrilateral_that_is_not_flat.obj",
              corners +
                  "v .05 .05 .2\nf 4 3 2 1\nf 5 6 9 8\nf 6 7 9\nf 7 8 9\nf 1 2 6 5\n"
                  "f 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  faults->Add("a_bow_tie.obj", corners +
                                   "f 4 3 2 1\nf 5 7 6 8\nf 1 2 6 5\nf 2 3 7 6\n"
                                   "f 3 4 8 7\nf 4 1 5 8\n");
  faults->Add("a_corner_twice_in_a_polygon.obj",
              corners + "f 4 3 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  faults->Add("a_polygon_at_one_place.obj", WithLine("f 7 7 7 7 7"));
  faults->Add("a_polygon_on_a_line.obj",
              WithLine("v 0 0 .1\nv 0 0 .2\nv 0 0 .3\nv 0 0 .4\nf -4 -3 -2 -1"));
  faults->Add("a_concave_polygon.obj", Prism(Star(12, 1, 0.3)));
  faults->Add("a_polygon_that_crosses_itself.obj", Prism(Star(5, 2, 1)));
  faults->Add("a_polygon_of_256_corners.obj", Prism(Star(256, 1, 1)));
  faults->Add("a_polygon_of_257_corners.obj", Prism(Star(257, 1, 1)));

  // Each polygon crosses itself as often as possible, so that no corner is an ear.
  std::string wild;
  for (int i = 0; i < 256; ++i) {
    wild += "v " + PointText(faults->DrawPoint().transpose()) + '\n';
  }
  for (int f = 0; f < 20; ++f) {
    wild += 'f';
    for (int i = 0; i < 256; ++i) wild += ' ' + std::to_string(1 + faults->Draw(256));
    wild += '\n';
  }
  faults->Add("twenty_wild_polygons.obj", wild);
}

void AddTexts(MeshFaults* faults) {
  const std::string text = ObjText(SoundBody());
  faults->Add("sound.obj", text);
  faults->Add("dos_line_ends.obj", WithLineEnds(text, "\r\n"));
  faults->Add("old_mac_line_ends.obj", WithLineEnds(text, "\r"));
  faults->Add("no_final_line_end.obj", text.substr(0, text.size() - 1));
  faults->Add("every_line_continued.obj", WithLineEnds(text, "\n\\\n\\\r\n\n"));
  faults->Add("continued_into_nothing.obj", text + "f 1 2 3\\");
  faults->Add("byte_order_mark.obj", "\xef\xbb\xbf" + text);
  faults->Add("utf16_little_endian.obj", Utf16(text, false));
  faults->Add("utf16_big_endian.obj", Utf16(text, true));
  faults->Add("zero_bytes_at_the_start.obj", std::string(16, '\0') + text);
  faults->Add("zero_bytes_at_the_end.obj", text + std::string(5000, '\0'));
  faults->Add("a_zero_byte_in_a_number.obj", WithNumber(std::string("0.0\0001", 5), faults));
  faults->Add("a_line_of_a_megabyte.obj", "# " + std::string(1 << 20, '-') + '\n' + text);
  faults->Add("blanks_of_a_megabyte.obj", "v" + std::string(1 << 20, ' ') + text.substr(1));
  faults->Add("cut_off_among_the_vertices.obj", text.substr(0, text.rfind("\nv ") + 3));
  faults->Add("cut_off_in_a_face.obj", text.substr(0, text.rfind(' ')));
  faults->Add("cut_off_between_faces.obj", text.substr(0, text.rfind('f')));
  faults->Add("points_only.obj", ObjVertices(SoundBody().vertices) + "p 1 2 3\n");
  faults->Add("lines_only.obj", ObjVertices(SoundBody().vertices) + "l 1 2 3\nl 4 5\n");
  faults->Add("faces_only.obj", "f 1 2 3\nf 3 2 1\n");
  faults->Add("curves_only.obj",
              "v 0 0 0\nv 1 0 0\nv 1 1 0\ncstype bezier\ndeg 2\ncurv 0 1 1 2 3\n"
              "parm u 0 1\nend\n");
}

}  // namespace

void AddObjFaults(MeshFaults* faults) {
  AddNumbers(faults);
  AddIndices(faults);
  AddPolygons(faults);
  AddTexts(faults);
}

}  // namespace hpdm
