#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/lattice/tissue_pieces.h"

namespace hpdm {

/// Finds the connected pieces of tissue in the cells of a box (tissue_pieces.h) from the voxels that
/// contain tissue. Cells come one after the other. Two voxels connect if they share a face. Set-up
/// only; one thread.
class PieceFinder {
 public:
  /// `side`: voxels along each axis of a cell. `support`: cells that the narrowest function spans
  /// along each axis; all 0: no pieces are sought, and the calls below do nothing.
  /// `cuts`: of the organ, or nullptr.
  PieceFinder(const std::array<int, 3>& cells, int side, const std::array<int, 3>& support,
              CutSurfaces cuts = nullptr);

  /// Begins the next cell.
  void BeginCell();
  /// Says that the links from each voxel of the present cell to the next one along an axis are cut
  /// where `links`, side^3 for each axis, is not 0. The last ones lead to the next cell.
  using CutLinks = std::array<std::vector<std::uint8_t>, 3>;
  void SetCutLinks(CutLinks links) { cut_links_ = std::move(links); }
  /// Adds the voxels from `low` up to before `high` of the present cell.
  void AddVoxels(const std::array<int, 3>& low, const std::array<int, 3>& high);
  /// Ends it. `whole`: the cell is not split; all of it is tissue, or none. Returns the number of
  /// its pieces, which Finish() may lower, or 1 if no pieces are sought.
  int EndCell(bool whole, bool tissue);

  /// Returns the pieces. Those of a cell that every function connects, slivers included, are made
  /// one: no lattice over these cells, or over cells that consist of them, could tell them apart.
  TissuePieces Finish();

 private:
  using Label = std::uint16_t;
  // Voxels on the six faces of a cell, axis by axis, low before high: side^2 labels each.
  // A cell that is all tissue or none has none.
  struct Cell {
    int pieces = 0;
    std::vector<Label> faces;
    std::vector<Label> labels;  // side^3, only with more than one piece
    CutLinks cut_links;         // of a cell that a cut may cross
  };

  bool Seeks() const { return support_[0] > 0; }
  std::size_t Voxel(int i, int j, int k) const {
    return static_cast<std::size_t>(i + side_ * (j + side_ * k));
  }
  std::vector<double> LabelVoxels();
  std::vector<double> LabelCutVoxels();
  void TakeFaces(Cell* cell) const;
  void AddPairs(int cell, int neighbour, int axis, const std::vector<int>& first,
                std::vector<int>* pairs) const;
  TissuePieces::Data Found() const;
  void SpreadLabels(const CutLinks& cuts, std::vector<Label>* labels) const;

  std::array<int, 3> cells_;
  int side_;
  std::array<int, 3> support_;
  CutSurfaces cuts_;
  std::vector<Cell> found_;
  std::vector<double> volumes_;         // of the pieces of all cells so far
  std::vector<std::uint8_t> occupied_;  // side^3 of the present cell
  std::vector<Label> labels_;           // side^3: 0 for no tissue, else its piece in the cell + 1
  CutLinks cut_links_;                  // of the present cell; empty without a cut
};

}  // namespace hpdm
