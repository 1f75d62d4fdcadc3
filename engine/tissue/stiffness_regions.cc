#include "engine/tissue/stiffness_regions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "engine/base/error.h"
#include "engine/tissue/moment_compression.h"
#include "engine/tissue/support.h"
#include "engine/tissue/tissue_cache.h"

namespace hpdm {
namespace {

// Adds the names of the organ and of its mesh file to the error.
TissueQuadrature SampledTissue(const SurfaceMesh& rest_W, const OrientedBox& box_W,
                               const std::array<int, 3>& cells, const OrganOptions& organ,
                               const CutSurfaces& cuts) {
  InteriorOptions options;
  options.cuts = cuts;
  if (SplitsFunctions(organ)) {
    for (std::size_t d = 0; d < 3; ++d) options.support_cells[d] = organ.lattice.degree[d] + 1;
  }
  try {
    return CachedTissue(rest_W, box_W, cells, options);
  } catch (const InputError& error) {
    throw InputError("organ \"" + organ.name + "\": " + organ.mesh + ": " + error.what());
  }
}

constexpr int kMinParts = 8, kMaxParts = 16;  // parts of a cell along an axis
constexpr int kMomentDegree = 3;              // as InteriorOptions::moment_degree

// Returns the last region that contains the point, or -1.
int RegionAt(const OrganOptions& organ, const Box& bounds, const Vector3d& p_W) {
  for (int r = static_cast<int>(organ.regions.size()) - 1; r >= 0; --r) {
    if (InRegion(organ.regions[static_cast<std::size_t>(r)].region, bounds, p_W)) return r;
  }
  return -1;
}

double RelativeYoung(const OrganOptions& organ, int region) {
  if (region < 0) return 1;
  return organ.regions[static_cast<std::size_t>(region)].young / organ.material.young;
}

struct RegionBox {
  Vector3d min, max;  // in units of the lattice's box
  double least_side;  // m
};

RegionBox BoxAround(const Region& region, const Box& bounds, const OrientedBox& box_W) {
  const Box around = BoundsOf(region, bounds);
  RegionBox found{Vector3d::Constant(1), Vector3d::Zero(), (around.max - around.min).minCoeff()};
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d p(corner & 1 ? around.max.x() : around.min.x(),
                     corner & 2 ? around.max.y() : around.min.y(),
                     corner & 4 ? around.max.z() : around.min.z());
    const Vector3d c = box_W.ToUnit(p);
    found.min = found.min.cwiseMin(c);
    found.max = found.max.cwiseMax(c);
  }
  return found;
}

class StiffnessSampler {
 public:
  StiffnessSampler(const SurfaceMesh& rest_W, const OrientedBox& box_W,
                   const std::array<int, 3>& cells, const OrganOptions& organ, CutSurfaces cuts)
      : rest_(rest_W),
        box_(box_W),
        cells_(cells),
        organ_(organ),
        cuts_(std::move(cuts)),
        bounds_(AxisAlignedBounds(rest_W.vertices)),
        held_(organ.regions.size(), false) {
    for (const StiffnessRegion& region : organ.regions) {
      boxes_.push_back(BoxAround(region.region, bounds_, box_W));
    }
  }

  StiffnessTissue Sample() {
    const TissueQuadrature whole = SampledTissue(rest_, box_, cells_, organ_, cuts_);
    all_.tissue.cell_volumes = whole.cell_volumes;
    all_.tissue.pieces = whole.pieces;
    const auto count = static_cast<Eigen::Index>(whole.cells.size());
    for (Eigen::Index begin = 0, end = 0; begin < count; begin = end) {
      const int cell = whole.cells[static_cast<std::size_t>(begin)];
      while (end < count && whole.cells[static_cast<std::size_t>(end)] == cell) ++end;
      const int parts = PartsOf(cell);
      if (parts == 0 || !AddInParts(cell, parts)) {
        AddSorted(cell, whole.points.middleRows(begin, end - begin),
                  whole.weights.segment(begin, end - begin), false);
      }
    }
    for (std::size_t r = 0; r < held_.size(); ++r) {
      if (held_[r]) continue;
      const std::string key = "region[" + std::to_string(r) + "]";
      throw InputError(
          "organ \"" + organ_.name + "\": " + key + " holds no tissue; move or enlarge it",
          {"organ", organ_.name, key});
    }
    Collect();
    return std::move(all_);
  }

 private:
  Vector3d CellSize() const {
    return Vector3d::Ones().cwiseQuotient(Vector3d(cells_[0], cells_[1], cells_[2]));
  }
  Vector3d CellCorner(int cell) const {
    const Eigen::Vector3i at(cell % cells_[0], cell / cells_[0] % cells_[1],
                             cell / (cells_[0] * cells_[1]));
    return at.cast<double>().cwiseProduct(CellSize());
  }

  // Returns the number of parts of a cell along each axis; 0 if no region comes near.
  int PartsOf(int cell) const {
    const Vector3d low = CellCorner(cell), high = low + CellSize();
    const double longest = CellSize().cwiseProduct(box_.lengths).maxCoeff();
    int parts = 0;
    for (const RegionBox& region : boxes_) {
      if ((region.min.array() >= high.array()).any()) continue;
      if ((region.max.array() <= low.array()).any()) continue;
      const double wanted = std::ceil(4 * longest / region.least_side);
      parts = std::max(parts, static_cast<int>(std::clamp<double>(wanted, kMinParts, kMaxParts)));
    }
    return parts;
  }

