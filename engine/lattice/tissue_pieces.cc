#include "engine/lattice/tissue_pieces.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/base/check.h"

namespace hpdm {

TissuePieces::TissuePieces(Data data, CutSurfaces cuts)
    : data_(std::move(data)), cuts_(std::move(cuts)) {
  if (data_.side == 0) return;
  const auto cells = static_cast<std::size_t>(data_.cells[0]) * data_.cells[1] * data_.cells[2];
  HPDM_CHECK(data_.first.size() == cells + 1 && data_.pairs.size() % 2 == 0);
  const std::size_t voxels = static_cast<std::size_t>(data_.side) * data_.side * data_.side;
  cell_.resize(data_.volumes.size());
  map_at_.resize(cells);
  std::size_t map_end = 0;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    std::fill(cell_.begin() + data_.first[cell], cell_.begin() + data_.first[cell + 1],
              static_cast<int>(cell));
    map_at_[cell] = map_end;
    if (PiecesIn(static_cast<int>(cell)) > 1) map_end += voxels;
  }
  HPDM_CHECK(data_.map.size() == map_end);

  first_neighbour_.assign(data_.volumes.size() + 1, 0);
  for (const int piece : data_.pairs) ++first_neighbour_[static_cast<std::size_t>(piece) + 1];
  std::partial_sum(first_neighbour_.begin(), first_neighbour_.end(), first_neighbour_.begin());
  neighbours_.resize(data_.pairs.size());
  std::vector<int> end(first_neighbour_.begin(), first_neighbour_.end() - 1);
  for (std::size_t p = 0; p < data_.pairs.size(); p += 2) {
    const int a = data_.pairs[p], b = data_.pairs[p + 1];
    neighbours_[static_cast<std::size_t>(end[static_cast<std::size_t>(a)]++)] = b;
    neighbours_[static_cast<std::size_t>(end[static_cast<std::size_t>(b)]++)] = a;
  }
}

Vector3d TissuePieces::VoxelSize() const {
  return (data_.side * Vector3d(data_.cells[0], data_.cells[1], data_.cells[2])).cwiseInverse();
}

int TissuePieces::AtVoxel(const std::array<int, 3>& voxel) const {
  const int side = data_.side;
  const int cell = CellNumber(voxel[0] / side, voxel[1] / side, voxel[2] / side);
  const int pieces = PiecesIn(cell), first = data_.first[static_cast<std::size_t>(cell)];
  if (pieces == 0) return -1;
  if (pieces == 1) return first;
  const int in_cell = voxel[0] % side + side * (voxel[1] % side + side * (voxel[2] % side));
  return first +
         data_.map[map_at_[static_cast<std::size_t>(cell)] + static_cast<std::size_t>(in_cell)];
}

int TissuePieces::At(const Vector3d& c) const {
  std::array<int, 3> voxel;
  for (int d = 0; d < 3; ++d) {
    const int count = data_.cells[d] * data_.side;
    voxel[d] = static_cast<int>(std::clamp(std::floor(c[d] * count), 0.0, count - 1.0));
  }
  int piece = cuts_ == nullptr ? AtVoxel(voxel) : BesideCuts(c, voxel);
  for (int away = 1; piece < 0 && away <= data_.side; ++away) {
    for (int direction = 0; piece < 0 && direction < 27; ++direction) {
      const std::array<int, 3> step = {direction % 3 - 1, direction / 3 % 3 - 1, direction / 9 - 1};
      std::array<int, 3> at;
      bool inside = true;
      for (int d = 0; d < 3; ++d) {
        at[d] = voxel[d] + away * step[d];
        inside = inside && at[d] >= 0 && at[d] < data_.cells[d] * data_.side;
      }
      if (inside) piece = AtVoxel(at);
    }
  }
  return piece;
}

