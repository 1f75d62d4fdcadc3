#include "engine/tissue/piece_finder.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

namespace hpdm {
namespace {

// A run of voxels with tissue along x.
struct Run {
  int begin, end;
};

int Root(std::vector<int>* parent, int a) {
  while ((*parent)[static_cast<std::size_t>(a)] != a) {
    a = (*parent)[static_cast<std::size_t>(a)] =
        (*parent)[static_cast<std::size_t>((*parent)[static_cast<std::size_t>(a)])];
  }
  return a;
}

// Joins the runs a .. a_end with the runs b .. b_end of a neighbouring row where they overlap.
void JoinRows(const std::vector<Run>& runs, int a, int a_end, int b, int b_end,
              std::vector<int>* parent) {
  while (a < a_end && b < b_end) {
    const Run& p = runs[static_cast<std::size_t>(a)];
    const Run& q = runs[static_cast<std::size_t>(b)];
    if (p.begin < q.end && q.begin < p.end) {
      const int x = Root(parent, a), y = Root(parent, b);
      (*parent)[static_cast<std::size_t>(std::max(x, y))] = std::min(x, y);
    }
    if (p.end < q.end) {
      ++a;
    } else {
      ++b;
    }
  }
}

}  // namespace

PieceFinder::PieceFinder(const std::array<int, 3>& cells, int side,
                         const std::array<int, 3>& support, CutSurfaces cuts)
    : cells_(cells), side_(side), support_(support), cuts_(std::move(cuts)) {
  if (!Seeks()) return;
  occupied_.resize(Voxel(0, 0, side_));
  labels_.resize(occupied_.size());
}

void PieceFinder::BeginCell() {
  std::fill(occupied_.begin(), occupied_.end(), 0);
  cut_links_ = {};
}

void PieceFinder::AddVoxels(const std::array<int, 3>& low, const std::array<int, 3>& high) {
  if (!Seeks()) return;
  for (int k = low[2]; k < high[2]; ++k) {
    for (int j = low[1]; j < high[1]; ++j) {
      std::fill_n(occupied_.begin() + static_cast<std::ptrdiff_t>(Voxel(low[0], j, k)),
                  high[0] - low[0], 1);
    }
  }
}

int PieceFinder::EndCell(bool whole, bool tissue) {
  if (!Seeks()) return 1;
  Cell& cell = found_.emplace_back();
  if (whole) {
    cell.pieces = tissue ? 1 : 0;
    if (tissue) volumes_.push_back(1);
    return cell.pieces;
  }
  const bool cut = !cut_links_[0].empty();
  const std::vector<double> volumes = cut ? LabelCutVoxels() : LabelVoxels();
  volumes_.insert(volumes_.end(), volumes.begin(), volumes.end());
  cell.pieces = static_cast<int>(volumes.size());
  TakeFaces(&cell);
  if (cell.pieces > 1) cell.labels = labels_;
  cell.cut_links = std::move(cut_links_);
  cut_links_ = {};
  return cell.pieces;
}

// Labels the connected voxels of the present cell. Returns the volume of each label.
std::vector<double> PieceFinder::LabelVoxels() {
  std::vector<Run> runs;
  std::vector<int> parent, row(static_cast<std::size_t>(side_) * side_ + 1);
  for (int k = 0; k < side_; ++k) {
    for (int j = 0; j < side_; ++j) {
      const int at = j + side_ * k;
      row[static_cast<std::size_t>(at)] = static_cast<int>(runs.size());
      const std::uint8_t* voxels = &occupied_[Voxel(0, j, k)];
      for (int i = 0; i < side_; ++i) {
        if (voxels[i] == 0) continue;
        const int begin = i;
        while (i < side_ && voxels[i] != 0) ++i;
        parent.push_back(static_cast<int>(runs.size()));
        runs.push_back({begin, i});
      }
      const int begin = row[static_cast<std::size_t>(at)], end = static_cast<int>(runs.size());
      row[static_cast<std::size_t>(at) + 1] = end;
      for (const int before : {j > 0 ? at - 1 : -1, k > 0 ? at - side_ : -1}) {
        if (before < 0) continue;
        JoinRows(runs, row[static_cast<std::size_t>(before)],
                 row[static_cast<std::size_t>(before) + 1], begin, end, &parent);
      }
    }
  }
  std::fill(labels_.begin(), labels_.end(), Label{0});
  std::vector<double> volumes;
  std::vector<Label> label(runs.size(), 0);
  const double voxel = 1.0 / static_cast<double>(labels_.size());
  for (int at = 0; at < side_ * side_; ++at) {
    for (int r = row[static_cast<std::size_t>(at)]; r < row[static_cast<std::size_t>(at) + 1];
         ++r) {
      const auto root = static_cast<std::size_t>(Root(&parent, r));
      // A surface that leaves more pieces than a label can number is dirt, and one piece is enough.
      if (label[root] == 0) {
        if (volumes.size() < 0xffff) volumes.push_back(0);
        label[root] = static_cast<Label>(volumes.size());
      }
      const auto& [begin, end] = runs[static_cast<std::size_t>(r)];
      std::fill(labels_.begin() + static_cast<std::ptrdiff_t>(at) * side_ + begin,
                labels_.begin() + static_cast<std::ptrdiff_t>(at) * side_ + end, label[root]);
      volumes[label[root] - 1U] += voxel * (end - begin);
    }
  }
  return volumes;
}

// Does the same where some links are cut, voxel by voxel.
std::vector<double> PieceFinder::LabelCutVoxels() {
  std::vector<int> parent(occupied_.size());
  std::iota(parent.begin(), parent.end(), 0);
  const std::array<std::size_t, 3> stride = {Voxel(1, 0, 0), Voxel(0, 1, 0), Voxel(0, 0, 1)};
  std::array<int, 3> at;
  for (at[2] = 0; at[2] < side_; ++at[2]) {
    for (at[1] = 0; at[1] < side_; ++at[1]) {
      for (at[0] = 0; at[0] < side_; ++at[0]) {
        const std::size_t voxel = Voxel(at[0], at[1], at[2]);
        for (std::size_t d = 0; d < 3; ++d) {
          if (at[d] + 1 == side_ || occupied_[voxel] == 0 || cut_links_[d][voxel] != 0) continue;
          const std::size_t next = voxel + stride[d];
          if (occupied_[next] == 0) continue;
          const int p = Root(&parent, static_cast<int>(voxel)),
                    q = Root(&parent, static_cast<int>(next));
          parent[static_cast<std::size_t>(std::max(p, q))] = std::min(p, q);
        }
      }
    }
  }
  std::fill(labels_.begin(), labels_.end(), Label{0});
  std::vector<double> volumes;
  for (std::size_t voxel = 0; voxel < occupied_.size(); ++voxel) {
    if (occupied_[voxel] == 0) continue;
    const auto root = static_cast<std::size_t>(Root(&parent, static_cast<int>(voxel)));
    if (root == voxel && volumes.size() < 0xffff) {
      volumes.push_back(0);
      labels_[voxel] = static_cast<Label>(volumes.size());
    } else {
      labels_[voxel] = root == voxel ? static_cast<Label>(volumes.size()) : labels_[root];
    }
    volumes[labels_[voxel] - 1U] += 1.0 / static_cast<double>(labels_.size());
  }
  return volumes;
}

void PieceFinder::TakeFaces(Cell* cell) const {
  if (cell->pieces == 0) return;
  const int last = side_ - 1;
  cell->faces.reserve(6 * static_cast<std::size_t>(side_) * side_);
  for (int axis = 0; axis < 3; ++axis) {
    for (const int layer : {0, last}) {
      for (int b = 0; b < side_; ++b) {
        for (int a = 0; a < side_; ++a) {
          std::array<int, 3> at;
          at[axis] = layer;
          at[(axis + 1) % 3] = a;
          at[(axis + 2) % 3] = b;
          cell->faces.push_back(labels_[Voxel(at[0], at[1], at[2])]);
        }
      }
    }
  }
}

// Adds the pairs of pieces that touch across the face between a cell and the next along an axis.
void PieceFinder::AddPairs(int cell, int neighbour, int axis, const std::vector<int>& first,
                           std::vector<int>* pairs) const {
  const Cell& a = found_[static_cast<std::size_t>(cell)];
  const Cell& b = found_[static_cast<std::size_t>(neighbour)];
  if (a.pieces == 0 || b.pieces == 0) return;
  const auto size = static_cast<std::size_t>(side_) * side_;
  const auto label = [&](const Cell& of, int layer, std::size_t v) -> int {
    return of.faces.empty() ? 1 : of.faces[(2 * static_cast<std::size_t>(axis) + layer) * size + v];
  };
  const auto cut_link = [&](std::size_t v) {
    if (a.cut_links[axis].empty()) return false;
    std::array<int, 3> at;
    at[axis] = side_ - 1;
    at[(axis + 1) % 3] = static_cast<int>(v) % side_;
    at[(axis + 2) % 3] = static_cast<int>(v) / side_;
    return a.cut_links[axis][Voxel(at[0], at[1], at[2])] != 0;
  };
  std::set<std::pair<int, int>> touching;
  for (std::size_t v = 0; v < size; ++v) {
    const int p = label(a, 1, v), q = label(b, 0, v);
    const bool cut = p > 0 && q > 0 && cut_link(v);
    if (p > 0 && q > 0 && !cut) touching.insert({p, q});
  }
  for (const auto& [p, q] : touching) {
    pairs->push_back(first[static_cast<std::size_t>(cell)] + p - 1);
    pairs->push_back(first[static_cast<std::size_t>(neighbour)] + q - 1);
  }
}

// Returns all pieces, none joined. The map of a voxel without tissue is that of the first piece.
TissuePieces::Data PieceFinder::Found() const {
  TissuePieces::Data data;
  data.cells = cells_;
  data.side = side_;
  data.first = {0};
  data.volumes = volumes_;
  for (const Cell& cell : found_) {
    data.first.push_back(data.first.back() + cell.pieces);
    for (const Label label : cell.labels) {
      data.map.push_back(static_cast<Label>(label > 0 ? label - 1 : 0));
    }
  }
  const std::array<int, 3> stride = {1, cells_[0], cells_[0] * cells_[1]};
  for (int cell = 0; cell < static_cast<int>(found_.size()); ++cell) {
    for (int axis = 0; axis < 3; ++axis) {
      if (cell / stride[axis] % cells_[axis] + 1 == cells_[axis]) continue;
      AddPairs(cell, cell + stride[axis], axis, data.first, &data.pairs);
    }
  }
  return data;
}

// Gives each voxel without tissue the label of the nearest tissue, in steps through faces: first
// those that no cut crosses, so that a label stays on its side, then any.
void PieceFinder::SpreadLabels(const CutLinks& cuts, std::vector<Label>* labels) const {
  const std::array<int, 3> stride = {1, side_, side_ * side_};
  for (const bool across : {false, true}) {
    std::vector<int> queue;
    for (std::size_t v = 0; v < labels->size(); ++v) {
      if ((*labels)[v] > 0) queue.push_back(static_cast<int>(v));
    }
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const int v = queue[next];
      for (std::size_t d = 0; d < 3; ++d) {
        const int step = stride[d], place = v / step % side_;
        for (const int to : {place > 0 ? v - step : -1, place + 1 < side_ ? v + step : -1}) {
          if (to < 0 || (*labels)[static_cast<std::size_t>(to)] > 0) continue;
          const auto link = static_cast<std::size_t>(std::min(v, to));
          if (!across && !cuts[d].empty() && cuts[d][link] != 0) continue;
          (*labels)[static_cast<std::size_t>(to)] = (*labels)[static_cast<std::size_t>(v)];
          queue.push_back(to);
        }
      }
    }
    if (cuts[0].empty()) return;
  }
}

