#include "engine/lattice/lattice.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "engine/base/check.h"

namespace hpdm {
namespace {

// Control points per function beyond which nothing is split: forty shells in each other would need
// thirty, and a dense matrix of a thousand times the size.
constexpr int kMostPerFunction = 3;

constexpr double kLeastOfFunction = 0.01;

// Returns the component whose copy each component takes. Where the function has less than
// kLeastOfFunction of its integral, its copy would have next to no stiffness, and a load that touches it
// would move it far. So that component takes the copy of the one with most, if tissue in a cell around
// the support joins the two. Sides of a cut and separate bodies are never tied.
std::vector<int> JoinSlivers(const TensorBasis& basis, const std::array<int, 3>& at,
                             const TissuePieces& pieces, const TissuePieces::Components& components,
                             const std::array<int, 3>& finer) {
  std::vector<int> joined(static_cast<std::size_t>(components.count));
  std::iota(joined.begin(), joined.end(), 0);
  if (joined.size() < 2) return joined;
  const std::array<int, 3>& cells = pieces.data().cells;
  std::array<std::vector<double>, 3> values;  // of the function at the centres of the pieces' cells
  std::array<double, TensorBasis::kMaxSupport> all;
  for (int d = 0; d < 3; ++d) {
    for (int cell = 0; cell < cells[d]; ++cell) {
      const int local = at[d] - basis.axis(d).Evaluate((cell + 0.5) / cells[d], all.data());
      const bool supports = local >= 0 && local < basis.axis(d).support();
      values[d].push_back(supports ? all[static_cast<std::size_t>(local)] : 0);
    }
  }
  std::vector<double> share(joined.size());
  for (const auto& [piece, component] : components.of_piece) {
    const int cell = pieces.Cell(piece);
    const double value = values[0][static_cast<std::size_t>(cell % cells[0])] *
                         values[1][static_cast<std::size_t>(cell / cells[0] % cells[1])] *
                         values[2][static_cast<std::size_t>(cell / (cells[0] * cells[1]))];
    share[static_cast<std::size_t>(component)] +=
        value * pieces.data().volumes[static_cast<std::size_t>(piece)] /
        (finer[0] * finer[1] * finer[2]);
  }
  const auto is_sliver = [](double part) { return part < kLeastOfFunction; };
  if (std::none_of(share.begin(), share.end(), is_sliver)) return joined;
  CellRange around;
  for (int d = 0; d < 3; ++d) {
    around.low[d] = finer[d] * std::max(at[d] - basis.axis(d).degree() - 1, 0);
    around.high[d] = std::min(finer[d] * (at[d] + 2), cells[d]) - 1;
  }
  std::map<int, int> wider;  // piece to component
  for (const auto& [piece, component] : pieces.Connected(around, 0).of_piece) {
    wider[piece] = component;
  }
  std::vector<int> of_component(share.size());
  for (const auto& [piece, component] : components.of_piece) {
    of_component[static_cast<std::size_t>(component)] = wider.at(piece);
  }
  const auto most =
      static_cast<std::size_t>(std::max_element(share.begin(), share.end()) - share.begin());
  for (std::size_t c = 0; c < share.size(); ++c) {
    if (is_sliver(share[c]) && of_component[c] == of_component[most]) {
      joined[c] = static_cast<int>(most);
    }
  }
  return joined;
}

}  // namespace

Lattice::Lattice(const OrientedBox& box, const LatticeOptions& options)
    : box_(box), basis_(options), kept_(basis_.count()), column_(basis_.count()) {
  HPDM_CHECK((box.lengths.array() > 0).all());
  std::iota(kept_.begin(), kept_.end(), 0);
  std::iota(column_.begin(), column_.end(), 0);
}

void Lattice::DropControlPointsWithoutTissue(const Quadrature& tissue) {
  const WeightMatrix weights = Weights(tissue.points);
  const Eigen::VectorXd volume = weights.transpose() * tissue.weights;
  const double cell_volume =
      box_.Volume() / (basis_.axis(0).cells() * basis_.axis(1).cells() * basis_.axis(2).cells());
  std::vector<bool> drop(size());
  for (int a = 0; a < size(); ++a) drop[a] = !(volume[a] > 1e-9 * cell_volume);
  DropControlPoints(drop);
}

void Lattice::DropControlPoints(const std::vector<bool>& drop) {
  HPDM_CHECK(static_cast<int>(drop.size()) == size() && fronts_.empty());
  auto begin = drop.begin() + static_cast<std::ptrdiff_t>(kept_.size());
  level_functions_ = 0;
  for (Lattice& level : levels_) {
    const auto end = begin + level.size();
    level.DropControlPoints({begin, end});
    level_functions_ += level.size();
    begin = end;
  }
  std::vector<int> kept, number;
  for (std::size_t a = 0; a < kept_.size(); ++a) {
    number.push_back(drop[a] ? -1 : static_cast<int>(kept.size()));
    if (!drop[a]) kept.push_back(kept_[a]);
  }
  kept_ = std::move(kept);
  column_.assign(basis_.count(), -1);
  for (int a = static_cast<int>(kept_.size()) - 1; a >= 0; --a) column_[kept_[a]] = a;
  for (int& column : piece_columns_) {
    if (column >= 0) column = number[column];
  }
}

void Lattice::SplitByTissue(std::shared_ptr<const TissuePieces> pieces, int beyond) {
  HPDM_CHECK(size() == basis_.count() && pieces != nullptr && !pieces->empty());
  pieces_ = std::move(pieces);
  std::array<int, 3> finer;  // cells of the pieces in a cell of the lattice, along each axis
  for (int d = 0; d < 3; ++d) {
    HPDM_CHECK(basis_.axis(d).type() == BasisType::kBSpline);
    finer[d] = pieces_->data().cells[d] / basis_.axis(d).cells();
    HPDM_CHECK(finer[d] * basis_.axis(d).cells() == pieces_->data().cells[d]);
  }
  const double sliver = TissuePieces::kSliver * finer[0] * finer[1] * finer[2];
  std::vector<int> columns(static_cast<std::size_t>(pieces_->size()) * basis_.support(), -1);
  kept_.clear();
  std::array<int, 3> at;
  for (at[0] = 0; at[0] < basis_.axis(0).count(); ++at[0]) {
    for (at[1] = 0; at[1] < basis_.axis(1).count(); ++at[1]) {
      for (at[2] = 0; at[2] < basis_.axis(2).count(); ++at[2]) {
        CellRange range;
        for (int d = 0; d < 3; ++d) {
          const int cells = basis_.axis(d).cells();
          range.low[d] = finer[d] * std::max(at[d] - basis_.axis(d).degree() - beyond, 0);
          range.high[d] = finer[d] * (std::min(at[d] + beyond, cells - 1) + 1) - 1;
        }
        AddCopies(at, pieces_->Connected(range, sliver), finer, &columns);
      }
    }
  }
  if (size() > kMostPerFunction * basis_.count()) {
    kept_.resize(static_cast<std::size_t>(basis_.count()));
    std::iota(kept_.begin(), kept_.end(), 0);
    pieces_.reset();
  }
  column_.assign(basis_.count(), -1);
  for (int a = size() - 1; a >= 0; --a) column_[kept_[a]] = a;
  if (size() == basis_.count()) return;
  piece_columns_ = std::move(columns);
  inset_ = InsetOf(*pieces_);
}

double Lattice::InsetOf(const TissuePieces& pieces) const {
  return 0.75 * pieces.VoxelSize().cwiseProduct(box_.lengths).maxCoeff();
}

// Appends the control points of the function `at`, one for each component, and sets them in the
// `columns` of the pieces in its support.
void Lattice::AddCopies(const std::array<int, 3>& at, const TissuePieces::Components& components,
                        const std::array<int, 3>& finer, std::vector<int>* columns) {
  const int index = basis_.Index(at[0], at[1], at[2]), first = size();
  const std::array<int, 3>& cells = pieces_->data().cells;
  const std::vector<int> joined = JoinSlivers(basis_, at, *pieces_, components, finer);
  std::vector<int> copy(static_cast<std::size_t>(components.count), -1);
  for (const auto& [piece, component] : components.of_piece) {
    const int cell = pieces_->Cell(piece);
    const std::array<int, 3> place = {cell % cells[0], cell / cells[0] % cells[1],
                                      cell / (cells[0] * cells[1])};
    std::array<int, 3> local;  // number of the function among those of the piece's cell
    bool supports = true;
    for (int d = 0; d < 3; ++d) {
      local[d] = at[d] - place[d] / finer[d];
      supports = supports && local[d] >= 0 && local[d] < basis_.axis(d).support();
    }
    if (!supports) continue;
    int& column = copy[static_cast<std::size_t>(joined[static_cast<std::size_t>(component)])];
    if (column < 0) {
      column = size();
      kept_.push_back(index);
    }
    const int function =
        (local[0] * basis_.axis(1).support() + local[1]) * basis_.axis(2).support() + local[2];
    (*columns)[static_cast<std::size_t>(piece) * basis_.support() + function] = column;
  }
  if (size() == first) kept_.push_back(index);  // no tissue
}

double Lattice::FrontLength() const {
  return box_.lengths
      .cwiseQuotient(
          Vector3d(basis_.axis(0).cells(), basis_.axis(1).cells(), basis_.axis(2).cells()))
      .mean();
}

// Returns the grid indices of the functions that get front functions, ascending.
std::vector<int> Lattice::FunctionsAtFront(const CutSurface& cut) const {
  std::vector<Vector3d> front, sheet;  // in cells
  const Vector3d cells(basis_.axis(0).cells(), basis_.axis(1).cells(), basis_.axis(2).cells());
  for (const Vector3d& p_W : cut.front_points()) {
    front.push_back(box_.ToUnit(p_W).cwiseProduct(cells));
  }
  for (const CutSurface::Sample& sample : cut.samples()) {
    sheet.push_back(box_.ToUnit(sample.p_W).cwiseProduct(cells));
  }
  std::vector<int> found;
  std::array<int, 3> at;
  for (at[0] = 0; at[0] < basis_.axis(0).count(); ++at[0]) {
    for (at[1] = 0; at[1] < basis_.axis(1).count(); ++at[1]) {
      for (at[2] = 0; at[2] < basis_.axis(2).count(); ++at[2]) {
        const int index = basis_.Index(at[0], at[1], at[2]);
        if (column_[index] < 0) continue;
        Eigen::Array3d low, high;  // of the support
        for (int d = 0; d < 3; ++d) {
          low[d] = at[d] - basis_.axis(d).degree();
          high[d] = at[d] + 1;
        }
        const auto near = [&](double reach) {
          return [&low, &high, reach](const Vector3d& p) {
            return (p.array() > low - reach).all() && (p.array() < high + reach).all();
          };
        };
        const bool holds = std::any_of(front.begin(), front.end(), near(0));
        if (holds || (std::any_of(front.begin(), front.end(), near(1)) &&
                      std::any_of(sheet.begin(), sheet.end(), near(0)))) {
          found.push_back(index);
        }
      }
    }
  }
  return found;
}

void Lattice::AddFrontFunctions() {
  HPDM_CHECK(pieces_ != nullptr && pieces_->cuts() != nullptr && fronts_.empty());
  inset_ = InsetOf(*pieces_);
  const std::vector<CutSurface>& cuts = *pieces_->cuts();
  for (std::size_t cut = 0; cut < cuts.size(); ++cut) {
    Front front{static_cast<int>(cut),
                std::vector<int>(static_cast<std::size_t>(basis_.count()), -1)};
    for (const int index : FunctionsAtFront(cuts[cut])) {
      front.columns[static_cast<std::size_t>(index)] = size();
      kept_.insert(kept_.end(), 2, index);
      front_functions_ += 2;
    }
    if (cuts[cut].has_front()) fronts_.push_back(std::move(front));
  }
}

void Lattice::AddLevel(Lattice level) {
  for (int d = 0; d < 3; ++d) {
    const UnivariateBasis &coarse = Finest().basis_.axis(d), &fine = level.basis_.axis(d);
    HPDM_CHECK(fine.type() == BasisType::kBSpline && coarse.type() == BasisType::kBSpline);
    HPDM_CHECK(fine.degree() == coarse.degree() && fine.cells() % coarse.cells() == 0);
  }
  HPDM_CHECK(level.levels_.empty() && level.fronts_.empty());
  // A gap that only finer functions see.
  inset_ = std::max(inset_, level.inset_);
  level_functions_ += level.size();
  levels_.push_back(std::move(level));
}

int Lattice::FirstColumn(std::size_t level) const {
  auto column = static_cast<int>(kept_.size());
  for (std::size_t l = 0; l < level; ++l) column += levels_[l].size();
  return column;
}

int Lattice::FunctionsAtPoint() const {
  const int own = basis_.support() * (1 + 2 * static_cast<int>(fronts_.size()));
  return std::min(own + basis_.support() * static_cast<int>(levels_.size()), size());
}

Lattice::Site Lattice::SiteOf(const Vector3d& p_W, const Vector3d& inside_W) const {
  Site site{.c = box_.ToUnit(p_W), .p_W = p_W, .side_W = inside_W};
  if (!split() && fronts_.empty()) return site;
  if (pieces_->cuts() != nullptr) {
    const CutSurface& any = pieces_->cuts()->front();
    // A surface that is oblique to a cut: the point inside lies on the other side of it.
    if (CrossesAny(*pieces_->cuts(), any.At(p_W), any.At(inside_W))) site.side_W = p_W;
  }
  if (!split()) return site;
  const int piece = pieces_->At(box_.ToUnit(site.side_W));
  if (piece < 0) return site;
  site.columns = &piece_columns_[static_cast<std::size_t>(piece) * basis_.support()];
  // The functions are those of the piece's cell. A point outside of that, by less than a voxel, gets
  // their values on the cell's face.
  const std::array<int, 3>& cells = pieces_->data().cells;
  const int cell = pieces_->Cell(piece);
  const std::array<int, 3> place = {cell % cells[0], cell / cells[0] % cells[1],
                                    cell / (cells[0] * cells[1])};
  for (int d = 0; d < 3; ++d) {
    const int count = basis_.axis(d).cells();
    const int own = place[d] / (cells[d] / count);
    const double scaled = std::clamp(site.c[d], 0.0, 1.0) * count;
    if (std::min(static_cast<int>(scaled), count - 1) == own) continue;
    constexpr double kInside = 1e-12;  // keeps rounding from the next cell
    site.c[d] = std::clamp(scaled, own + kInside, own + 1 - kInside) / count;
  }
  return site;
}

Points Lattice::ControlPoints() const {
  const int ny = basis_.axis(1).count();
  const int nz = basis_.axis(2).count();
  Points points(size(), 3);
  for (std::size_t a = 0; a < kept_.size(); ++a) {
    const int i = kept_[a] / (ny * nz), j = kept_[a] / nz % ny, k = kept_[a] % nz;
    points.row(static_cast<Eigen::Index>(a)) = box_.FromUnit(Vector3d(
        basis_.axis(0).Greville(i), basis_.axis(1).Greville(j), basis_.axis(2).Greville(k)));
  }
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    points.middleRows(FirstColumn(l), levels_[l].size()) = levels_[l].ControlPoints();
  }
  return points;
}

