#pragma once

#include <array>
#include <optional>
#include <vector>

#include "engine/base/quadrature.h"
#include "engine/lattice/active_refinement.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// Whether an organ's tissue is inverted: turned inside out by the lattice map, det(F) <= 0 with
/// F = I + grad u, at its quadrature points.
///
/// Few points are evaluated for that. The derivative of u along a lattice axis is a mean of the
/// differences of neighbouring control displacements over their spacing, weighted by the functions
/// of one degree less (UnivariateBasis::DerivativeBasis). So over the points of a cell it is at
/// most the largest difference of those that weigh something there, and the sum of the others times
/// the most that they weigh; local functions (refinement_basis.h) add |V| |grad phi|. Where these
/// leave |grad u| < 1, det(F) > 0. (The split matters: a control point with a trace of tissue may
/// move by metres where the tissue moves by millimetres.) The points of cells that are not cleared
/// are evaluated, over as many calls as the caller likes.
///
/// Constant once built; read by any thread, without allocation.
class InversionDetector {
 public:
  /// `tissue`: world, m, m^3. `finer`: of the organ's local functions, or nullptr.
  InversionDetector(const Lattice& lattice, const Lattice* finer, const Quadrature& tissue);

  /// Sample points of LargestGradient, spread over the tissue, and into how many calls.
  static constexpr int kSamples = 512;
  static constexpr int kParts = 4;

  /// What a caller keeps of a watch from call to call.
  struct ScanState {
    explicit ScanState(const InversionDetector& detector);
    double share = 0;  ///< Of the tissue's volume (0..1) that the last whole scan found inverted.
    int part = 0;      // of LargestGradient: the next
    std::array<double, kParts> gradients{};
    std::size_t cell = 0;  // where to go on
    Eigen::Index point = 0;
    double found = 0;                           // m^3, since the scan began
    std::array<std::vector<double>, 3> slopes;  // of each pair, 1
    std::vector<double> local;                  // of each cell, 1
    std::vector<bool> clear;                    // of each cell
  };

  /// Goes on with a scan under the control displacements `U` ((n + slots of `active`) x 3, m,
  /// finite), with as many points that it takes no more than `calls` of them, and 64 at least. True
  /// when tissue is known to be inverted: in what was scanned so far or, before its end, in the
  /// last scan. With one call it is whole, and the answer exact.
  bool Inverted(const ActiveRefinement& active, const Points& U, int calls, ScanState* scan) const;

  /// How far the tissue is strained and turned: the largest |grad u| (Frobenius) at some of its
  /// points, of which each call evaluates a part, some 40 us, and remembers the others.
  double LargestGradient(const ActiveRefinement& active, const Points& U, ScanState* scan) const;

  /// The least det(F) of all points, and the inverted share: to measure and to test.
  struct Inversion {
    double least = 1;
    double share = 0;
  };
  Inversion EvaluateAll(const ActiveRefinement& active, const Points& U) const;

  int points() const { return static_cast<int>(points_.rows()); }  ///< Q.

 private:
  // Neighbouring control points along an axis; -1: dropped, so zero.
  struct Pair {
    int a, b;
  };
  struct Weighed {
    int pair;
    double weight;  // at most, over the cell's points
  };
  struct Cell {
    Eigen::Index begin, end;  // of points_
    std::array<std::vector<int>, 3> firm;
    std::array<std::vector<Weighed>, 3> loose;
  };
  // Largest |grad phi| (1/m) of a local function over the points of a cell.
  struct LocalSlope {
    std::size_t cell;
    double slope;
  };

  void AddPairs(int axis, std::vector<int>* pair_at);
  void AddCell(int axis, const std::vector<int>& pair_at, Cell* cell) const;
  void AddLocalSlopes();
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
  std::vector<std::vector<LocalSlope>> local_slopes_;  // of each function
};

}  // namespace hpdm
