#include "engine/tissue/cut_cells.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/tissue/moment_compression.h"

namespace hpdm {
namespace {

using Eigen::Index;

constexpr double kCutTouch = 1e-9;  // of a part, as kSlack in interior.cc
// Smallest parts, in cells: at a front, across it; and where a cut crosses a cell.
constexpr double kFrontPart = 1.0 / 64;
constexpr double kCutPart = 1.0 / 4;
// Distance of a front, in diagonals of a part, within which the part is halved.
constexpr double kNearFront = 1;
// Length along a front that parts may have, over their width.
constexpr double kSlender = 6;
constexpr int kFitDegree = 4;
constexpr double kLeastFactor = 0.1;

const std::array<std::array<double, 3>, 2> kPoints = {
    {{0.21132486540518713, 0.78867513459481287, 0}, {0.1127016653792583, 0.5, 0.8872983346207417}}};
const std::array<std::array<double, 3>, 2> kWeights = {
    {{0.5, 0.5, 0}, {5.0 / 18, 8.0 / 18, 5.0 / 18}}};

// Returns products of Legendre's polynomials up to a degree, M x N: all tensor products of the
// highest degree, otherwise those whose integrals CompressMoments() keeps.
Eigen::MatrixXd FittedPolynomials(int degree, const Points& points) {
  const int most = degree == kFitDegree ? 3 * degree : 2 * degree;
  Eigen::MatrixXd values(degree == kFitDegree ? 125 : MomentCount(degree), points.rows());
  for (Index q = 0; q < points.rows(); ++q) {
    std::array<std::array<double, kFitDegree + 1>, 3> p;
    for (int d = 0; d < 3; ++d) {
      const double t = points(q, d);
      p[d][0] = 1;
      p[d][1] = t;
      for (int n = 1; n < degree; ++n) {
        p[d][n + 1] = ((2 * n + 1) * t * p[d][n] - n * p[d][n - 1]) / (n + 1);
      }
    }
    Index m = 0;
    for (int i = 0; i <= degree; ++i) {
      for (int j = 0; j <= degree; ++j) {
        for (int k = 0; k <= std::min(degree, most - i - j); ++k) {
          values(m++, q) = p[0][i] * p[1][j] * p[2][k];
        }
      }
    }
  }
  return values;
}

}  // namespace

CutCells::CutCells(const OrientedBox& box, const std::array<int, 3>& cells, CutSurfaces cuts)
    : box_(box),
      cells_(cells),
      scale_(box.lengths.maxCoeff()),
      cell_size_((box.lengths / scale_).array() / Eigen::Array3d(cells[0], cells[1], cells[2])),
      cuts_(std::move(cuts)) {
  if (cuts_ == nullptr) return;
  for (const CutSurface& cut : *cuts_) {
    for (const CutSurface::Triangle& triangle : cut.triangles()) {
      CutSurface::Triangle& own = triangles_.emplace_back();
      for (std::size_t c = 0; c < 3; ++c) {
        own[c] = box_.axes.transpose() * (triangle[c] - box_.origin_W) / scale_;
      }
    }
  }
}

double CutCells::FrontDistance(const Vector3d& p) const {
  double distance = std::numeric_limits<double>::infinity();
  for (const CutSurface& cut : *cuts_) {
    distance =
        std::min(distance, cut.NearestFront(box_.origin_W + box_.axes * (scale_ * p)).distance);
  }
  return distance / scale_;
}

// Returns the axis along which a part must be halved, or -1. Parts at a front are longer along it
// than across it.
int CutCells::AxisToHalve(const Block& block, bool crossed) const {
  const Vector3d size = block.half.cwiseQuotient(cell_size_ / 2);  // in cells
  Index axis = 0;
  for (const CutSurface& cut : *cuts_) {
    const CutSurface::FrontPlace front =
        cut.NearestFront(box_.origin_W + box_.axes * (scale_ * block.centre));
    const Vector3d along = box_.axes.transpose() * front.along;
    const Vector3d across =
        size.array() * (1 - along.array().square()).max(0).sqrt().max(1 / kSlender);
    const double reach = kNearFront * across.cwiseProduct(cell_size_).norm() * scale_;
    const double widest = across.maxCoeff(&axis);
    if (front.distance < reach && widest > 1.5 * kFrontPart) return static_cast<int>(axis);
  }
  if (crossed && size.maxCoeff(&axis) > 1.5 * kCutPart) return static_cast<int>(axis);
  return -1;
}

// Tests bounding box and plane: may report a near miss, but misses none.
std::vector<int> CutCells::Crossing(const Block& block) const {
  std::vector<int> found;
  const Vector3d reach = block.half.array() + kCutTouch;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const Vector3d a = triangles_[t][0] - block.centre, b = triangles_[t][1] - block.centre,
                   c = triangles_[t][2] - block.centre;
    if ((a.cwiseMin(b).cwiseMin(c).array() > reach.array()).any()) continue;
    if ((a.cwiseMax(b).cwiseMax(c).array() < -reach.array()).any()) continue;
    const Vector3d n = (b - a).cross(c - a);
    if (std::abs(n.dot(a)) <= n.cwiseAbs().dot(reach)) found.push_back(static_cast<int>(t));
  }
  return found;
}

