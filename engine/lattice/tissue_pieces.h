#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "engine/lattice/cut_surface.h"

namespace hpdm {

/// Numbers of cells along each axis, from `low` to `high`, both included.
struct CellRange {
  std::array<int, 3> low, high;
};

/// The connected pieces of an organ's tissue in each cell of the box in which it was sampled
/// (SampleTissue). Two parts of a cell that only connect through other cells are two pieces. With
/// them a lattice gives each side of a notch functions of its own (Lattice::SplitByTissue).
///
/// Pieces are found in voxels, `side` along each axis of a cell. So a gap narrower than a voxel is
/// not seen: between 1/256 and 1/128 of the box's longest side by default. Cuts (cut_surface.h)
/// have no width and are always seen. Constant once built; read by any thread.
class TissuePieces {
 public:
  /// Component below which tissue counts as a sliver, in volumes of a cell.
  static constexpr double kSliver = 1e-3;

  /// Pieces that the sampler finds and the tissue cache keeps. Cell (i, j, k) has the number
  /// i + nx (j + ny k), a voxel of it the same with side, side.
  struct Data {
    std::array<int, 3> cells = {0, 0, 0};
    int side = 0;                 ///< Voxels along each axis of a cell; 0: pieces were not sought.
    std::vector<int> first;       ///< Cells + 1: the cell's first piece. Pieces follow the cells.
    std::vector<double> volumes;  ///< Of each piece, in volumes of a cell.
    std::vector<int> pairs;       ///< Two pieces that touch in neighbouring cells; two by two.
    std::vector<std::uint16_t> map;  ///< Of each cell with more than one piece, in the order of the
                                     ///< cells: for each voxel, which of them is nearest.
  };

  TissuePieces() = default;
  /// `cuts`: none, or those that the pieces were found with.
  explicit TissuePieces(Data data, CutSurfaces cuts = nullptr);

  const Data& data() const { return data_; }
  bool empty() const { return data_.side == 0; }
  int size() const { return static_cast<int>(data_.volumes.size()); }
  int Cell(int piece) const { return cell_[static_cast<std::size_t>(piece)]; }
  /// Returns the edges of a voxel in units of the box.
  Vector3d VoxelSize() const;

  /// Returns the cuts, or nullptr.
  const CutSurfaces& cuts() const { return cuts_; }

  /// Returns the piece at a point (lattice coordinates, 0..1), or the nearest one within about a
  /// cell; -1 if there is none. A cut between the point and its voxel's centre counts.
  int At(const Vector3d& c) const;

  /// The pieces in a range of cells, each with the number of its connected component there: two
  /// pieces are in one if tissue within the range connects them. Components are numbered from 0 in
  /// the order of their first pieces. Those below `sliver` (cells) join the largest one.
  struct Components {
    int count = 0;
    std::vector<std::pair<int, int>> of_piece;  ///< Piece, component; ascending pieces.
  };
  Components Connected(const CellRange& range, double sliver) const;

 private:
  int CellNumber(int i, int j, int k) const {
    return i + data_.cells[0] * (j + data_.cells[1] * k);
  }
  int PiecesIn(int cell) const {
    return data_.first[static_cast<std::size_t>(cell) + 1] -
           data_.first[static_cast<std::size_t>(cell)];
  }
  int AtVoxel(const std::array<int, 3>& voxel) const;
  int BesideCuts(const Vector3d& c, const std::array<int, 3>& voxel) const;

  Data data_;
  CutSurfaces cuts_;
  std::vector<int> cell_;             // of each piece
  std::vector<int> first_neighbour_;  // pieces + 1
  std::vector<int> neighbours_;
  std::vector<std::size_t> map_at_;  // of each cell, where its part of the map begins
};

}  // namespace hpdm
