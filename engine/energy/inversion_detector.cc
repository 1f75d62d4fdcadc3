#include "engine/energy/inversion_detector.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

namespace hpdm {
namespace {

// Least weight of a difference that counts as noticeable in a cell.
constexpr double kFirm = 0.05;

// Least number of points that a call evaluates: about 20 us.
constexpr Eigen::Index kMinPointsPerCall = 64;

using Grid = std::array<int, 3>;

// Returns the numbers of cells that group the points. The single cell of a Bernstein lattice is
// divided.
Grid GroupsOf(const Lattice& lattice) {
  Grid groups;
  for (int d = 0; d < 3; ++d) {
    const UnivariateBasis& basis = lattice.basis().axis(d);
    groups[d] = basis.type() == BasisType::kBernstein ? std::max(basis.degree(), 4) : basis.cells();
  }
  return groups;
}

// Calls f(index, a, b, value) for the functions that weight the differences along `axis` at a point.
// The index is that of a grid with one function less along the axis; a and b are the columns of the
// two control points.
template <typename Function>
void ForEachDifference(const Lattice& lattice, int axis, const Vector3d& p_W, Function&& f) {
  const Lattice::Site site = lattice.SiteOf(p_W);
  std::array<std::array<double, TensorBasis::kMaxSupport>, 3> values;
  Grid first, support, count;
  for (int d = 0; d < 3; ++d) {
    const UnivariateBasis& whole = lattice.basis().axis(d);
    const UnivariateBasis basis = d == axis ? whole.DerivativeBasis() : whole;
    first[d] = basis.Evaluate(site.c[d], values[d].data());
    support[d] = basis.support();
    count[d] = basis.count();
  }
  for (int i = 0; i < support[0]; ++i) {
    for (int j = 0; j < support[1]; ++j) {
      for (int k = 0; k < support[2]; ++k) {
        Grid next = {i, j, k};
        ++next[axis];
        f(((first[0] + i) * count[1] + first[1] + j) * count[2] + first[2] + k,
          lattice.ColumnAt(site, first, {i, j, k}), lattice.ColumnAt(site, first, next),
          values[0][i] * values[1][j] * values[2][k]);
      }
    }
  }
}

// Adds grad u at a point. A function's displacement is row row_of(column) of U; -1 leaves it out.
// Takes half the time of ForEachGradient, because the innermost sums are taken first.
template <typename RowOf>
void AddGradient(const Lattice& lattice, const Vector3d& p_W, RowOf&& row_of, const Points& U,
                 Matrix3d* gradient) {
  const OrientedBox& box = lattice.box();
  const TensorBasis& basis = lattice.basis();
  const Lattice::Site site = lattice.SiteOf(p_W);
  const Vector3d& c = site.c;
  std::array<std::array<double, TensorBasis::kMaxSupport>, 3> values, derivatives;
  Grid first;
  for (int d = 0; d < 3; ++d) {
    first[d] = basis.axis(d).Evaluate(c[d], values[d].data());
    basis.axis(d).EvaluateDerivatives(c[d], derivatives[d].data());
  }
  Matrix3d by_c = Matrix3d::Zero();
  for (int i = 0; i < basis.axis(0).support(); ++i) {
    for (int j = 0; j < basis.axis(1).support(); ++j) {
      Vector3d value = Vector3d::Zero(), derivative = Vector3d::Zero();
      for (int k = 0; k < basis.axis(2).support(); ++k) {
        const int column = lattice.ColumnAt(site, first, {i, j, k});
        const int row = column < 0 ? -1 : row_of(column);
        if (row < 0) continue;
        value += values[2][k] * U.row(row).transpose();
        derivative += derivatives[2][k] * U.row(row).transpose();
      }
      by_c.col(0) += derivatives[0][i] * values[1][j] * value;
      by_c.col(1) += values[0][i] * derivatives[1][j] * value;
      by_c.col(2) += values[0][i] * values[1][j] * derivative;
    }
  }
  *gradient += by_c * box.lengths.cwiseInverse().asDiagonal() * box.axes.transpose();
}

}  // namespace

InversionDetector::InversionDetector(const Lattice& lattice, const Lattice* finer,
                                     const Quadrature& tissue)
    : lattice_(lattice), volume_(tissue.weights.sum()) {
  const Grid groups = GroupsOf(lattice);
  std::map<Grid, std::vector<Eigen::Index>> points_of;
  for (Eigen::Index q = 0; q < tissue.points.rows(); ++q) {
    const Vector3d c = lattice.box().ToUnit(tissue.points.row(q).transpose());
    Grid at;
    for (int d = 0; d < 3; ++d) {
      at[d] = std::clamp(static_cast<int>(c[d] * groups[d]), 0, groups[d] - 1);
    }
    points_of[at].push_back(q);
  }
  points_.resize(tissue.points.rows(), 3);
  weights_.resize(tissue.weights.size());
  Eigen::Index next = 0;
  for (const auto& [at, members] : points_of) {
    Cell cell;
    cell.begin = next;
    for (const Eigen::Index q : members) {
      points_.row(next) = tissue.points.row(q);
      weights_[next++] = tissue.weights[q];
    }
    cell.end = next;
    cells_.push_back(std::move(cell));
  }
  for (int axis = 0; axis < 3; ++axis) {
    PairsByIndex numbers;
    for (Cell& cell : cells_) AddCell(axis, &numbers, &cell);
    SortPairs(axis, numbers);
  }
  for (const Lattice& level : lattice_.levels()) level_slopes_.push_back(SlopesOf(level));
  if (finer == nullptr) return;
  finer_.emplace(*finer);
  local_slopes_ = SlopesOf(*finer_);
}

// Appends the pairs that move points of the cell and are not among `numbers`, in no order.
void InversionDetector::AddCell(int axis, PairsByIndex* numbers, Cell* cell) {
  std::map<int, double> weights;
  for (Eigen::Index q = cell->begin; q < cell->end; ++q) {
    ForEachDifference(lattice_, axis, points_.row(q).transpose(),
                      [&](int index, int a, int b, double value) {
                        if (a < 0 && b < 0) return;
                        double& weight = weights[PairNumber(axis, index, {a, b}, numbers)];
                        weight = std::max(weight, value);
                      });
  }
  for (const auto& [pair, weight] : weights) {
    if (weight >= kFirm) {
      cell->firm[axis].push_back(pair);
    } else if (weight > 0) {
      cell->loose[axis].push_back({pair, weight});
    }
  }
}

int InversionDetector::PairNumber(int axis, int index, const Pair& pair, PairsByIndex* numbers) {
  const auto at = static_cast<std::size_t>(index);
  if (numbers->size() <= at) numbers->resize(at + 1);
  for (const int number : (*numbers)[at]) {
    const Pair& known = pairs_[axis][static_cast<std::size_t>(number)];
    if (known.a == pair.a && known.b == pair.b) return number;
  }
  (*numbers)[at].push_back(static_cast<int>(pairs_[axis].size()));
  pairs_[axis].push_back(pair);
  return (*numbers)[at].back();
}

// Numbers the pairs in the order of the grid.
void InversionDetector::SortPairs(int axis, const PairsByIndex& numbers) {
  std::vector<Pair> sorted;
  std::vector<int> place(pairs_[axis].size());
  for (const std::vector<int>& at : numbers) {
    for (const int number : at) {
      place[static_cast<std::size_t>(number)] = static_cast<int>(sorted.size());
      sorted.push_back(pairs_[axis][static_cast<std::size_t>(number)]);
    }
  }
  pairs_[axis] = std::move(sorted);
  for (Cell& cell : cells_) {
    for (int& pair : cell.firm[axis]) pair = place[static_cast<std::size_t>(pair)];
    for (Weighed& loose : cell.loose[axis])
      loose.pair = place[static_cast<std::size_t>(loose.pair)];
    std::sort(cell.firm[axis].begin(), cell.firm[axis].end());
    std::sort(cell.loose[axis].begin(), cell.loose[axis].end(),
              [](const Weighed& a, const Weighed& b) { return a.pair < b.pair; });
  }
}

// Returns for each function the cells that it moves, with its largest gradient there.
std::vector<std::vector<InversionDetector::CellSlope>> InversionDetector::SlopesOf(
    const Lattice& lattice) const {
  std::vector<std::vector<CellSlope>> slopes_of(static_cast<std::size_t>(lattice.size()));
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    std::map<int, double> slopes;
    for (Eigen::Index q = cells_[i].begin; q < cells_[i].end; ++q) {
      lattice.ForEachGradient(points_.row(q).transpose(),
                              [&](int function, const Vector3d& gradient) {
                                double& slope = slopes[function];
                                slope = std::max(slope, gradient.norm());
                              });
    }
    for (const auto& [function, slope] : slopes) {
      slopes_of[static_cast<std::size_t>(function)].push_back({i, slope});
    }
  }
  return slopes_of;
}