bool CutCells::Takes(const Block& cell) const {
  if (cuts_ == nullptr) return false;
  return Crosses(cell) || FrontDistance(cell.centre) < cell.half.norm() + cell_size_.maxCoeff();
}

std::array<std::vector<std::uint8_t>, 3> CutCells::CutLinks(int cell, int side) const {
  const std::array<int, 3> corner = {side * (cell % cells_[0]),
                                     side * (cell / cells_[0] % cells_[1]),
                                     side * (cell / (cells_[0] * cells_[1]))};
  const Vector3d voxel =
      Vector3d(cells_[0] * side, cells_[1] * side, cells_[2] * side).cwiseInverse();
  std::array<std::vector<std::uint8_t>, 3> links;
  std::array<int, 3> at;
  for (at[2] = 0; at[2] < side; ++at[2]) {
    for (at[1] = 0; at[1] < side; ++at[1]) {
      for (at[0] = 0; at[0] < side; ++at[0]) {
        const Vector3d centre(corner[0] + at[0] + 0.5, corner[1] + at[1] + 0.5,
                              corner[2] + at[2] + 0.5);
        const CutSurface::GridPoint here = cuts_->front().AtUnit(centre.cwiseProduct(voxel));
        for (int d = 0; d < 3; ++d) {
          const Vector3d next = centre + Vector3d::Unit(d);
          links[static_cast<std::size_t>(d)].push_back(
              CrossesAny(*cuts_, here, cuts_->front().AtUnit(next.cwiseProduct(voxel))) ? 1 : 0);
        }
      }
    }
  }
  return links;
}

void CutCells::AddBlock(const Block& block, std::vector<Sample>* samples) const {
  const double size = block.half.cwiseQuotient(cell_size_ / 2).maxCoeff();  // in cells
  const std::vector<int> crossing = Crossing(block);
  if (const int axis = AxisToHalve(block, !crossing.empty()); axis >= 0) {
    for (const Block& half : block.Halves(axis)) AddBlock(half, samples);
    return;
  }
  Index along = 0;
  if (!crossing.empty()) {
    const auto& [a, b, c] = triangles_[static_cast<std::size_t>(crossing[0])];
    (b - a).cross(c - a).cwiseAbs().maxCoeff(&along);
  }
  const Index u = (along + 1) % 3, v = (along + 2) % 3;
  // The voxels of a cell that the surface crosses are small enough for one point.
  const bool at_front = FrontDistance(block.centre) < cell_size_.minCoeff() / 4;
  const int gauss = size > 0.75 * kCutPart ? 3 : size > 0.1 || at_front ? 2 : 1;
  if (gauss == 1) {
    AddPart(block.centre, along, block.centre[along] - block.half[along],
            block.centre[along] + block.half[along], 4 * block.half[u] * block.half[v], 1, crossing,
            samples);
    return;
  }
  const auto rule = static_cast<std::size_t>(gauss - 2);
  for (std::size_t i = 0; i < static_cast<std::size_t>(gauss); ++i) {
    for (std::size_t j = 0; j < static_cast<std::size_t>(gauss); ++j) {
      Vector3d p = block.centre;
      p[u] += (2 * kPoints[rule][i] - 1) * block.half[u];
      p[v] += (2 * kPoints[rule][j] - 1) * block.half[v];
      const double area = 4 * block.half[u] * block.half[v] * kWeights[rule][i] * kWeights[rule][j];
      AddPart(p, along, block.centre[along] - block.half[along],
              block.centre[along] + block.half[along], area, gauss, crossing, samples);
    }
  }
}

void CutCells::Reduce(const Block& cell, std::vector<Sample>* samples) const {
  std::vector<Sample> all = std::move(*samples);
  samples->clear();
  ReducePart(cell, std::move(all), samples);
}

