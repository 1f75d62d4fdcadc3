#include "engine/tissue/tissue_cache.h"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <vector>

namespace hpdm {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kExtension = ".tissue";
constexpr std::uintmax_t kMaxFolderBytes = std::uintmax_t{256} << 20;

/// Digest of two 64-bit chains of splitmix64's finaliser (Steele, Lea, Flood 2014) over the words
/// of the data. Two inputs collide by chance at most once in 2^64 pairs. It does not resist an
/// adversary, who could write to the folder anyway.
class Digest {
 public:
  using Value = std::array<std::uint64_t, 2>;

  void Add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    AddWord(size);
    for (; size > 0;) {
      std::uint64_t word = 0;
      const std::size_t part = std::min(size, sizeof word);
      std::memcpy(&word, bytes, part);
      AddWord(word);
      bytes += part;
      size -= part;
    }
  }

  template <typename Number>
  requires std::is_arithmetic_v<Number>
  void Add(Number number) { Add(&number, sizeof number); }

  template <typename Derived>
  void Add(const Eigen::PlainObjectBase<Derived>& matrix) {
    Add(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(typename Derived::Scalar));
  }

  const Value& value() const { return value_; }

 private:
  static std::uint64_t Mix(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
    x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
    return x ^ (x >> 31);
  }
  void AddWord(std::uint64_t word) {
    value_[0] = Mix(value_[0] ^ word) + 0x9e3779b97f4a7c15;
    value_[1] = Mix(std::rotl(value_[1], 23) + word) ^ 0xd1b54a32d192ed03;
  }

  Value value_ = {0x243f6a8885a308d3, 0x13198a2e03707344};  // digits of pi
};

Digest::Value KeyOf(const SurfaceMesh& mesh, const OrientedBox& box,
                    const std::array<int, 3>& cells, const InteriorOptions& options) {
  Digest key;
  // The same source may round differently under another compiler or instruction set.
  for (const std::string_view maker :
       {std::string_view(HPDM_SAMPLER_SOURCE), std::string_view(__VERSION__),
        std::string_view(Eigen::SimdInstructionSetsInUse())}) {
    key.Add(maker.data(), maker.size());
  }
  key.Add(EIGEN_WORLD_VERSION * 10000 + EIGEN_MAJOR_VERSION * 100 + EIGEN_MINOR_VERSION);
  key.Add(mesh.vertices);
  key.Add(mesh.triangles);
  key.Add(box.origin_W);
  key.Add(box.axes);
  key.Add(box.lengths);
  for (const int count : cells) key.Add(count);
  const auto& [resolution, gauss_points, moment_degree, support_cells, cuts] = options;
  for (const int option : {resolution, gauss_points, moment_degree}) key.Add(option);
  for (const int option : support_cells) key.Add(option);
  for (std::size_t cut = 0; cuts != nullptr && cut < cuts->size(); ++cut) {
    key.Add((*cuts)[cut].triangles().size());
    for (const CutSurface::Triangle& triangle : (*cuts)[cut].triangles()) {
      for (const Vector3d& corner : triangle) key.Add(corner);
    }
  }
  return key.value();
}

/// Header before the arrays, in the machine's byte order, which the magic number shows.
struct Header {
  std::uint64_t magic = 0x3254'4d44'5048'4454;  // identifies this layout
  Digest::Value key = {};
  Digest::Value contents = {};
  std::uint64_t points = 0;
  std::uint64_t cells = 0;
  std::uint64_t voxels_per_side = 0;  // TissuePieces::Data::side; 0: no pieces
  std::uint64_t pieces = 0;
  std::uint64_t pair_values = 0;
  std::uint64_t map_values = 0;

  std::uint64_t FirstValues() const { return voxels_per_side > 0 ? cells + 1 : 0; }
  std::uint64_t FileSize() const {
    return sizeof(Header) + points * (4 * sizeof(double) + sizeof(int)) + cells * sizeof(double) +
           (FirstValues() + pair_values) * sizeof(int) + pieces * sizeof(double) +
           map_values * sizeof(std::uint16_t);
  }
  /// True if no array is longer than the file, so that FileSize() does not overflow.
  bool Within(std::uint64_t size) const {
    return std::max({points, pieces, pair_values, map_values}) <= size && voxels_per_side <= 1024;
  }
};
static_assert(std::has_unique_object_representations_v<Header>);

/// Calls visit(bytes, size) for each array of a tissue and its pieces, whose sizes are set.
template <typename Tissue, typename Pieces, typename Visit>
void ForEachArray(Tissue& tissue, Pieces& pieces, const Visit& visit) {
  const auto size = [](auto count, auto bytes) { return static_cast<std::size_t>(count) * bytes; };
  visit(tissue.points.data(), size(tissue.points.size(), sizeof(double)));
  visit(tissue.weights.data(), size(tissue.weights.size(), sizeof(double)));
  visit(tissue.cells.data(), size(tissue.cells.size(), sizeof(int)));
  visit(tissue.cell_volumes.data(), size(tissue.cell_volumes.size(), sizeof(double)));
  visit(pieces.first.data(), size(pieces.first.size(), sizeof(int)));
  visit(pieces.volumes.data(), size(pieces.volumes.size(), sizeof(double)));
  visit(pieces.pairs.data(), size(pieces.pairs.size(), sizeof(int)));
  visit(pieces.map.data(), size(pieces.map.size(), sizeof(std::uint16_t)));
}

Digest::Value ContentsOf(const TissueQuadrature& tissue, const TissuePieces::Data& pieces) {
  Digest digest;
  digest.Add(pieces.side);
  ForEachArray(tissue, pieces, [&](const void* data, std::size_t size) { digest.Add(data, size); });
  return digest.value();
}

