#include "engine/mesh/files/mesh_import.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <locale>
#include <map>
#include <sstream>

#include "engine/base/error.h"
#include "engine/mesh/files/mesh_file.h"
#include "tests/bad_input/meshes/mesh_faults.h"
#include "tests/support/mesh_bytes.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

std::string Write(const std::string& name, const std::string& content) {
  const std::string folder = testing::TempDir() + "mesh_import_test/";
  std::filesystem::create_directories(folder);
  std::ofstream(folder + name, std::ios::binary) << content;
  return folder + name;
}

ImportedMesh Import(const std::string& name, const std::string& content, double unit = 1) {
  return ImportMesh(Write(name, content), unit);
}

const char kCubeObj[] =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

void ExpectUnitCube(const ImportedMesh& imported, double side = 1) {
  const MeshFacts facts = ComputeMeshFacts(imported.mesh);
  EXPECT_EQ(facts.vertices, 8);
  EXPECT_EQ(facts.triangles, 12);
  EXPECT_TRUE(facts.Closed());
  EXPECT_EQ(facts.inconsistent_edges, 0);
  // Coordinates are 0 and 1 exactly; the unit is one rounding.
  EXPECT_NEAR(facts.volume_m3, side * side * side, 1e-14 * side * side * side);
}

TEST(MeshImport, QuadrilateralsOfAnObjBecomeTrianglesInMetres) {
  const ImportedMesh cube = Import("cube.obj", kCubeObj, 1e-3);
  ExpectUnitCube(cube, 1e-3);
  EXPECT_TRUE(cube.repairs.List().empty());
}

TEST(MeshImport, ObjIndicesMayCountBackAndLinesMayContinue) {
  ExpectUnitCube(Import("negative.OBJ",
                        "mtllib C:\\no\\such.mtl\n# path C:\\\nv +0 .0 0. 1\nv 1e0 0 0\nv 1 1 "
                        "0\r\nv 0 1 0\rv 0 0 \\\n1\nv 1 0 1 0.5 0.5 0.5\nv 1 1 1\nv 0 1 1\n"
                        "l 1 2\np 3\nusemtl tissue\ng part\n"
                        "f -5 -6 -7 -8\nf 5//1 6//1 7//1 8//1\nf 1 2\\\n 6 5\nf 2 3 7 6 # side\n"
                        "o other\nf 3 4 8 7\nf 4 1 5 8"));
}

TEST(MeshImport, TextureSeamsNeitherCutTheSurfaceNorGetLost) {
  const ImportedMesh cube =
      Import("textured.obj",
             "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
             "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
             "f 4/1 3/2 2/3 1/4\nf 5/1 6/2 7/3 8/4\nf 1/1 2/2 6/3 5/4\nf 2/1 3/2 7/3 6/4\n"
             "f 3/1 4/2 8/3 7/4\nf 4/1 1/2 5/3 8/4\n");
  ExpectUnitCube(cube);
  EXPECT_TRUE(cube.repairs.List().empty());
  ASSERT_EQ(cube.mesh.texture_coordinates.rows(), 36);
  // Each side shows the whole picture once: the two triangles of a square cover it.
  for (Eigen::Index side = 0; side < 6; ++side) {
    double area = 0;
    for (const Eigen::Index t : {2 * side, 2 * side + 1}) {
      const auto uv = cube.mesh.texture_coordinates.middleRows<3>(3 * t);
      const Eigen::RowVector2d a = uv.row(1) - uv.row(0), b = uv.row(2) - uv.row(0);
      area += (a.x() * b.y() - a.y() * b.x()) / 2;
    }
    EXPECT_EQ(area, 1) << "side " << side;
  }
}

/// An OBJ text's lines that begin with `keyword` and a space.
std::vector<std::string> LinesOf(const std::string& text, const std::string& keyword) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(keyword + " ", 0) == 0) lines.push_back(line);
  }
  return lines;
}

