#include <fstream>
#include <locale>
#include <map>
#include <sstream>

#include "engine/base/error.h"
#include "engine/reference_fem/tetra_mesh.h"

namespace hpdm {
namespace {

constexpr int kTetrahedron = 4;      // Gmsh's number of the four-node tetrahedron
constexpr int kMaxNodes = 10000000;  // larger counts are refused

class GmshReader {
 public:
  explicit GmshReader(const std::string& path) : path_(path), file_(path) {
    file_.imbue(std::locale::classic());
    if (!file_) throw InputError(path + ": cannot be opened; check the path and its permissions");
  }

  TetraMesh Read() {
    std::string line;
    while (std::getline(file_, line)) {
      while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
      if (line == "$NOD" || line == "$Nodes") ReadNodes();
      if (line == "$ELM") ReadElements(1);
      if (line == "$Elements") ReadElements(2);
    }
    Tetrahedra elements(static_cast<Eigen::Index>(elements_.size()), 4);
    for (std::size_t e = 0; e < elements_.size(); ++e) {
      for (int k = 0; k < 4; ++k) elements(static_cast<Eigen::Index>(e), k) = elements_[e][k];
    }
    Points nodes(static_cast<Eigen::Index>(nodes_.size()), 3);
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      nodes.row(static_cast<Eigen::Index>(n)) = nodes_[n].transpose();
    }
    return MakeTetraMesh(nodes, elements, path_);
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError(path_ + ": " + what + "; give a Gmsh text file, format 1 or 2");
  }

  int ReadCount() {
    int count = 0;
    if (!(file_ >> count) || count < 0 || count > kMaxNodes) Fail("a count is out of range");
    return count;
  }

  void ReadNodes() {
    const int count = ReadCount();
    for (int i = 0; i < count; ++i) {
      int number = 0;
      Vector3d p;
      if (!(file_ >> number >> p[0] >> p[1] >> p[2])) Fail("the nodes end early");
      index_[number] = static_cast<int>(nodes_.size());
      nodes_.push_back(p);
    }
  }

  void ReadElements(int format) {
    const int count = ReadCount();
    std::string line;
    std::getline(file_, line);
    for (int i = 0; i < count; ++i) {
      if (!std::getline(file_, line)) Fail("the elements end early");
      std::istringstream fields(line);
      int number = 0, type = 0, skipped = 0, tags = 3;
      fields >> number >> type;
      if (type != kTetrahedron) continue;
      // Format 1: two regions and the number of nodes; format 2: a counted list of tags.
      if (format == 2) fields >> tags;
      for (int t = 0; t < tags; ++t) fields >> skipped;
      std::array<int, 4> corners = {};
      for (int& corner : corners) {
        int name = 0;
        fields >> name;
        const auto found = index_.find(name);
        if (!fields || found == index_.end()) Fail("element " + std::to_string(number) + " is bad");
        corner = found->second;
      }
      elements_.push_back(corners);
    }
  }

  std::string path_;
  std::ifstream file_;
  std::vector<Vector3d> nodes_;
  std::map<int, int> index_;
  std::vector<std::array<int, 4>> elements_;
};

}  // namespace

TetraMesh ReadGmsh(const std::string& path) { return GmshReader(path).Read(); }

}  // namespace hpdm