WeightMatrix Lattice::Weights(const Points& points, const Points& inside) const {
  HPDM_CHECK(inside.rows() == points.rows());
  WeightMatrix weights(points.rows(), size());
  weights.reserve(Eigen::VectorXi::Constant(points.rows(), FunctionsAtPoint()));
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    ForEachFunction(SiteOf(points.row(v).transpose(), inside.row(v).transpose()),
                    [&](int column, double value) { weights.insert(v, column) = value; });
  }
  weights.makeCompressed();
  return weights;
}

std::array<WeightMatrix, 3> Lattice::GradientWeights(const Points& points) const {
  std::array<WeightMatrix, 3> gradients;
  for (WeightMatrix& gradient : gradients) {
    gradient.resize(points.rows(), size());
    gradient.reserve(Eigen::VectorXi::Constant(points.rows(), FunctionsAtPoint()));
  }
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    ForEachGradient(points.row(v).transpose(), [&](int column, const Vector3d& gradient) {
      for (int d = 0; d < 3; ++d) gradients[d].insert(v, column) = gradient[d];
    });
  }
  for (WeightMatrix& gradient : gradients) gradient.makeCompressed();
  return gradients;
}

OrientedBox BoundingLatticeBox(const Points& vertices, const Matrix3d& axes, double margin) {
  HPDM_CHECK(vertices.rows() > 0);
  const Points local = vertices * axes;
  const Vector3d low = local.colwise().minCoeff().transpose().array() - margin;
  const Vector3d high = local.colwise().maxCoeff().transpose().array() + margin;
  return {.origin_W = axes * low, .axes = axes, .lengths = high - low};
}

}  // namespace hpdm