InversionDetector::ScanState::ScanState(const InversionDetector& detector)
    : local(detector.cells_.size()), clear(detector.cells_.size()) {
  for (int axis = 0; axis < 3; ++axis) slopes[axis].resize(detector.pairs_[axis].size());
}

bool InversionDetector::Inverted(const ActiveRefinement& active, const Points& U, int calls,
                                 ScanState* scan) const {
  MeasureSlopes(active, U, scan);
  Eigen::Index unclear = 0;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    scan->clear[i] = Clear(i, *scan);
    if (!scan->clear[i]) unclear += cells_[i].end - cells_[i].begin;
  }
  Eigen::Index left = std::max(kMinPointsPerCall, unclear / calls + 1);
  for (; scan->cell < cells_.size(); ++scan->cell, scan->point = 0) {
    if (scan->clear[scan->cell]) continue;
    const Cell& cell = cells_[scan->cell];
    for (; cell.begin + scan->point < cell.end; ++scan->point) {
      if (left-- == 0) return scan->found > 0 || scan->share > 0;
      const Eigen::Index q = cell.begin + scan->point;
      if (!(Determinant(q, active, U) > 0)) scan->found += weights_[q];
    }
  }
  scan->share = scan->found / volume_;
  scan->cell = 0;
  scan->point = 0;
  scan->found = 0;
  return scan->share > 0;
}