// Stored references and logs count on the order.
TEST(MeshImport, TheCommittedMeshesKeepTheOrderOfTheirFacesWhateverTheirTextureCoordinates) {
  for (const auto& entry : std::filesystem::directory_iterator(HPDM_SOURCE_DIR "/scenes/meshes")) {
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    std::string bare, all_seams;  // no texture coordinates; other ones at every corner
    for (const std::string& line : LinesOf(text, "v")) bare += line + '\n';
    all_seams = bare;
    std::string faces;
    Triangles expected(LinesOf(text, "f").size(), 3);
    std::map<int, int> number;  // in the order in which the faces name the vertices
    int t = 0;
    for (const std::string& line : LinesOf(text, "f")) {
      std::istringstream in(line.substr(1));
      bare += 'f';
      faces += 'f';
      int c = 0;
      for (std::string corner; in >> corner; ++c) {
        const int v = std::stoi(corner);
        expected(t, c) = number.try_emplace(v, static_cast<int>(number.size())).first->second;
        bare += ' ' + std::to_string(v);
        faces += ' ' + std::to_string(v) + '/' + std::to_string(3 * t + c + 1);
        all_seams += "vt " + std::to_string(3 * t + c) + " 0.5\n";
      }
      bare += '\n';
      faces += '\n';
      ++t;
    }
    const SurfaceMesh committed = ImportMesh(entry.path().string(), 1).mesh;
    const SurfaceMesh without = Import("bare.obj", bare).mesh;
    const SurfaceMesh with = Import("all_seams.obj", all_seams + faces).mesh;
    EXPECT_EQ(committed.triangles, expected) << entry.path();
    EXPECT_EQ(without.triangles, expected) << entry.path();
    EXPECT_EQ(with.triangles, expected) << entry.path();
    EXPECT_EQ(committed.vertices, without.vertices) << entry.path();
    EXPECT_EQ(committed.vertices, with.vertices) << entry.path();
    EXPECT_EQ(without.texture_coordinates.rows(), 0);
    ASSERT_EQ(with.texture_coordinates.rows(), 3 * t);
    for (int row = 0; row < 3 * t; ++row) EXPECT_EQ(with.texture_coordinates(row, 0), row);
  }
}

TEST(MeshImport, EveryEncodingGivesTheSameCube) {
  const SurfaceMesh box = MakeBox(Vector3d::Zero(), Vector3d::Ones());
  ExpectUnitCube(Import("binary.stl", StlBytes(box)));
  ExpectUnitCube(Import("trailing.stl", StlBytes(box) + "trailing bytes"));

  std::string text = "solid a\\\n";
  for (Eigen::Index t = 0; t < 12; ++t) {
    text += "FACET NORMAL nan -nan(ind) 1\n outer loop\n";
    for (int c = 0; c < 3; ++c) {
      const Eigen::RowVector3d p = box.vertices.row(box.triangles(t, c));
      text += "vertex " + std::to_string(p.x()) + "\t" + std::to_string(p.y()) + " " +
              std::to_string(p.z()) + "\n";
    }
    text += "endloop endfacet\n";
    if (t == 5) text += "endsolid a\nsolid b\n";
  }
  ExpectUnitCube(Import("text.stl", text + "endsolid b\n"));

  const std::string header =
      " 1.0\ncomment c\nobj_info o\nelement note 2\nproperty list uchar short values\n"
      "element vertex 8\nproperty uchar red\nproperty double x\nproperty float y\nproperty short "
      "z\n"
      "element face 12\nproperty int flag\nproperty list uchar uint vertex_indices\nend_header\n";
  std::string ascii = "ply\nformat ascii" + header + "2 7 7\n0\n";
  std::string little = "ply\nformat binary_little_endian" + header,
              big = "ply\nformat binary_big_endian" + header;
  const auto add = [&](auto value) {
    little += Raw(value);
    big += Raw(value, true);
  };
  add(std::uint8_t{2}), add(std::int16_t{7}), add(std::int16_t{7}), add(std::uint8_t{0});
  for (Eigen::Index v = 0; v < 8; ++v) {
    const Eigen::RowVector3d p = box.vertices.row(v);
    add(std::uint8_t{10}), add(p.x()), add(static_cast<float>(p.y()));
    add(static_cast<std::int16_t>(p.z()));
    ascii += "10 " + std::to_string(p.x()) + " " + std::to_string(p.y()) + "\n" +
             std::to_string(static_cast<int>(p.z())) + "\n";
  }
  for (Eigen::Index t = 0; t < 12; ++t) {
    add(std::int32_t{-1}), add(std::uint8_t{3});
    ascii += "-1 3";
    for (int c = 0; c < 3; ++c) {
      add(static_cast<std::uint32_t>(box.triangles(t, c)));
      ascii += ' ';
      ascii += std::to_string(box.triangles(t, c));
    }
    ascii += "\n";
  }
  ExpectUnitCube(Import("ascii.ply", ascii));
  ExpectUnitCube(Import("little.ply", little));
  ExpectUnitCube(Import("big.ply", big));
}

