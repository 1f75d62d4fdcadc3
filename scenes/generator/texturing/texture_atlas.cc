#include "scenes/generator/texturing/texture_atlas.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "scenes/generator/texturing/texture_charts.h"

namespace hpdm {
namespace {

using Index = Eigen::Index;

constexpr double kHiddenScale = 0.25;

/// A chart in its own plane, in texels, with its lower left corner inside the gutter at (0, 0).
struct Piece {
  TextureCoordinates corners;    ///< Three rows a triangle, as in the chart.
  std::vector<int> bottom, top;  ///< Texels taken in each column, gutter included: [bottom, top).
  int left = 0, low = 0;         ///< Its place.
  int Width() const { return static_cast<int>(bottom.size()); }
  int Height() const { return *std::max_element(top.begin(), top.end()); }
};

/// Widens the rows that a piece occupies in each column by those of a triangle.
void CoverColumns(const Eigen::Matrix<double, 3, 2>& triangle, std::vector<double>* low,
                  std::vector<double>* high) {
  for (int side = 0; side < 3; ++side) {
    Eigen::RowVector2d a = triangle.row(side), b = triangle.row((side + 1) % 3);
    if (a.x() > b.x()) a.swap(b);
    const double slope = b.x() > a.x() ? (b.y() - a.y()) / (b.x() - a.x()) : 0;
    const int last = std::min(static_cast<int>(b.x()), static_cast<int>(low->size()) - 1);
    for (int column = static_cast<int>(a.x()); column <= last; ++column) {
      const double from = std::max(a.x(), static_cast<double>(column));
      const double to = std::min(b.x(), static_cast<double>(column + 1));
      const double y_from = a.y() + slope * (from - a.x());
      const double y_to = b.x() > a.x() ? a.y() + slope * (to - a.x()) : b.y();
      (*low)[ToSize(column)] = std::min({(*low)[ToSize(column)], y_from, y_to});
      (*high)[ToSize(column)] = std::max({(*high)[ToSize(column)], y_from, y_to});
    }
  }
}

Piece MakePiece(const SurfaceMesh& mesh, const TextureChart& chart, double scale) {
  Piece piece;
  piece.corners.resize(3 * static_cast<Index>(chart.triangles.size()), 2);
  Index row = 0;
  for (const int t : chart.triangles) {
    for (int c = 0; c < 3; ++c) {
      const Vector3d p = mesh.vertices.row(mesh.triangles(t, c));
      piece.corners.row(row++) = scale * ChartPlane(chart.axis, p).transpose();
    }
  }
  // All pieces stand upright: tall ones side by side waste less space than tall and wide ones
  // together.
  const Eigen::RowVector2d size =
      piece.corners.colwise().maxCoeff() - piece.corners.colwise().minCoeff();
  if (size.x() > size.y()) {
    piece.corners.col(0).swap(piece.corners.col(1));
    piece.corners.col(0) *= -1;
  }
  const Eigen::RowVector2d origin = piece.corners.colwise().minCoeff();
  piece.corners.rowwise() -= origin - Eigen::RowVector2d::Constant(kTextureGutter);
  const int width = static_cast<int>(std::ceil(piece.corners.col(0).maxCoeff())) + kTextureGutter;
  std::vector<double> low(ToSize(width), std::numeric_limits<double>::max()),
      high(ToSize(width), 0);
  for (row = 0; row < piece.corners.rows(); row += 3) {
    CoverColumns(piece.corners.middleRows<3>(row), &low, &high);
  }
  for (int column = 0; column < width; ++column) {
    const auto first = std::max(column - kTextureGutter, 0);
    const auto end = std::min(column + kTextureGutter + 1, width);
    piece.bottom.push_back(
        static_cast<int>(*std::min_element(low.begin() + first, low.begin() + end)) -
        kTextureGutter);
    piece.top.push_back(
        static_cast<int>(std::ceil(*std::max_element(high.begin() + first, high.begin() + end))) +
        kTextureGutter);
  }
  return piece;
}

/// Places the pieces from tall to short, each where its top is lowest. Returns false if the square
/// is too small.
bool LayOut(std::vector<Piece>* pieces) {
  std::vector<std::size_t> order(pieces->size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return (*pieces)[i].Height() > (*pieces)[j].Height();
  });
  std::vector<int> horizon(kTextureSize);
  for (const std::size_t i : order) {
    Piece& piece = (*pieces)[i];
    int best = kTextureSize - piece.Height() + 1;
    for (int left = 0; left + piece.Width() <= kTextureSize; ++left) {
      int low = 0;
      for (int column = 0; column < piece.Width(); ++column) {
        low = std::max(low, horizon[ToSize(left + column)] - piece.bottom[ToSize(column)]);
      }
      if (low >= best) continue;
      best = low;
      piece.left = left;
    }
    if (best + piece.Height() > kTextureSize) return false;
    piece.low = best;
    for (int column = 0; column < piece.Width(); ++column) {
      horizon[ToSize(piece.left + column)] = piece.low + piece.top[ToSize(column)];
    }
  }
  return true;
}

}  // namespace

TextureCoordinates MakeTextureAtlas(const SurfaceMesh& mesh, Index first_hidden) {
  const std::vector<TextureChart> charts = CutIntoCharts(mesh);
  const Eigen::RowVector3d size =
      mesh.vertices.colwise().maxCoeff() - mesh.vertices.colwise().minCoeff();
  // A single chart fits if its longest side does; steps of 2 % waste no more than that.
  for (double scale = (kTextureSize - 2 * kTextureGutter) / size.maxCoeff();; scale *= 0.98) {
    std::vector<Piece> pieces;
    for (const TextureChart& chart : charts) {
      const bool is_hidden = chart.triangles.front() >= first_hidden;
      pieces.push_back(MakePiece(mesh, chart, is_hidden ? kHiddenScale * scale : scale));
    }
    if (!LayOut(&pieces)) continue;
    TextureCoordinates uv(3 * mesh.triangles.rows(), 2);
    for (std::size_t i = 0; i < charts.size(); ++i) {
      Index row = 0;
      for (const int t : charts[i].triangles) {
        for (int c = 0; c < 3; ++c, ++row) {
          const Eigen::RowVector2d corner =
              pieces[i].corners.row(row) + Eigen::RowVector2d(pieces[i].left, pieces[i].low);
          uv.row(3 * t + c) = corner / kTextureSize;
        }
      }
    }
    return uv;
  }
}

}  // namespace hpdm
