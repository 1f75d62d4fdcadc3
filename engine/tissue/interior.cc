#include "engine/tissue/interior.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

#include "engine/base/check.h"
#include "engine/base/error.h"
#include "engine/mesh/winding_number.h"
#include "engine/tissue/cut_cells.h"
#include "engine/tissue/moment_compression.h"
#include "engine/tissue/piece_finder.h"

namespace hpdm {
namespace {

/// Slack of the overlap test in units of the box: a surface along a face belongs to both sides, and
/// rounding cannot change that.
constexpr double kSlack = 1e-9;
/// Distance of the winding number from 0.5 beyond which the centre decides for a block without
/// surface.
constexpr double kClear = 0.4;
/// Least winding number that shows an enclosed volume. In the plane of a flat sheet the winding
/// number is 0.5, and rounding would decide.
constexpr double kEnclosed = 0.51;
/// Most surface area in a box, in units of its longest side squared. A body has a few; triangles
/// that cross each other have thousands. Each unit takes about 0.2 s.
constexpr double kMaxSurface = 50;
/// Most area that one triangle adds to that sum: about the largest cut through a box.
constexpr double kMaxTriangleShare = 1.5;
/// Gauss points along an axis of a block inside a split cell: exact to degree 3, which is enough
/// for blocks smaller than a cell.
constexpr int kBlockGaussPoints = 2;

std::string Figure(const char* form, double value) {
  char text[32];
  std::snprintf(text, sizeof text, form, value);
  return text;
}

struct GaussRule {
  std::vector<double> points, weights;  ///< Points on [0, 1]; the weights sum to 1.
};

/// Returns the Gauss-Legendre rule with n = 1..5 points. The last digits of the table decide the
/// last bits of all results.
GaussRule MakeGaussRule(int n) {
  switch (n) {
    case 1:
      return {{0.5}, {1}};
    case 2:
      return {{0.21132486540518713, 0.78867513459481287},
              {0.50000000000000011, 0.50000000000000011}};
    case 3:
      return {{0.1127016653792583, 0.5, 0.8872983346207417},
              {0.27777777777777762, 0.44444444444444442, 0.27777777777777762}};
    case 4:
      return {{0.069431844202973714, 0.33000947820757187, 0.66999052179242813, 0.93056815579702623},
              {0.17392742256872687, 0.32607257743127305, 0.32607257743127305, 0.17392742256872687}};
    default:
      return {
          {0.046910077030668018, 0.23076534494715845, 0.5, 0.7692346550528415, 0.95308992296933193},
          {0.1184634425280945, 0.23931433524968324, 0.28444444444444444, 0.23931433524968324,
           0.1184634425280945}};
  }
}

/// Returns the closest point of a triangle with an area (Ericson, "Real-Time Collision Detection",
/// 5.1.5).
Vector3d ClosestPoint(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a;
  const double d1 = ab.dot(p - a), d2 = ac.dot(p - a);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = ab.dot(p - b), d4 = ac.dot(p - b);
  if (d3 >= 0 && d4 <= d3) return b;
  const double d5 = ab.dot(p - c), d6 = ac.dot(p - c);
  if (d6 >= 0 && d5 <= d6) return c;
  const double area_c = d1 * d4 - d3 * d2;
  if (area_c <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const double area_b = d5 * d2 - d1 * d6;
  if (area_b <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double area_a = d3 * d6 - d5 * d4;
  if (area_a <= 0 && d4 >= d3 && d5 >= d6) {
    return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  }
  return a + (area_b * ab + area_c * ac) / (area_a + area_b + area_c);
}

/// Works in the box's own frame, scaled so that the box's longest side is 1.
class TissueSampler {
 public:
  TissueSampler(const SurfaceMesh& mesh, const OrientedBox& box, const std::array<int, 3>& cells,
                const InteriorOptions& options)
      : box_(box),
        scale_(box.lengths.maxCoeff()),
        cells_(cells),
        cell_size_((box.lengths / scale_).unaryExpr(&TissueSampler::Snap).array() /
                   Eigen::Array3d(cells[0], cells[1], cells[2])),
        options_(options),
        gauss_(MakeGaussRule(options.gauss_points)),
        block_gauss_(MakeGaussRule(kBlockGaussPoints)),
        vertices_(ToBox(mesh.vertices)),
        triangles_(mesh.triangles),
        winding_(vertices_, triangles_),
        cuts_(box, cells, options.cuts) {
    // The smallest blocks take two samples along each axis.
    const double smallest = 2.0 / options.resolution;
    while (cell_size_.maxCoeff() / std::pow(2.0, depth_) > smallest * (1 + kSlack)) ++depth_;
  }

  /// Returns no points if the surface encloses nothing.
  TissueQuadrature Sample() {
    SortTrianglesIntoCells();
    TissueQuadrature tissue;
    const int count = cells_[0] * cells_[1] * cells_[2];
    tissue.cell_volumes.setZero(count);
    PieceFinder finder(cells_, Voxels(), options_.support_cells, options_.cuts);
    std::vector<CellSamples> samples;
    for (int cell = 0; cell < count; ++cell) samples.push_back(SampleCell(cell, &finder));
    tissue.pieces = finder.Finish();
    std::vector<double> points, weights;  // of all cells
    for (int cell = 0; cell < count; ++cell) {
      CellSamples& of_cell = samples[static_cast<std::size_t>(cell)];
      if (of_cell.in_pieces) CompressPieces(cell, tissue.pieces, &of_cell);
      const Block block = CellBlock(cell);
      for (Eigen::Index q = 0; q < of_cell.weights.size(); ++q) {
        const Vector3d p =
            block.centre + of_cell.points.row(q).transpose().cwiseProduct(block.half);
        const Vector3d p_W = box_.origin_W + box_.axes * (scale_ * p);
        points.insert(points.end(), {p_W.x(), p_W.y(), p_W.z()});
        weights.push_back(of_cell.weights[q] * scale_ * scale_ * scale_);
        tissue.cells.push_back(cell);
        tissue.cell_volumes[cell] += weights.back();
      }
      of_cell = {};
    }
    // Otherwise half of each sample that an open sheet cuts would count as tissue.
    if (!(largest_winding_ > kEnclosed)) return TissueQuadrature();
    const auto q = static_cast<Eigen::Index>(weights.size());
    tissue.points = Eigen::Map<Points>(points.data(), q, 3);
    tissue.weights = Eigen::Map<Eigen::VectorXd>(weights.data(), q);
    return tissue;
  }

 private:
  // Rounds to a billionth of the box. So the round-off of a body's unit or position does not decide
  // on which side of a plane a point lies. A rescaled body gets the rescaled points.
  static double Snap(double value) {
    constexpr double kGrid = 1 << 30;
    return std::round(value * kGrid) / kGrid;
  }

  Points ToBox(const Points& p_W) const {
    const Points p = (p_W.rowwise() - box_.origin_W.transpose()) * (box_.axes / scale_);
    return p.unaryExpr(&TissueSampler::Snap);
  }

  int CellNumber(int i, int j, int k) const { return i + cells_[0] * (j + cells_[1] * k); }

  Block CellBlock(int cell) const {
    const int i = cell % cells_[0], j = cell / cells_[0] % cells_[1],
              k = cell / (cells_[0] * cells_[1]);
    return {cell_size_.cwiseProduct(Vector3d(i + 0.5, j + 0.5, k + 0.5)), cell_size_ / 2};
  }

  Vector3d Corner(int triangle, int c) const { return vertices_.row(triangles_(triangle, c)); }

  /// Tests bounding box and plane. May report a near miss as an overlap, but misses none.
  bool Overlaps(int triangle, const Block& block) const {
    const Vector3d a = Corner(triangle, 0) - block.centre, b = Corner(triangle, 1) - block.centre,
                   c = Corner(triangle, 2) - block.centre;
    const Vector3d reach = block.half.array() + kSlack;
    if ((a.cwiseMin(b).cwiseMin(c).array() > reach.array()).any()) return false;
    if ((a.cwiseMax(b).cwiseMax(c).array() < -reach.array()).any()) return false;
    const Vector3d n = (b - a).cross(c - a);
    return std::abs(n.dot(a)) <= n.cwiseAbs().dot(reach);
  }

  /// Throws InputError if their area exceeds kMaxSurface.
  void SortTrianglesIntoCells() {
    double surface = 0;
    cell_triangles_.resize(static_cast<std::size_t>(cells_[0] * cells_[1] * cells_[2]));
    for (int t = 0; t < static_cast<int>(triangles_.rows()); ++t) {
      const Vector3d a = Corner(t, 0), b = Corner(t, 1), c = Corner(t, 2);
      const Vector3d low = (a.cwiseMin(b).cwiseMin(c).array() - kSlack) / cell_size_.array();
      const Vector3d high = (a.cwiseMax(b).cwiseMax(c).array() + kSlack) / cell_size_.array();
      std::array<int, 3> first, last;
      for (std::size_t d = 0; d < 3; ++d) {
        const auto axis = static_cast<Eigen::Index>(d);
        // Clamps before the conversion: the cell numbers of a surface far outside the box do not
        // fit an int.
        first[d] = static_cast<int>(std::clamp(std::floor(low[axis]), 0.0, 1.0 * cells_[d]));
        last[d] = static_cast<int>(std::clamp(std::floor(high[axis]), -1.0, cells_[d] - 1.0));
      }
      bool hits = false;
      for (int k = first[2]; k <= last[2]; ++k) {
        for (int j = first[1]; j <= last[1]; ++j) {
          for (int i = first[0]; i <= last[0]; ++i) {
            const int cell = CellNumber(i, j, k);
            if (!Overlaps(t, CellBlock(cell))) continue;
            cell_triangles_[static_cast<std::size_t>(cell)].push_back(t);
            hits = true;
          }
        }
      }
      if (hits) surface += std::min((b - a).cross(c - a).norm() / 2, kMaxTriangleShare);
    }
    if (surface <= kMaxSurface) return;
    throw InputError("the triangles in the sampled box have an area of " + Figure("%.3g", surface) +
                     " times the square of its longest side (at most " + Figure("%g", kMaxSurface) +
                     "): they cross each other; export only the tissue's surface");
  }

  /// Points and weights of a cell, in half cells from its centre and in volumes of the scaled box.
  struct CellSamples {
    Points points;
    Eigen::VectorXd weights;
    bool in_pieces = false;  ///< Not yet reduced: its pieces may have to be reduced apart.
  };

  /// Returns the number of voxels along each axis of a cell: one for each smallest part.
  int Voxels() const { return 2 << depth_; }

  CellSamples SampleCell(int cell, PieceFinder* finder) {
    samples_.clear();
    divided_.clear();
    split_ = false;
    finder->BeginCell();
    finder_ = finder;
    const Block block = CellBlock(cell);
    divides_ = cuts_.Takes(block);
    cell_low_ = block.centre - block.half;
    Visit(block, cell_triangles_[static_cast<std::size_t>(cell)], depth_);
    CellSamples taken = InCell(block, samples_);
    if (divides_) finder->SetCutLinks(cuts_.CutLinks(cell, Voxels()));
    const bool whole = !split_ && !divides_;
    taken.in_pieces = finder->EndCell(whole, taken.weights.size() > 0) > 1 && !divides_;
    if (split_ && !taken.in_pieces) {
      CompressMoments(options_.moment_degree, &taken.points, &taken.weights);
    }
    if (!divides_ || taken.weights.size() == 0) return taken;
    if (split_) cuts_.Reduce(block, &divided_);
    CellSamples divided = InCell(block, divided_);
    FitMoments(taken.points, taken.weights, divided.points, &divided.weights);
    return divided;
  }

  static CellSamples InCell(const Block& block, const std::vector<Eigen::Vector4d>& samples) {
    const auto count = static_cast<Eigen::Index>(samples.size());
    CellSamples taken{Points(count, 3), Eigen::VectorXd(count)};
    for (Eigen::Index q = 0; q < count; ++q) {
      const Eigen::Vector4d& sample = samples[static_cast<std::size_t>(q)];
      taken.points.row(q) = (sample.head<3>() - block.centre).cwiseQuotient(block.half);
      taken.weights[q] = sample[3];
    }
    return taken;
  }

  /// Reduces the samples of each piece of a cell apart.
  void CompressPieces(int cell, const TissuePieces& pieces, CellSamples* of_cell) const {
    const int first = pieces.data().first[static_cast<std::size_t>(cell)],
              end = pieces.data().first[static_cast<std::size_t>(cell) + 1];
    if (end - first < 2) {
      CompressMoments(options_.moment_degree, &of_cell->points, &of_cell->weights);
      return;
    }
    std::vector<std::vector<Eigen::Index>> sorted(static_cast<std::size_t>(end - first));
    const Eigen::Array3d corner(cell % cells_[0], cell / cells_[0] % cells_[1],
                                cell / (cells_[0] * cells_[1]));
    const Eigen::Array3d counts(cells_[0], cells_[1], cells_[2]);
    for (Eigen::Index q = 0; q < of_cell->weights.size(); ++q) {
      const Eigen::Array3d place = (of_cell->points.row(q).transpose().array() + 1) / 2;
      const int piece = pieces.At((corner + place) / counts);
      // A point on the cell's face may round into the next cell.
      sorted[static_cast<std::size_t>(std::clamp(piece, first, end - 1) - first)].push_back(q);
    }
    CellSamples all{Points(0, 3), Eigen::VectorXd(0)};
    for (const std::vector<Eigen::Index>& members : sorted) {
      Points points = of_cell->points(members, Eigen::all);
      Eigen::VectorXd weights = of_cell->weights(members);
      CompressMoments(options_.moment_degree, &points, &weights);
      const Eigen::Index before = all.weights.size();
      all.points.conservativeResize(before + weights.size(), 3);
      all.weights.conservativeResize(before + weights.size());
      all.points.bottomRows(weights.size()) = points;
      all.weights.tail(weights.size()) = weights;
    }
    *of_cell = std::move(all);
  }

  /// Tells the finder of pieces that a block of the present cell is tissue.
  void MarkTissue(const Block& block) {
    const Vector3d voxel = cell_size_ / Voxels();
    std::array<int, 3> low, high;
    for (std::size_t d = 0; d < 3; ++d) {
      const auto axis = static_cast<Eigen::Index>(d);
      const double begin = block.centre[axis] - block.half[axis] - cell_low_[axis];
      low[d] = static_cast<int>(std::lround(begin / voxel[axis]));
      high[d] = low[d] + static_cast<int>(std::lround(2 * block.half[axis] / voxel[axis]));
    }
    finder_->AddVoxels(low, high);
  }

  double Winding(const Vector3d& p) {
    const double winding = winding_.At(p);
    largest_winding_ = std::max(largest_winding_, winding);
    return winding;
  }
  bool Inside(const Vector3d& p) { return Winding(p) > 0.5; }

  void Visit(const Block& block, const std::vector<int>& triangles, int depth) {
    if (triangles.empty()) {
      const double centre = Winding(block.centre);
      if (std::abs(centre - 0.5) > kClear || CornersAgree(block, centre > 0.5)) {
        if (centre > 0.5) {
          AddGauss(block, split_ ? block_gauss_ : gauss_);
          if (split_ || divides_) MarkTissue(block);
          if (divides_) cuts_.AddBlock(block, &divided_);
        }
        return;
      }
    }
    split_ = true;
    if (depth == 0) {
      AddSamples(block, triangles);
      return;
    }
    for (int octant = 0; octant < 8; ++octant) {
      const Block child = block.Octant(octant);
      std::vector<int> inside;
      for (const int t : triangles) {
        if (Overlaps(t, child)) inside.push_back(t);
      }
      Visit(child, inside, depth - 1);
    }
  }

  /// True if all corners of a block without surface lie on one side. The winding number is harmonic
  /// in the block, so the smooth 0.5 level of a gap would separate corners.
  bool CornersAgree(const Block& block, bool inside) {
    for (int octant = 0; octant < 8; ++octant) {
      const Block corner = Block{block.centre, 2 * block.half}.Octant(octant);
      if (Inside(corner.centre) != inside) return false;
    }
    return true;
  }

  /// Adds the eighths of a smallest block as a whole. Of those that the surface cuts, it adds the
  /// part on the tissue's side of the nearest triangle's plane.
  void AddSamples(const Block& block, const std::vector<int>& triangles) {
    for (int octant = 0; octant < 8; ++octant) {
      const Block part = block.Octant(octant);
      const bool inside = Inside(part.centre);
      if (inside) MarkTissue(part);
      const std::optional<Nearest> nearest = FindNearest(part.centre, triangles);
      if (nearest && nearest->distance < part.half.norm()) {
        AddCutPart(part, *nearest, inside);
      } else if (inside) {
        AddSample(part.centre, 8 * part.half.prod());
        if (divides_) cuts_.AddBlock(part, &divided_);
      }
    }
  }

  struct Nearest {
    Vector3d point, normal;  ///< Point on the triangle; the triangle's unit normal.
    double distance;
  };

  std::optional<Nearest> FindNearest(const Vector3d& p, const std::vector<int>& triangles) const {
    std::optional<Nearest> nearest;
    for (const int t : triangles) {
      const Vector3d a = Corner(t, 0), b = Corner(t, 1), c = Corner(t, 2);
      const Vector3d normal = (b - a).cross(c - a);
      if (!(normal.norm() > 0)) continue;
      const Vector3d point = ClosestPoint(p, a, b, c);
      const double distance = (point - p).norm();
      if (!nearest || distance < nearest->distance) {
        nearest = Nearest{point, normal.normalized(), distance};
      }
    }
    return nearest;
  }

  /// Integrates one side of a plane exactly along the axis nearest to its normal, in four columns.
  /// The winding number at the centre, not the triangle, decides which side is tissue.
  void AddCutPart(const Block& part, const Nearest& nearest, bool inside) {
    Vector3d out = nearest.normal;
    if (nearest.distance > kSlack) {
      out = (part.centre - nearest.point) * ((inside ? -1 : 1) / nearest.distance);
    }
    Eigen::Index along = 0;
    out.cwiseAbs().maxCoeff(&along);
    const Eigen::Index u = (along + 1) % 3, v = (along + 2) % 3;
    const double low = part.centre[along] - part.half[along],
                 high = part.centre[along] + part.half[along];
    for (const double s : block_gauss_.points) {
      for (const double t : block_gauss_.points) {
        Vector3d p = part.centre;
        p[u] += (2 * s - 1) * part.half[u];
        p[v] += (2 * t - 1) * part.half[v];
        const double across =
            out[u] * (p[u] - nearest.point[u]) + out[v] * (p[v] - nearest.point[v]);
        const double cut = nearest.point[along] - across / out[along];
        const double begin = out[along] > 0 ? low : std::max(low, cut);
        const double end = out[along] > 0 ? std::min(high, cut) : high;
        if (end - begin <= kSlack) continue;
        p[along] = (begin + end) / 2;
        AddSample(p, (end - begin) * part.half[u] * part.half[v]);
        if (divides_) {
          cuts_.AddColumn(p, along, begin, end, part.half[u] * part.half[v], &divided_);
        }
      }
    }
  }

  void AddSample(const Vector3d& p, double weight) {
    samples_.emplace_back(p.x(), p.y(), p.z(), weight);
  }

  void AddGauss(const Block& block, const GaussRule& rule) {
    const std::size_t n = rule.points.size();
    const double volume = 8 * block.half.prod();
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t i = 0; i < n; ++i) {
          const Vector3d s(rule.points[i], rule.points[j], rule.points[k]);
          const Vector3d p = block.centre + block.half.cwiseProduct(2 * s - Vector3d::Ones());
          AddSample(p, volume * rule.weights[i] * rule.weights[j] * rule.weights[k]);
        }
      }
    }
  }