std::optional<TissueQuadrature> Read(const fs::path& path, const Digest::Value& key,
                                     const std::array<int, 3>& cells_along,
                                     const CutSurfaces& cuts) {
  const std::uint64_t cells =
      static_cast<std::uint64_t>(cells_along[0]) * cells_along[1] * cells_along[2];
  std::ifstream file(path, std::ios::binary);
  Header header;
  const Header expected;
  if (!file.read(reinterpret_cast<char*>(&header), sizeof header)) return std::nullopt;
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  // The file's true size bounds the allocation, whatever its header claims.
  if (error || header.magic != expected.magic || header.key != key || header.cells != cells ||
      header.points == 0 || !header.Within(size) || header.FileSize() != size) {
    return std::nullopt;
  }
  TissueQuadrature tissue;
  const auto points = static_cast<Eigen::Index>(header.points);
  tissue.points.resize(points, 3);
  tissue.weights.resize(points);
  tissue.cells.resize(header.points);
  tissue.cell_volumes.resize(static_cast<Eigen::Index>(cells));
  TissuePieces::Data pieces;
  pieces.side = static_cast<int>(header.voxels_per_side);
  if (pieces.side > 0) pieces.cells = cells_along;
  pieces.first.resize(header.FirstValues());
  pieces.volumes.resize(header.pieces);
  pieces.pairs.resize(header.pair_values);
  pieces.map.resize(header.map_values);
  ForEachArray(tissue, pieces, [&](void* data, std::size_t bytes) {
    file.read(static_cast<char*>(data), static_cast<std::streamsize>(bytes));
  });
  if (!file || ContentsOf(tissue, pieces) != header.contents) return std::nullopt;
  tissue.pieces = TissuePieces(std::move(pieces), cuts);
  return tissue;
}

/// Removes the least recently used files until the folder is within its size.
void Trim(const fs::path& folder) {
  struct Kept {
    fs::file_time_type used;
    std::uintmax_t size;
    fs::path path;
  };
  std::vector<Kept> files;
  std::uintmax_t sum = 0;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->path().extension() != kExtension) continue;
    std::error_code gone;  // another program may trim too
    const fs::file_time_type used = it->last_write_time(gone);
    const std::uintmax_t size = gone ? 0 : it->file_size(gone);
    if (gone) continue;
    files.push_back({used, size, it->path()});
    sum += size;
  }
  std::sort(files.begin(), files.end(),
            [](const Kept& a, const Kept& b) { return a.used < b.used; });
  for (const Kept& file : files) {
    if (sum <= kMaxFolderBytes) return;
    fs::remove(file.path, error);
    sum -= file.size;
  }
}

/// Writes a file; leaves none if anything fails.
void Write(const fs::path& path, const Digest::Value& key, const TissueQuadrature& tissue) {
  const TissuePieces::Data& pieces = tissue.pieces.data();
  Header header;
  header.key = key;
  header.contents = ContentsOf(tissue, pieces);
  header.points = static_cast<std::uint64_t>(tissue.weights.size());
  header.cells = static_cast<std::uint64_t>(tissue.cell_volumes.size());
  header.voxels_per_side = static_cast<std::uint64_t>(pieces.side);
  header.pieces = pieces.volumes.size();
  header.pair_values = pieces.pairs.size();
  header.map_values = pieces.map.size();
  if (header.FileSize() > kMaxFolderBytes / 4) return;

  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) return;
  std::string temporary = path.string() + ".XXXXXX";
  const int descriptor = mkstemp(temporary.data());
  if (descriptor < 0) return;
  close(descriptor);
  std::ofstream file(temporary, std::ios::binary);
  file.write(reinterpret_cast<const char*>(&header), sizeof header);
  ForEachArray(tissue, pieces, [&](const void* data, std::size_t size) {
    file.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
  });
  file.close();
  if (file) fs::rename(temporary, path, error);
  if (!file || error) {
    fs::remove(temporary, error);
    return;
  }
  Trim(path.parent_path());
}

std::string HexName(const Digest::Value& key) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string name;
  for (const std::uint64_t word : key) {
    for (int shift = 60; shift >= 0; shift -= 4) name += kDigits[(word >> shift) & 15];
  }
  return name.append(kExtension);
}

}  // namespace

fs::path TissueCacheFolder() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return fs::path(value == nullptr ? "" : value);
  };
  if (const fs::path chosen = variable("HPDM_CACHE"); !chosen.empty()) {
    return chosen.is_absolute() ? chosen : fs::path();
  }
  if (const fs::path cache = variable("XDG_CACHE_HOME"); cache.is_absolute()) return cache / "hpdm";
  if (const fs::path home = variable("HOME"); home.is_absolute()) return home / ".cache" / "hpdm";
  return {};
}

TissueQuadrature CachedTissue(const SurfaceMesh& mesh_W, const OrientedBox& box_W,
                              const std::array<int, 3>& cells, const InteriorOptions& options,
                              const fs::path& folder) {
  if (folder.empty()) return SampleTissue(mesh_W, box_W, cells, options);
  const Digest::Value key = KeyOf(mesh_W, box_W, cells, options);
  const fs::path path = folder / HexName(key);
  if (std::optional<TissueQuadrature> kept = Read(path, key, cells, options.cuts)) {
    std::error_code error;  // a read-only folder keeps the old time
    fs::last_write_time(path, fs::file_time_type::clock::now(), error);
    return std::move(*kept);
  }
  TissueQuadrature tissue = SampleTissue(mesh_W, box_W, cells, options);
  Write(path, key, tissue);
  return tissue;
}

}  // namespace hpdm