TEST(MeshImport, BinaryPlyMayBeginWithALineFeedAndBeLong) {
  // 0x0A as the lowest byte of the first coordinate; over 1 MB, so that blocks are joined.
  const SurfaceMesh sphere = MakeSphere(6);
  std::string bytes = PlyBytes(PlyEncoding::kLittleEndian, sphere);
  const std::size_t body = PlyHeader(PlyEncoding::kLittleEndian, sphere).size();
  bytes[body] = '\n';
  ASSERT_GT(bytes.size(), std::size_t{1} << 20);
  const ImportedMesh imported = Import("long.ply", bytes);
  const MeshFacts facts = ComputeMeshFacts(imported.mesh);
  EXPECT_EQ(facts.triangles, 81920);
  EXPECT_TRUE(facts.Closed());
  // 32-bit coordinates.
  EXPECT_NEAR(facts.volume_m3, EnclosedVolume(sphere.vertices, sphere.triangles), 1e-5);
}

TEST(MeshImport, ConcavePolygonsAreSplitAtEveryUnit) {
  // An extruded arrow; its area is 2.5, its volume 2.5. A splitter with an absolute tolerance would
  // lose the triangles of the small one.
  const std::string obj =
      "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 .5 0\nv 0 2 0\nv 0 0 1\nv 2 0 1\nv 2 2 1\nv 1 .5 1\nv 0 2 1\n"
      "f 5 4 3 2 1\nf 6 7 8 9 10\nf 1 2 7 6\nf 2 3 8 7\nf 3 4 9 8\nf 4 5 10 9\nf 5 1 6 10\n";
  for (const double unit : {1e-9, 1.0, 1e9}) {
    const MeshFacts facts = ComputeMeshFacts(Import("arrow.obj", obj, unit).mesh);
    EXPECT_TRUE(facts.Closed());
    EXPECT_NEAR(facts.volume_m3 / std::pow(unit, 3), 2.5, 1e-12);  // round-off
  }
}

TEST(MeshImport, CountsRepairsAgainstTheFile) {
  std::string shifted = "v 9 9 9\nv 0 0 1e-8\n";  // the first one is unused
  shifted += std::string(kCubeObj).substr(0, std::string(kCubeObj).find("f "));
  // Vertex 2 repeats vertex 3; the first face is there twice and the second is turned round.
  shifted += "f 6 5 4 3\nf 6 5 4 3\nf 10 9 8 7\nf 2 4 8 7\nf 4 5 9 8\nf 5 6 10 9\nf 6 3 7 10\n";
  const ImportedMesh cube = Import("faults.obj", shifted);
  const MeshFacts facts = ComputeMeshFacts(cube.mesh);
  EXPECT_EQ(facts.vertices, 8);
  EXPECT_TRUE(facts.Closed());
  EXPECT_EQ(cube.repairs.welded_vertices, 1);
  EXPECT_EQ(cube.repairs.unreferenced_vertices, 1);
  EXPECT_EQ(cube.repairs.duplicate_triangles, 2);
  EXPECT_EQ(cube.repairs.reoriented_triangles, 2);
  EXPECT_GT(cube.as_read.boundary_edges, 0);
}