void CutCells::ReducePart(const Block& part, std::vector<Sample> in_part,
                          std::vector<Sample>* samples) const {
  const double size = part.half.cwiseQuotient(cell_size_ / 2).maxCoeff();
  const int degree = size > 0.4 ? 3 : size > 0.1 ? 2 : 1;
  if (in_part.size() <= static_cast<std::size_t>(MomentCount(degree))) {
    samples->insert(samples->end(), in_part.begin(), in_part.end());
    return;
  }
  const bool crossed = Crosses(part);
  int axis = AxisToHalve(part, crossed);
  if (axis < 0 && crossed) {
    if (size < 1.5 / 16) {
      samples->insert(samples->end(), in_part.begin(), in_part.end());
      return;
    }
    part.half.maxCoeff(&axis);
  }
  if (axis >= 0) {
    std::array<std::vector<Sample>, 2> parts;
    for (const Sample& sample : in_part) {
      parts[sample[axis] > part.centre[axis] ? 1 : 0].push_back(sample);
    }
    const std::array<Block, 2> halves = part.Halves(axis);
    for (std::size_t h = 0; h < 2; ++h) ReducePart(halves[h], std::move(parts[h]), samples);
    return;
  }
  const auto count = static_cast<Index>(in_part.size());
  Points points(count, 3);
  Eigen::VectorXd weights(count);
  for (Index q = 0; q < count; ++q) {
    const Sample& sample = in_part[static_cast<std::size_t>(q)];
    points.row(q) = (sample.head<3>() - part.centre).cwiseQuotient(part.half);
    weights[q] = sample[3];
  }
  CompressMoments(degree, &points, &weights);
  for (Index q = 0; q < weights.size(); ++q) {
    const Vector3d p = part.centre + points.row(q).transpose().cwiseProduct(part.half);
    samples->emplace_back(p.x(), p.y(), p.z(), weights[q]);
  }
}

void CutCells::AddColumn(const Vector3d& p, Index along, double begin, double end, double area,
                         std::vector<Sample>* samples) const {
  Block block{p, Vector3d::Zero()};
  block.centre[along] = (begin + end) / 2;
  block.half[along] = (end - begin) / 2;
  AddPart(p, along, begin, end, area, 1, Crossing(block), samples);
}

// Adds `gauss` points, or one, in each part into which the triangles divide a column.
void CutCells::AddPart(const Vector3d& p, Index along, double begin, double end, double area,
                       int gauss, const std::vector<int>& triangles,
                       std::vector<Sample>* samples) const {
  const Index u = (along + 1) % 3, v = (along + 2) % 3;
  std::vector<double> ends = {begin, end};
  for (const int t : triangles) {
    const auto& [a, b, c] = triangles_[static_cast<std::size_t>(t)];
    const Vector3d n = (b - a).cross(c - a);
    if (std::abs(n[along]) < 1e-6 * n.norm()) continue;  // the column runs along the cut
    const auto side = [&](const Vector3d& from, const Vector3d& to) {
      return (to[u] - from[u]) * (p[v] - from[v]) - (to[v] - from[v]) * (p[u] - from[u]);
    };
    const double ab = side(a, b), bc = side(b, c), ca = side(c, a);
    if (std::min({ab, bc, ca}) < 0 && std::max({ab, bc, ca}) > 0) continue;
    const double across = n[u] * (p[u] - a[u]) + n[v] * (p[v] - a[v]);
    const double at = a[along] - across / n[along];
    if (at > begin && at < end) ends.push_back(at);
  }
  std::sort(ends.begin(), ends.end());
  for (std::size_t e = 0; e + 1 < ends.size(); ++e) {
    const double length = ends[e + 1] - ends[e];
    if (length <= kCutTouch * kCutTouch) continue;
    for (int g = 0; g < gauss; ++g) {
      const auto rule = static_cast<std::size_t>(std::max(gauss - 2, 0));
      const double place = gauss == 1 ? 0.5 : kPoints[rule][static_cast<std::size_t>(g)];
      const double weight = gauss == 1 ? 1 : kWeights[rule][static_cast<std::size_t>(g)];
      Vector3d at = p;
      at[along] = ends[e] + place * length;
      samples->emplace_back(at.x(), at.y(), at.z(), area * length * weight);
    }
  }
}

void FitMoments(const Points& target_points, const Eigen::VectorXd& target_weights,
                const Points& points, Eigen::VectorXd* weights) {
  for (int degree = kFitDegree; degree >= 0; --degree) {
    const Eigen::MatrixXd values = FittedPolynomials(degree, points);
    const Eigen::VectorXd wanted = FittedPolynomials(degree, target_points) * target_weights;
    const Eigen::MatrixXd gram = values * weights->asDiagonal() * values.transpose();
    const Eigen::VectorXd factors =
        Eigen::VectorXd::Ones(points.rows()) +
        values.transpose() * Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(gram).solve(
                                 wanted - values * *weights);
    if (degree > 0 && !(factors.minCoeff() > kLeastFactor)) continue;
    *weights = weights->cwiseProduct(factors);
    return;
  }
}

}  // namespace hpdm