TissuePieces PieceFinder::Finish() {
  if (!Seeks()) return {};
  TissuePieces::Data all = Found();
  const TissuePieces pieces(all, cuts_);
  // For each function, the component of each piece, in the cells that have several pieces.
  std::vector<std::vector<int>> seen(static_cast<std::size_t>(pieces.size()));
  const auto several = [&](int cell) { return found_[static_cast<std::size_t>(cell)].pieces > 1; };
  std::array<int, 3> at;
  for (at[2] = 1 - support_[2]; at[2] < cells_[2]; ++at[2]) {
    for (at[1] = 1 - support_[1]; at[1] < cells_[1]; ++at[1]) {
      for (at[0] = 1 - support_[0]; at[0] < cells_[0]; ++at[0]) {
        CellRange range;
        for (int d = 0; d < 3; ++d) {
          range.low[d] = std::max(at[d], 0);
          range.high[d] = std::min(at[d] + support_[d], cells_[d]) - 1;
        }
        bool matters = false;
        for (int k = range.low[2]; k <= range.high[2]; ++k) {
          for (int j = range.low[1]; j <= range.high[1]; ++j) {
            for (int i = range.low[0]; i <= range.high[0]; ++i) {
              matters = matters || several(i + cells_[0] * (j + cells_[1] * k));
            }
          }
        }
        if (!matters) continue;
        for (const auto& [piece, component] :
             pieces.Connected(range, TissuePieces::kSliver).of_piece) {
          if (several(pieces.Cell(piece))) {
            seen[static_cast<std::size_t>(piece)].push_back(component);
          }
        }
      }
    }
  }

  TissuePieces::Data data;
  data.cells = cells_;
  data.side = side_;
  data.first = {0};
  std::vector<int> number(static_cast<std::size_t>(pieces.size()));
  for (std::size_t cell = 0; cell < found_.size(); ++cell) {
    const int begin = all.first[cell], end = all.first[cell + 1];
    for (int p = begin; p < end; ++p) {
      int same = begin;
      while (same < p &&
             seen[static_cast<std::size_t>(same)] != seen[static_cast<std::size_t>(p)]) {
        ++same;
      }
      const auto to = static_cast<std::size_t>(p);
      if (same == p) {
        number[to] = static_cast<int>(data.volumes.size());
        data.volumes.push_back(0);
      } else {
        number[to] = number[static_cast<std::size_t>(same)];
      }
      data.volumes[static_cast<std::size_t>(number[to])] += all.volumes[to];
    }
    data.first.push_back(static_cast<int>(data.volumes.size()));
    const int first = data.first[cell];
    if (data.first[cell + 1] - first < 2) continue;
    std::vector<Label> labels = std::move(found_[cell].labels);
    for (Label& label : labels) {
      if (label == 0) continue;
      label = static_cast<Label>(number[static_cast<std::size_t>(begin) + label - 1U] - first + 1);
    }
    SpreadLabels(found_[cell].cut_links, &labels);
    for (const Label label : labels) data.map.push_back(static_cast<Label>(label - 1));
  }
  std::set<std::pair<int, int>> pairs;
  for (std::size_t p = 0; p < all.pairs.size(); p += 2) {
    pairs.insert({number[static_cast<std::size_t>(all.pairs[p])],
                  number[static_cast<std::size_t>(all.pairs[p + 1])]});
  }
  for (const auto& [a, b] : pairs) data.pairs.insert(data.pairs.end(), {a, b});
  return TissuePieces(std::move(data), cuts_);
}

}  // namespace hpdm