InversionDetector::Inversion InversionDetector::EvaluateAll(const ActiveRefinement& active,
                                                            const Points& U) const {
  Inversion inversion;
  for (Eigen::Index q = 0; q < points_.rows(); ++q) {
    const double determinant = Determinant(q, active, U);
    inversion.least = std::min(inversion.least, determinant);
    if (!(determinant > 0)) inversion.share += weights_[q] / volume_;
  }
  return inversion;
}

void InversionDetector::MeasureSlopes(const ActiveRefinement& active, const Points& U,
                                      ScanState* scan) const {
  for (int axis = 0; axis < 3; ++axis) {
    const double inverse =
        1 / (lattice_.box().lengths[axis] * lattice_.basis().axis(axis).spacing());
    for (std::size_t i = 0; i < pairs_[axis].size(); ++i) {
      const auto& [a, b] = pairs_[axis][i];
      const double length = a < 0   ? U.row(b).norm()
                            : b < 0 ? U.row(a).norm()
                                    : (U.row(b) - U.row(a)).norm();
      scan->slopes[axis][i] = inverse * length;
    }
  }
  std::fill(scan->local.begin(), scan->local.end(), 0.0);
  for (std::size_t level = 0; level < level_slopes_.size(); ++level) {
    Eigen::Index row = lattice_.FirstColumn(level);
    for (const std::vector<CellSlope>& slopes : level_slopes_[level]) {
      const double length = U.row(row++).norm();
      for (const auto& [cell, slope] : slopes) scan->local[cell] += length * slope;
    }
  }
  const auto n = U.rows() - active.slots();
  for (int slot = 0; slot < active.slots(); ++slot) {
    if (active.Function(slot) < 0) continue;
    const double length = U.row(n + slot).norm();
    for (const auto& [cell, slope] : local_slopes_[active.Function(slot)]) {
      scan->local[cell] += length * slope;
    }
  }
}

bool InversionDetector::Clear(std::size_t index, const ScanState& scan) const {
  const Cell& cell = cells_[index];
  double gradient2 = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& slopes = scan.slopes[axis];
    double slope = 0;
    for (const int pair : cell.firm[axis]) slope = std::max(slope, slopes[pair]);
    for (const auto& [pair, weight] : cell.loose[axis]) slope += weight * slopes[pair];
    gradient2 += slope * slope;
  }
  return std::sqrt(gradient2) + scan.local[index] < 1;
}

double InversionDetector::LargestGradient(const ActiveRefinement& active, const Points& U,
                                          ScanState* scan) const {
  const Eigen::Index samples = std::min<Eigen::Index>(kSamples, points());
  double largest = 0;
  for (Eigen::Index i = scan->part; i < samples; i += kParts) {
    largest = std::max(largest, Gradient(i * points() / samples, active, U).norm());
  }
  scan->gradients[static_cast<std::size_t>(scan->part)] = largest;
  scan->part = (scan->part + 1) % kParts;
  return *std::max_element(scan->gradients.begin(), scan->gradients.end());
}

Matrix3d InversionDetector::Gradient(Eigen::Index q, const ActiveRefinement& active,
                                     const Points& U) const {
  const Vector3d p = points_.row(q);
  Matrix3d gradient = Matrix3d::Zero();
  AddGradient(
      lattice_, p, [](int column) { return column; }, U, &gradient);
  for (std::size_t level = 0; level < lattice_.levels().size(); ++level) {
    const int first = lattice_.FirstColumn(level);
    AddGradient(
        lattice_.levels()[level], p, [first](int column) { return first + column; }, U, &gradient);
  }
  if (finer_) {
    const int n = static_cast<int>(U.rows()) - active.slots();
    const auto row = [&](int function) {
      const int slot = active.Slot(function);
      return slot < 0 ? -1 : n + slot;
    };
    AddGradient(*finer_, p, row, U, &gradient);
  }
  return gradient;
}

double InversionDetector::Determinant(Eigen::Index q, const ActiveRefinement& active,
                                      const Points& U) const {
  return (Matrix3d::Identity() + Gradient(q, active, U)).determinant();
}

}  // namespace hpdm