  const OrientedBox& box_;
  const double scale_;
  const std::array<int, 3> cells_;
  const Vector3d cell_size_;
  const InteriorOptions options_;
  const GaussRule gauss_, block_gauss_;
  const Points vertices_;
  const Triangles& triangles_;
  const WindingNumber winding_;
  const CutCells cuts_;
  int depth_ = 0;
  double largest_winding_ = 0;  // over all samples
  std::vector<std::vector<int>> cell_triangles_;

  // The current cell:
  std::vector<Eigen::Vector4d> samples_;  // point, weight
  bool split_ = false;
  bool divides_ = false;                  // at cuts
  std::vector<Eigen::Vector4d> divided_;  // the samples, if it divides
  PieceFinder* finder_ = nullptr;
  Vector3d cell_low_ = Vector3d::Zero();  // its corner
};

}  // namespace

TissueQuadrature SampleTissue(const SurfaceMesh& mesh_W, const OrientedBox& box_W,
                              const std::array<int, 3>& cells, const InteriorOptions& options) {
  HPDM_CHECK(std::min({cells[0], cells[1], cells[2]}) > 0 && (box_W.lengths.array() > 0).all());
  HPDM_CHECK(options.resolution > 0 && options.gauss_points >= 1 && options.gauss_points <= 5);
  TissueQuadrature tissue = TissueSampler(mesh_W, box_W, cells, options).Sample();
  if (tissue.weights.size() == 0) {
    throw InputError(
        "no tissue: samples " +
        Figure("%.3g", 1000 * box_W.lengths.maxCoeff() / options.resolution) +
        " mm apart in the lattice's box find nothing enclosed by the surface; check that the mesh "
        "is a closed (or nearly closed) surface that faces outwards, its unit and the lattice's "
        "margin");
  }
  return tissue;
}

Vector3d CentreOfVolume(const TissueQuadrature& tissue) {
  return tissue.points.transpose() * tissue.weights / tissue.weights.sum();
}

}  // namespace hpdm
