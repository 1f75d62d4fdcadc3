#include <sys/stat.h>

#include <fstream>

#include "tests/bad_input/meshes/mesh_faults.h"
#include "tests/support/mesh_bytes.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kTenMegabytes = 10'000'000;

/// Repeats `part`.
std::string Repeated(const std::string& part, std::size_t size = kTenMegabytes) {
  std::string all;
  all.reserve(size + part.size());
  while (all.size() < size) all += part;
  return all;
}

void AddPlaces(MeshFaults* faults) {
  faults->Add("no_file.obj", [](const fs::path&) {});
  faults->Add("a_folder.obj", [](const fs::path& path) { fs::create_directory(path); });
  faults->Add("a_pipe.ply", [](const fs::path& path) { mkfifo(path.c_str(), 0600); });
  faults->Add("a_device.stl", [](const fs::path& path) { fs::create_symlink("/dev/zero", path); });
  faults->Add("a_link_to_itself.obj", [](const fs::path& path) { fs::create_symlink(path, path); });
  faults->Add("a_link_to_nothing.obj",
              [](const fs::path& path) { fs::create_symlink("/nowhere.obj", path); });
  faults->Add("unreadable.obj", [](const fs::path& path) {
    std::ofstream(path) << ObjText(SoundBody());
    chmod(path.c_str(), 0);
  });
}

void AddKinds(MeshFaults* faults) {
  const SurfaceMesh body = SoundBody();
  const std::string off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  const std::string liar = "OFF\n353535235358353535 1 0\n" + std::string(280, '5') + '\n';
  faults->Add("an_off_file.off", off);
  faults->Add("an_off_file_of_3.5e17_vertices.off", liar);
  for (const char* ending : {".obj", ".ply", ".stl"}) {
    faults->Add(std::string("an_off_file_of_3.5e17_vertices") + ending, liar);
    faults->Add(std::string("nothing") + ending, "");
    faults->Add(std::string("one_byte") + ending, "v");
    faults->Add(std::string("zero_bytes") + ending, std::string(5000, '\0'));
    std::string garbage;
    garbage.reserve(kTenMegabytes);
    while (garbage.size() < kTenMegabytes) garbage += static_cast<char>(faults->Draw(256));
    faults->Add(std::string("ten_megabytes_of_garbage") + ending, garbage);
    for (char& c : garbage) c = static_cast<char>(' ' + (c & 63));
    faults->Add(std::string("ten_megabytes_of_letters") + ending, garbage);
  }
  faults->Add("an_fbx_file.fbx", "Kaydara FBX Binary");
  faults->Add("without_an_ending", ObjText(body));
  faults->Add("an_obj_file.stl", ObjText(body));
  faults->Add("an_obj_file.ply", ObjText(body));
  faults->Add("an_stl_file.obj", StlText(body));
  faults->Add("a_binary_stl_file.ply", StlBytes(body));
  faults->Add("a_ply_file.obj", PlyBytes(PlyEncoding::kText, body));
  faults->Add("a_binary_ply_file.stl", PlyBytes(PlyEncoding::kBigEndian, body));
  faults->Add("Ending In Capitals.OBJ", ObjText(body));
  faults->Add("a\nline\x1b[31m\x7f.obj", "v nan 0 0\n");
}

void AddTenMegabytes(MeshFaults* faults) {
  faults->Add("ten_megabytes_of_vertices.obj", Repeated("v 0 0 0\n"));
  faults->Add("ten_megabytes_of_one_triangle.obj",
              "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + Repeated("f 1 2 3\n"));
  faults->Add("ten_megabytes_of_one_point.obj", "v 0 0 0\n" + Repeated("f 1 1 1\n"));
  faults->Add("ten_megabytes_of_solids.stl", Repeated("solid\nendsolid\n"));
  faults->Add("ten_megabytes_of_zeros.stl",
              StlBytes(SurfaceMesh(), 200'000) + std::string(200'000 * 50, '\0'));
  faults->Add("ten_megabytes_of_elements.ply",
              "ply\nformat ascii 1.0\n" + Repeated("element e 9\n"));
  faults->Add("ten_megabytes_of_properties.ply",
              "ply\nformat ascii 1.0\nelement vertex 3\n" + Repeated("property int x\n"));
}

}  // namespace

void AddFileFaults(MeshFaults* faults) {
  AddPlaces(faults);
  AddKinds(faults);
  AddTenMegabytes(faults);
}

}  // namespace hpdm
