#include "engine/tissue/tissue_cache.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/read_file.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

/// An ellipsoid in a box of its own, few samples: a hundredth of a second.
struct Body {
  SurfaceMesh mesh = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2);
  OrientedBox box{Vector3d(-0.12, -0.09, -0.07), Matrix3d::Identity(), Vector3d(0.24, 0.18, 0.14)};
  std::array<int, 3> cells = {3, 2, 2};
  InteriorOptions options{.resolution = 16};
};

/// Two blocks 30 mm apart in the same box, in a cell that both reach into.
Body TwoPieces() {
  Body body;
  body.mesh = Joined(MakeBox({-0.1, -0.07, -0.05}, {-0.015, 0.07, 0.05}),
                     MakeBox({0.015, -0.07, -0.05}, {0.1, 0.07, 0.05}));
  body.options.support_cells = {1, 1, 1};
  return body;
}

void ExpectSameBits(const TissueQuadrature& a, const TissueQuadrature& b) {
  EXPECT_TRUE(a.points == b.points);
  EXPECT_TRUE(a.weights == b.weights);
  EXPECT_TRUE(a.cells == b.cells);
  EXPECT_TRUE(a.cell_volumes == b.cell_volumes);
  const TissuePieces::Data &p = a.pieces.data(), &q = b.pieces.data();
  EXPECT_TRUE(p.cells == q.cells && p.side == q.side && p.first == q.first &&
              p.volumes == q.volumes && p.pairs == q.pairs && p.map == q.map);
}

class TissueCache : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "hpdm_cache_XXXXXX";
    folder_ = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  TissueQuadrature Cached(const Body& body) const {
    return CachedTissue(body.mesh, body.box, body.cells, body.options, Folder());
  }
  static TissueQuadrature Sampled(const Body& body) {
    return SampleTissue(body.mesh, body.box, body.cells, body.options);
  }
  /// A folder that does not exist before the first use.
  fs::path Folder() const { return folder_ / "deeper" / "hpdm"; }
  std::vector<fs::path> Files() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(Folder())) files.push_back(entry.path());
    return files;
  }
  /// Identifies a file: a replacement has another identity, because every write makes a new file.
  static ino_t Inode(const fs::path& path) {
    struct stat status {};
    EXPECT_EQ(stat(path.c_str(), &status), 0);
    return status.st_ino;
  }

  fs::path folder_;
};

TEST_F(TissueCache, GivesTheSamplersBitsAndReadsThemTheSecondTime) {
  const Body body;
  const TissueQuadrature sampled = Sampled(body);
  ExpectSameBits(Cached(body), sampled);
  ASSERT_EQ(Files().size(), 1u);  // and nothing temporary beside it
  const fs::path file = Files()[0];
  const ino_t written = Inode(file);
  const auto long_ago = fs::file_time_type::clock::now() - std::chrono::hours(24);
  fs::last_write_time(file, long_ago);
  ExpectSameBits(Cached(body), sampled);
  EXPECT_EQ(Inode(file), written);
  EXPECT_GT(fs::last_write_time(file), long_ago) << "the use was not noted";
}

TEST_F(TissueCache, EveryInputThatDecidesTheResultHasItsOwnFile) {
  std::vector<Body> bodies(8);
  double& x = bodies[1].mesh.vertices(0, 0);
  x = std::nextafter(x, 1);
  bodies[2].mesh.triangles.row(0).swap(bodies[2].mesh.triangles.row(1));
  bodies[3].box.lengths[2] = std::nextafter(bodies[3].box.lengths[2], 1);
  bodies[4].cells = {2, 3, 2};
  bodies[5].options.resolution = 17;
  bodies[6].options.moment_degree = 2;
  bodies[7].options.support_cells = {2, 2, 2};
  for (const Body& body : bodies) ExpectSameBits(Cached(body), Sampled(body));
  EXPECT_EQ(Files().size(), bodies.size());
}

TEST_F(TissueCache, KeepsThePiecesOfTissue) {
  const Body body = TwoPieces();
  const TissueQuadrature sampled = Sampled(body);
  EXPECT_FALSE(sampled.pieces.data().map.empty());
  ExpectSameBits(Cached(body), sampled);
  ExpectSameBits(Cached(body), sampled);
}

TEST_F(TissueCache, KeepsTissueWithCutsAndTellsCutsApart) {
  Body body;
  body.options.support_cells = {1, 1, 1};
  for (const double end : {0.0, 0.01}) {
    const CutOptions strip{
        "body", 0, {{{0, -0.1, end}, {0, -0.1, 0.1}}, {{0, 0.1, end}, {0, 0.1, 0.1}}}};
    const CutSurfaces cuts = std::make_shared<const std::vector<CutSurface>>(
        std::vector<CutSurface>{CutSurface(body.box, strip, body.mesh)});
    body.options.cuts = cuts;
    const TissueQuadrature sampled = Sampled(body);
    ExpectSameBits(Cached(body), sampled);
    const TissueQuadrature read = Cached(body);
    ExpectSameBits(read, sampled);
    EXPECT_EQ(read.pieces.cuts(), cuts);
  }
  EXPECT_EQ(Files().size(), 2u);
}