// Returns the piece of the voxel, or of the nearest one of its cell, whose centre no cut separates
// from the point.
int TissuePieces::BesideCuts(const Vector3d& c, const std::array<int, 3>& voxel) const {
  const int side = data_.side;
  const std::array<int, 3> cell = {voxel[0] / side, voxel[1] / side, voxel[2] / side};
  if (PiecesIn(CellNumber(cell[0], cell[1], cell[2])) < 2) return AtVoxel(voxel);
  const CutSurface::GridPoint p = cuts_->front().AtUnit(c);
  const auto centre = [this](const std::array<int, 3>& at) {
    return Vector3d(Vector3d(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5).cwiseProduct(VoxelSize()));
  };
  constexpr int kAway = 2;
  int found = -1;
  double nearest = 0;
  std::array<int, 3> at;
  for (at[2] = voxel[2] - kAway; at[2] <= voxel[2] + kAway; ++at[2]) {
    for (at[1] = voxel[1] - kAway; at[1] <= voxel[1] + kAway; ++at[1]) {
      for (at[0] = voxel[0] - kAway; at[0] <= voxel[0] + kAway; ++at[0]) {
        if (at[0] < 0 || at[1] < 0 || at[2] < 0) continue;
        if (at[0] / side != cell[0] || at[1] / side != cell[1] || at[2] / side != cell[2]) continue;
        const Vector3d away = (centre(at) - c).cwiseQuotient(VoxelSize());
        if (found >= 0 && away.squaredNorm() >= nearest) continue;
        if (CrossesAny(*cuts_, p, cuts_->front().AtUnit(centre(at)))) continue;
        found = AtVoxel(at);
        nearest = away.squaredNorm();
      }
    }
  }
  return found >= 0 ? found : AtVoxel(voxel);
}

TissuePieces::Components TissuePieces::Connected(const CellRange& range, double sliver) const {
  Components found;
  // The cells of a row are neighbours in number, so their pieces follow each other. For each row:
  // the place in found.of_piece of the piece 0, if it were there.
  std::vector<std::ptrdiff_t> offset;
  for (int k = range.low[2]; k <= range.high[2]; ++k) {
    for (int j = range.low[1]; j <= range.high[1]; ++j) {
      const auto begin = static_cast<std::size_t>(CellNumber(range.low[0], j, k));
      const auto end = static_cast<std::size_t>(CellNumber(range.high[0], j, k)) + 1;
      offset.push_back(static_cast<std::ptrdiff_t>(found.of_piece.size()) - data_.first[begin]);
      for (int p = data_.first[begin]; p < data_.first[end]; ++p)
        found.of_piece.emplace_back(p, -1);
    }
  }
  const auto place = [&](int piece) -> std::ptrdiff_t {
    const int cell = Cell(piece);
    const int i = cell % data_.cells[0], j = cell / data_.cells[0] % data_.cells[1],
              k = cell / (data_.cells[0] * data_.cells[1]);
    if (i < range.low[0] || i > range.high[0] || j < range.low[1] || j > range.high[1] ||
        k < range.low[2] || k > range.high[2]) {
      return -1;
    }
    const int row = j - range.low[1] + (range.high[1] - range.low[1] + 1) * (k - range.low[2]);
    return offset[static_cast<std::size_t>(row)] + piece;
  };
  std::vector<double> volumes;
  std::vector<std::ptrdiff_t> open;
  for (std::size_t start = 0; start < found.of_piece.size(); ++start) {
    if (found.of_piece[start].second >= 0) continue;
    const auto component = static_cast<int>(volumes.size());
    volumes.push_back(0);
    found.of_piece[start].second = component;
    open.push_back(static_cast<std::ptrdiff_t>(start));
    while (!open.empty()) {
      const auto piece =
          static_cast<std::size_t>(found.of_piece[static_cast<std::size_t>(open.back())].first);
      open.pop_back();
      volumes.back() += data_.volumes[piece];
      for (int n = first_neighbour_[piece]; n < first_neighbour_[piece + 1]; ++n) {
        const std::ptrdiff_t other = place(neighbours_[static_cast<std::size_t>(n)]);
        if (other < 0 || found.of_piece[static_cast<std::size_t>(other)].second >= 0) continue;
        found.of_piece[static_cast<std::size_t>(other)].second = component;
        open.push_back(other);
      }
    }
  }
  if (volumes.empty()) return found;

  const auto largest =
      static_cast<std::size_t>(std::max_element(volumes.begin(), volumes.end()) - volumes.begin());
  std::vector<int> number(volumes.size(), -1);
  for (auto& [piece, component] : found.of_piece) {
    auto c = static_cast<std::size_t>(component);
    if (volumes[c] < sliver) c = largest;
    if (number[c] < 0) number[c] = found.count++;
    component = number[c];
  }
  return found;
}

}  // namespace hpdm