  // Returns false if the parts contain no tissue.
  bool AddInParts(int cell, int parts) {
    const OrientedBox part_of{box_.FromUnit(CellCorner(cell)), box_.axes,
                              box_.lengths.cwiseProduct(CellSize())};
    TissueQuadrature fine;
    try {
      fine = CachedTissue(rest_, part_of, {parts, parts, parts},
                          {.resolution = 2 * kMaxParts, .gauss_points = 2, .moment_degree = 1});
    } catch (const InputError&) {
      return false;
    }
    // Keeps the cell's volume as SampleTissue found it.
    fine.weights *= all_.tissue.cell_volumes[cell] / fine.weights.sum();
    AddSorted(cell, fine.points, fine.weights, true);
    return true;
  }

  // Adds the points of a cell, region by region and piece by piece, reduced to few if there are
  // `many`.
  void AddSorted(int cell, const Points& points, const Eigen::VectorXd& weights, bool many) {
    std::map<std::pair<int, int>, std::vector<Eigen::Index>> sorted;  // region, piece -> points
    const TissuePieces& pieces = all_.tissue.pieces;
    for (Eigen::Index q = 0; q < weights.size(); ++q) {
      const Vector3d p_W = points.row(q);
      const int region = RegionAt(organ_, bounds_, p_W);
      const int piece = pieces.empty() ? 0 : pieces.At(box_.ToUnit(p_W));
      sorted[{region, piece}].push_back(q);
    }
    for (const auto& [part, members] : sorted) {
      const int region = part.first;
      if (region >= 0) held_[static_cast<std::size_t>(region)] = true;
      Points kept = points(members, Eigen::all);
      Eigen::VectorXd kept_weights = weights(members);
      if (many) Reduce(cell, &kept, &kept_weights);
      for (Eigen::Index q = 0; q < kept_weights.size(); ++q) {
        points_.insert(points_.end(), {kept(q, 0), kept(q, 1), kept(q, 2)});
        weights_.push_back(kept_weights[q]);
        stiffness_.push_back(RelativeYoung(organ_, region));
        all_.tissue.cells.push_back(cell);
      }
    }
  }

  void Reduce(int cell, Points* points, Eigen::VectorXd* weights) const {
    const Vector3d half = CellSize() / 2, centre = CellCorner(cell) + half;
    for (Eigen::Index q = 0; q < points->rows(); ++q) {
      const Vector3d c = box_.ToUnit(points->row(q).transpose());
      points->row(q) = (c - centre).cwiseQuotient(half).transpose();
    }
    CompressMoments(kMomentDegree, points, weights);
    for (Eigen::Index q = 0; q < points->rows(); ++q) {
      const Vector3d c = centre + points->row(q).transpose().cwiseProduct(half);
      points->row(q) = box_.FromUnit(c).transpose();
    }
  }

  void Collect() {
    const auto count = static_cast<Eigen::Index>(weights_.size());
    all_.tissue.points = Eigen::Map<const Points>(points_.data(), count, 3);
    all_.tissue.weights = Eigen::Map<const Eigen::VectorXd>(weights_.data(), count);
    all_.stiffness = Eigen::Map<const Eigen::VectorXd>(stiffness_.data(), count);
  }

  const SurfaceMesh& rest_;
  const OrientedBox& box_;
  const std::array<int, 3>& cells_;
  const OrganOptions& organ_;
  const CutSurfaces cuts_;
  Box bounds_;
  std::vector<RegionBox> boxes_;
  std::vector<bool> held_;  // regions with tissue
  StiffnessTissue all_;
  std::vector<double> points_, weights_, stiffness_;  // of all cells
};

}  // namespace

double YoungAt(const OrganOptions& organ, const Box& bounds, const Vector3d& p_W) {
  return organ.material.young * RelativeYoung(organ, RegionAt(organ, bounds, p_W));
}

StiffnessTissue SampleStiffness(const SurfaceMesh& rest_W, const OrientedBox& box_W,
                                const std::array<int, 3>& cells, const OrganOptions& organ,
                                CutSurfaces cuts) {
  if (!organ.regions.empty()) {
    return StiffnessSampler(rest_W, box_W, cells, organ, std::move(cuts)).Sample();
  }
  StiffnessTissue plain{SampledTissue(rest_W, box_W, cells, organ, cuts), {}};
  plain.stiffness.setOnes(plain.tissue.weights.size());
  return plain;
}

Eigen::VectorXd ElasticWeights(const OrganOptions& organ, const Box& bounds, const Points& points,
                               const Eigen::VectorXd& weights) {
  Eigen::VectorXd elastic = weights;
  for (Eigen::Index q = 0; q < weights.size(); ++q) {
    elastic[q] *= YoungAt(organ, bounds, points.row(q).transpose()) / organ.material.young;
  }
  return elastic;
}

}  // namespace hpdm