TEST_F(TissueCache, DamagedFilesAreReplaced) {
  const Body body = TwoPieces();
  const TissueQuadrature sampled = Cached(body);
  const fs::path file = Files().at(0);
  const std::string good = ReadFile(file);
  std::map<std::string, std::string> damaged = {{"empty", ""},
                                                {"half", good.substr(0, good.size() / 2)},
                                                {"one byte short", good.substr(0, good.size() - 1)},
                                                {"one byte long", good + '\0'},
                                                {"zeros", std::string(good.size(), '\0')},
                                                {"text", "not found"}};
  // Magic, key, contents, all sizes (their top byte: a petabyte), then the arrays.
  for (const std::size_t at : {0, 8, 24, 40, 47, 48, 55, 56, 63, 64, 71, 72, 80, 87, 100, 2000}) {
    std::string flipped = good;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x40);
    damaged["byte " + std::to_string(at)] = flipped;
  }
  damaged["last byte"] = good;
  damaged["last byte"].back() ^= 1;
  for (const auto& [what, bytes] : damaged) {
    SCOPED_TRACE(what);
    std::ofstream(file, std::ios::binary) << bytes;
    ExpectSameBits(Cached(body), sampled);
    EXPECT_EQ(ReadFile(file), good);
  }
}

TEST_F(TissueCache, AFileUnderAnothersNameIsReplaced) {
  const Body body;
  Cached(body);
  const fs::path first = Files().at(0);
  Body other;
  other.mesh.vertices *= 0.9;
  const TissueQuadrature sampled = Cached(other);
  const std::vector<fs::path> files = Files();
  const fs::path second = files[0] == first ? files[1] : files[0];
  fs::copy_file(first, second, fs::copy_options::overwrite_existing);
  ExpectSameBits(Cached(other), sampled);
}

TEST_F(TissueCache, WithoutAFolderToWriteToNothingIsKeptAndNothingFails) {
  const Body body;
  const TissueQuadrature sampled = Sampled(body);
  std::ofstream(folder_ / "file") << "no folder";
  for (const fs::path& folder : {fs::path(), folder_ / "file" / "hpdm", fs::path("/proc/hpdm")}) {
    ExpectSameBits(CachedTissue(body.mesh, body.box, body.cells, body.options, folder), sampled);
  }
}

TEST_F(TissueCache, FaultsAreTheSamplersOwnAndAreNotKept) {
  Body body;
  body.mesh.vertices.col(0).array() += 1;  // outside the box
  EXPECT_THROW(Cached(body), InputError);
  EXPECT_THROW(Cached(body), InputError);
  EXPECT_FALSE(fs::exists(Folder()));
}

TEST_F(TissueCache, TheLeastRecentlyUsedFilesAreRemoved) {
  const auto now = fs::file_time_type::clock::now();
  fs::create_directories(Folder());
  int hours = 3;
  for (const char* name : {"old.tissue", "newer.tissue", "foreign.txt"}) {
    std::ofstream(Folder() / name) << "x";
    fs::resize_file(Folder() / name, std::uintmax_t{200} << 20);  // sparse: takes no room
    fs::last_write_time(Folder() / name, now - std::chrono::hours(hours--));
  }
  Cached(Body());
  EXPECT_FALSE(fs::exists(Folder() / "old.tissue"));
  EXPECT_TRUE(fs::exists(Folder() / "newer.tissue"));
  EXPECT_TRUE(fs::exists(Folder() / "foreign.txt"));
  EXPECT_EQ(Files().size(), 3u);
}

TEST_F(TissueCache, FolderFollowsTheEnvironment) {
  const auto folder = [](const char* chosen, const char* cache, const char* home) {
    setenv("HPDM_CACHE", chosen, 1);
    setenv("XDG_CACHE_HOME", cache, 1);
    setenv("HOME", home, 1);
    return TissueCacheFolder();
  };
  EXPECT_EQ(folder("", "", "/home/a"), "/home/a/.cache/hpdm");
  EXPECT_EQ(folder("", "/var/a", "/home/a"), "/var/a/hpdm");
  EXPECT_EQ(folder("", "relative", "/home/a"), "/home/a/.cache/hpdm");
  EXPECT_EQ(folder("/tmp/b", "/var/a", "/home/a"), "/tmp/b");
  EXPECT_EQ(folder("off", "/var/a", "/home/a"), "");
  EXPECT_EQ(folder("", "", ""), "");
  for (const char* name : {"HPDM_CACHE", "XDG_CACHE_HOME", "HOME"}) unsetenv(name);
  EXPECT_EQ(TissueCacheFolder(), "");
}

}  // namespace
}  // namespace hpdm
