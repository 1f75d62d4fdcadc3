#include "engine/solver/refinement_basis.h"

#include <array>
#include <cstdio>

#include "engine/base/error.h"
#include "engine/energy/mixed_dilatation.h"
#include "engine/solver/compliance_solver.h"

namespace hpdm {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

// Larger couplings are refused before their memory is reserved, as organ.cc does for a lattice.
constexpr double kMaxCouplingBytes = 2e9;

// Cells around a function's support in which its tissue may be joined.
constexpr int kBeyondSupport = 1;

Lattice FinerLattice(const Lattice& lattice, int refinement, const Quadrature& tissue,
                     const std::vector<Quadrature>& regions, double least_tissue) {
  LatticeOptions options;
  options.basis = lattice.basis().axis(0).type();
  for (int d = 0; d < 3; ++d) {
    options.degree[d] = lattice.basis().axis(d).degree();
    options.cells[d] = refinement * lattice.basis().axis(d).cells();
  }
  Lattice finer(lattice.box(), options);
  // Tissue that is apart in a support but joined beside it would hang on nothing.
  if (lattice.pieces() != nullptr) finer.SplitByTissue(lattice.pieces(), kBeyondSupport);
  finer.DropControlPointsWithoutTissue(tissue);
  std::vector<bool> held(finer.size());
  for (const Quadrature& region : regions) {
    for (Eigen::Index q = 0; q < region.points.rows(); ++q) {
      finer.ForEachFunction(region.points.row(q).transpose(),
                            [&held](int column, double) { held[column] = true; });
    }
  }
  if (least_tissue > 0) {
    const Eigen::VectorXd volumes = finer.Weights(tissue.points).transpose() * tissue.weights;
    double cell = lattice.box().lengths.prod();  // the integral of a whole function
    for (const int cells : options.cells) cell /= cells;
    for (int a = 0; a < finer.size(); ++a) held[a] = held[a] || volumes[a] < least_tissue * cell;
  }
  // A level of the lattice with the same cells has them already.
  for (const Lattice& level : lattice.levels()) {
    if (level.basis().axis(0).cells() != options.cells[0]) continue;
    for (int a = 0; a < finer.size(); ++a) {
      held[a] = held[a] || level.Column(finer.kept()[static_cast<std::size_t>(a)]) >= 0;
    }
  }
  finer.DropControlPoints(held);
  if (lattice.front_functions() > 0) finer.AddFrontFunctions();
  const double bytes = 8.0 * (3.0 * lattice.size()) * (3.0 * finer.size());
  if (bytes > kMaxCouplingBytes) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "local functions need %.1f GB, beyond the %.0f GB allowed; give fewer cells, a "
                  "lower local_refinement or local_functions = 0",
                  bytes / 1e9, kMaxCouplingBytes / 1e9);
    throw InputError(text);
  }
  return finer;
}

auto Collect(Triplets* triplets, Eigen::Index first_row = 0) {
  return [triplets, first_row](Eigen::Index row, Eigen::Index column, double value) {
    triplets->emplace_back(static_cast<int>(first_row + row), static_cast<int>(column), value);
  };
}

void AddEntries(const WeightMatrix& matrix, Eigen::Index first_row, Triplets* triplets) {
  const auto add = Collect(triplets, first_row);
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (WeightMatrix::InnerIterator it(matrix, row); it; ++it) add(row, it.col(), it.value());
  }
}

}  // namespace

RefinementBasis::RefinementBasis(const Lattice& lattice, const LocalFunctionOptions& options,
                                 const Quadrature& tissue, const MaterialOptions& material,
                                 Dilatation dilatation, const std::vector<Quadrature>& regions,
                                 const FullStiffness& K, double least_tissue,
                                 const FillingsAndLayers& surface)
    : finer_(FinerLattice(lattice, options.refinement, tissue, regions, least_tissue)),
      centres_(finer_.ControlPoints()),
      inverse_(InverseStiffness(
          K, "add an [[organ.support]], use fewer cells, a lower degree or a lower poisson")),
      filling_(surface.FillingRows(finer_)) {
  const LameParameters lame = ToLame(material);
  const auto [pointwise, projected] = ShareLambda(lame, dilatation);
  const std::array<WeightMatrix, 3> gradients = lattice.GradientWeights(tissue.points);
  const std::array<WeightMatrix, 3> finer_gradients = finer_.GradientWeights(tissue.points);
  const Eigen::Index unknowns = K.rows(), columns = 3 * static_cast<Eigen::Index>(size());

  Triplets own;
  AddElasticBlocks(finer_gradients, finer_gradients, tissue.weights, lame, Collect(&own));
  const WeightMatrix layers = surface.LayerRows(finer_);
  if (layers.rows() > 0) {
    AddEntries(WeightMatrix(layers.transpose() * layers), 0, &own);
  }
  own_.resize(columns, columns);
  own_.setFromTriplets(own.begin(), own.end());

  Triplets sparse;
  AddElasticBlocks(gradients, finer_gradients, tissue.weights, {lame.mu, pointwise},
                   Collect(&sparse));
  if (layers.rows() > 0) {
    AddEntries(WeightMatrix(surface.LayerRows(lattice).transpose() * layers), 0, &sparse);
  }
  Eigen::MatrixXd H(0, unknowns);
  if (projected > 0) {
    const CoarserSplines splines(lattice, tissue);
    H = projected * ProjectedDilatation(lattice, tissue);
    splines.factor().triangularView<Eigen::Lower>().adjoint().solveInPlace(H);
    for (int d = 0; d < 3; ++d) {
      const WeightMatrix moments = splines.Moments(finer_gradients[d]);
      for (Eigen::Index b = 0; b < moments.rows(); ++b) {
        for (WeightMatrix::InnerIterator it(moments, b); it; ++it) {
          Collect(&sparse, unknowns)(b, 3 * it.index() + d, it.value());
        }
      }
    }
  }
  if (filling_.rows() > 0) {
    AddEntries(WeightMatrix(filling_.sparseView()), unknowns + H.rows(), &sparse);
    const Eigen::MatrixXd projection = H;
    H.resize(projection.rows() + filling_.rows(), unknowns);
    H << projection, surface.FillingRows(lattice);
  }
  sparse_.resize(unknowns + H.rows(), columns);
  sparse_.setFromTriplets(sparse.begin(), sparse.end());

  Eigen::MatrixXd Z(unknowns + H.rows(), unknowns + H.rows());
  Z.topLeftCorner(unknowns, unknowns) = inverse_;
  Z.bottomLeftCorner(H.rows(), unknowns).noalias() = H * inverse_;
  Z.topRightCorner(unknowns, H.rows()) = Z.bottomLeftCorner(H.rows(), unknowns).transpose();
  Z.bottomRightCorner(H.rows(), H.rows()).noalias() =
      Z.bottomLeftCorner(H.rows(), unknowns) * H.transpose();
  coupling_.noalias() = Z * sparse_;
}

Matrix3d RefinementBasis::ReducedStiffness(int a, int b) const {
  Matrix3d S;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      double sum = own_.coeff(3 * a + i, 3 * b + j);
      for (Eigen::Index l = 0; l < filling_.rows(); ++l) {
        sum += filling_(l, 3 * a + i) * filling_(l, 3 * b + j);
      }
      for (Eigen::SparseMatrix<double>::InnerIterator it(sparse_, 3 * a + i); it; ++it) {
        sum -= it.value() * coupling_(it.index(), 3 * b + j);
      }
      S(i, j) = sum;
    }
  }
  return S;
}

}  // namespace hpdm
