#pragma once

#include <array>
#include <optional>
#include <vector>

#include "engine/base/quadrature.h"
#include "engine/lattice/active_refinement.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// Detects inverted tissue: det(F) <= 0 at a quadrature point, with F = I + grad u.
///
/// 1. det(F) > 0 holds wherever |grad u| < 1. A bound on |grad u| clears most cells without
///    evaluating their points.
/// 2. The derivative of u along a lattice axis is a weighted mean of the differences of
///    neighbouring control displacements over their spacing. The weights are the functions of one
///    degree less (UnivariateBasis::DerivativeBasis).
/// 3. So the derivative in a cell has a bound: the largest difference with a noticeable weight
///    there, plus the sum of the others times their largest weights. The split matters: a control
///    point with a trace of tissue may move by metres where the tissue moves by millimetres.
/// 4. Local functions (refinement_basis.h) and those of finer levels add |V| |grad phi|.
/// 5. The points of the other cells are evaluated, spread over as many calls as the caller wants.
///
/// Constant once built; read by any thread, without allocation.
class InversionDetector {
 public:
  /// `tissue`: world, m, m^3. `finer`: lattice of the organ's local functions, or nullptr.
  InversionDetector(const Lattice& lattice, const Lattice* finer, const Quadrature& tissue);

  static constexpr int kSamples = 512;  ///< Points of LargestGradient(), spread over the tissue.
  static constexpr int kParts = 4;      ///< Calls over which LargestGradient() spreads them.

  /// State of a scan, kept by the caller from call to call.
  struct ScanState {
    explicit ScanState(const InversionDetector& detector);
    double share = 0;  ///< Share of the volume (0..1) that the last complete scan found inverted.
    int part = 0;      // next part of LargestGradient()
    std::array<double, kParts> gradients{};     // largest |grad u| of each part
    std::size_t cell = 0;                       // next cell of the scan
    Eigen::Index point = 0;                     // next point in that cell
    double found = 0;                           // m^3 found inverted since the scan began
    std::array<std::vector<double>, 3> slopes;  // |difference| / spacing of each pair, 1
    std::vector<double> local;  // part of the local functions and finer levels in each cell, 1
    std::vector<bool> clear;    // cells that need no evaluation
  };

  /// Continues a scan under the control displacements `U` ((n + slots of `active`) x 3, m, finite).
  /// Evaluates enough points to finish within `calls` calls, and at least 64. True if tissue is
  /// known to be inverted: found so far in this scan or, before its end, in the last one. With
  /// `calls` = 1 the scan is complete and the answer exact.
  bool Inverted(const ActiveRefinement& active, const Points& U, int calls, ScanState* scan) const;

  /// Returns the largest |grad u| (Frobenius) at sample points: a measure of strain and rotation.
  /// Each call evaluates one part of the points in about 40 us and remembers the other parts.
  double LargestGradient(const ActiveRefinement& active, const Points& U, ScanState* scan) const;

  /// The least det(F) of all points and the inverted share; for measurements and tests.
  struct Inversion {
    double least = 1;
    double share = 0;
  };
  Inversion EvaluateAll(const ActiveRefinement& active, const Points& U) const;

  int points() const { return static_cast<int>(points_.rows()); }  ///< Q.

 private:
  // Neighbouring control points along an axis; -1 for a dropped one, whose displacement is zero.
  struct Pair {
    int a, b;
  };
  struct Weighed {
    int pair;
    double weight;  // largest over the cell's points
  };
  struct Cell {
    Eigen::Index begin, end;                    // range in points_
    std::array<std::vector<int>, 3> firm;       // pairs of noticeable weight, along each axis
    std::array<std::vector<Weighed>, 3> loose;  // pairs of little weight
  };
  // Largest |grad phi| (1/m) of a function over the points of a cell.
  struct CellSlope {
    std::size_t cell;
    double slope;
  };

  // The numbers of the pairs at each place of the grid of differences: several where functions are
  // split.
  using PairsByIndex = std::vector<std::vector<int>>;

  void AddCell(int axis, PairsByIndex* numbers, Cell* cell);
  int PairNumber(int axis, int index, const Pair& pair, PairsByIndex* numbers);
  void SortPairs(int axis, const PairsByIndex& numbers);
  std::vector<std::vector<CellSlope>> SlopesOf(const Lattice& lattice) const;
  void MeasureSlopes(const ActiveRefinement& active, const Points& U, ScanState* scan) const;
  bool Clear(std::size_t index, const ScanState& scan) const;
  Matrix3d Gradient(Eigen::Index q, const ActiveRefinement& active, const Points& U) const;
  double Determinant(Eigen::Index q, const ActiveRefinement& active, const Points& U) const;

  Lattice lattice_;
  std::optional<Lattice> finer_;
  Points points_;            // Q x 3, cell after cell
  Eigen::VectorXd weights_;  // Q, m^3
  double volume_ = 0;        // m^3
  std::array<std::vector<Pair>, 3> pairs_;
  std::vector<Cell> cells_;
  std::vector<std::vector<CellSlope>> local_slopes_;  // for each local function
  std::vector<std::vector<std::vector<CellSlope>>>
      level_slopes_;  // for each function of each level
};

}  // namespace hpdm