/// Writes 1,5 for 1.5 and 1.000 for 1000.
struct CommaPoint : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(MeshImport, DoesNotDependOnTheLocale) {
  const std::string path = Write("locale.obj", "v 0.5 0 0\nv 1234.5 0 0\nv 0 1.25 0\nf 1 2 3\n");
  const ImportedMesh plain = ImportMesh(path, 1);
  const std::locale before = std::locale::global(std::locale(std::locale(), new CommaPoint));
  const ImportedMesh comma = ImportMesh(path, 1);
  std::locale::global(before);
  EXPECT_EQ(plain.mesh.vertices, comma.mesh.vertices);
  EXPECT_EQ(comma.mesh.vertices(1, 0), 1234.5);
}

TEST(MeshImport, RefusesUnitsThatAreNotPositive) {
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3";
  EXPECT_THROW(Import("unit.obj", triangle, 0), InputError);
  EXPECT_THROW(Import("unit.obj", triangle, std::nan("")), InputError);
  EXPECT_THROW(Import("unit.obj", "v 0 0 0\nv 1e30 0 0\nv 0 1e30 0\nf 1 2 3", 1e300), InputError);
}

void ExpectSound(const SurfaceMesh& mesh) {
  ASSERT_GT(mesh.triangles.rows(), 0);
  EXPECT_TRUE(mesh.vertices.allFinite());
  EXPECT_GE(mesh.triangles.minCoeff(), 0);
  EXPECT_LT(mesh.triangles.maxCoeff(), mesh.vertices.rows());
}

// tests/bad_input/meshes.csv states the result of each one; here they run under the sanitizers.
TEST(MeshImport, EveryFaultIsRefusedInOneLineOrMadeSound) {
  MeshFaults faults(7);
  AddEveryFault(&faults);
  int refused = 0;
  for (const MeshFault& fault : faults.all()) {
    SCOPED_TRACE(fault.file);
    const ScratchFolder folder;
    const std::string path = folder / fault.file;
    fault.make(path);
    try {
      ExpectSound(ImportMesh(path, 1).mesh);
    } catch (const InputError& error) {
      ++refused;
      const std::string line = error.what();
      EXPECT_EQ(line.find('\n'), std::string::npos) << line;
      EXPECT_NE(line.find("; "), std::string::npos) << "no remedy: " << line;
    }
  }
  EXPECT_GT(refused, 60);
}

TEST(MeshImport, TheOrgansBecomeClosedSurfaces) {
  const std::string folder = kDataFolder + "organs/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared data: " << folder;
  for (const auto& [name, unit] :
       std::map<std::string, double>{{"sofa_liver.obj", 0.031},
                                     {"sofa_liver2.obj", 0.093},
                                     {"sofa_liver-smooth.obj", 0.031},
                                     {"sofaenv_gallbladder_collision.stl", 1e-3},
                                     {"sofaenv_gallbladder_visual.stl", 1e-3},
                                     {"sofaenv_liver_collision.stl", 1e-3}}) {
    SCOPED_TRACE(name);
    const ImportedMesh imported = ImportMesh(folder + name, unit);
    ExpectSound(imported.mesh);
    const MeshFacts facts = ComputeMeshFacts(imported.mesh);
    EXPECT_TRUE(facts.Closed());
    EXPECT_EQ(facts.inconsistent_edges, 0);
    EXPECT_EQ(facts.genus, 0);
    EXPECT_GT(facts.volume_m3, 30e-6);  // 30 ml: the smallest is a gallbladder
  }
}

TEST(MeshImport, ADirtyLiverIsReportedAndRepaired) {
  const std::string path = kDataFolder + "organs/sofaenv_liver_collision.stl";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared data: " << path;
  const ImportedMesh liver = ImportMesh(path, 1e-3);
  EXPECT_EQ(liver.as_read.triangles, 479);
  EXPECT_EQ(liver.as_read.boundary_edges, 31);
  EXPECT_EQ(liver.as_read.nonmanifold_edges, 2);
  EXPECT_EQ(liver.as_read.inconsistent_edges, 28);
  EXPECT_EQ(liver.as_read.degenerate_triangles, 1);
  // Its cracks and needles are vertices a tenth of a micrometre apart.
  EXPECT_EQ(liver.repairs.welded_vertices, 99);
  EXPECT_EQ(liver.repairs.degenerate_triangles, 153);
}

}  // namespace
}  // namespace hpdm
