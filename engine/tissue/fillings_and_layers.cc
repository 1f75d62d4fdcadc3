#include "engine/tissue/fillings_and_layers.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/tissue/support.h"

namespace hpdm {
namespace {

// Returns the surface without the walls of closed lumens.
SurfaceMesh OuterSurface(const SurfaceMesh& rest) {
  const std::vector<bool> inner = TrianglesOfLumens(rest);
  SurfaceMesh outer{.vertices = rest.vertices, .triangles = {}, .texture_coordinates = {}};
  outer.triangles.resize(std::ranges::count(inner, false), 3);
  Eigen::Index kept = 0;
  for (Eigen::Index t = 0; t < rest.triangles.rows(); ++t) {
    if (!inner[ToSize(t)]) outer.triangles.row(kept++) = rest.triangles.row(t);
  }
  return outer;
}

// N/m: half of the tension by the sum of the two strains, and by their difference.
double SumStiffness(const LayerOptions& layer) {
  return layer.stiffness / (2 * (1 - layer.poisson));
}
double ShearStiffness(const LayerOptions& layer) {
  return layer.stiffness / (2 * (1 + layer.poisson));
}

}  // namespace

FillingsAndLayers::FillingsAndLayers(const OrganOptions& organ, const SurfaceMesh& rest,
                                     const Points& rest_normals, double longest_side)
    : rest_(&rest),
      rest_normals_(&rest_normals),
      lumens_(FilledLumens(rest, organ)),
      layers_(organ.layers) {
  if (layers_.empty()) return;
  const SurfaceMesh outer = OuterSurface(rest);
  const Box bounds = AxisAlignedBounds(rest.vertices);
  tensions_ = LayerTensions(layers_, outer, bounds);
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    std::vector<SurfaceSample> samples;
    try {
      samples = SurfaceInRegion(outer, layers_[l].region, bounds, longest_side);
    } catch (const InputError&) {
      const std::string key = "layer[" + std::to_string(l) + "]";
      throw InputError("organ \"" + organ.name + "\": " + key +
                           " meets no outer surface in its region; move or enlarge it",
                       {"organ", organ.name, key});
    }
    AddSamples(static_cast<int>(l), outer, samples);
  }
}

void FillingsAndLayers::AddSamples(int layer, const SurfaceMesh& outer,
                                   const std::vector<SurfaceSample>& samples) {
  double area = 0;
  for (const SurfaceSample& at : samples) {
    Sample sample{.layer = layer,
                  .area = at.weight,
                  .p_W = AtSample(at, outer.triangles, outer.vertices),
                  .normal_W = AtSample(at, outer.triangles, *rest_normals_),
                  .plane = {}};
    const Vector3d first = outer.vertices.row(outer.triangles(at.triangle, 1)) -
                           outer.vertices.row(outer.triangles(at.triangle, 0));
    const Vector3d normal =
        TwiceAreaNormal(outer.vertices, outer.triangles, at.triangle).normalized();
    sample.plane.col(0) = first.normalized();
    sample.plane.col(1) = normal.cross(sample.plane.col(0));
    samples_.push_back(sample);
    area += at.weight;
  }
  layer_areas_.push_back(area);
}

Lattice::Site FillingsAndLayers::SiteOf(const Lattice& lattice, const Sample& sample) const {
  return lattice.SiteOf(sample.p_W, sample.p_W - lattice.inset() * sample.normal_W);
}

Eigen::MatrixXd FillingsAndLayers::FillingRows(const Lattice& lattice) const {
  Eigen::MatrixXd rows =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(lumens_.size()), 3 * lattice.size());
  for (std::size_t l = 0; l < lumens_.size(); ++l) {
    const Lumen& lumen = lumens_[l];
    const double scale = std::sqrt(lumen.bulk_modulus / lumen.volume);
    auto row = rows.row(static_cast<Eigen::Index>(l));
    for (std::size_t i = 0; i < lumen.vertices.size(); ++i) {
      const Vector3d p_W = rest_->vertices.row(lumen.vertices[i]);
      const Vector3d inside_W =
          p_W - lattice.inset() * rest_normals_->row(lumen.vertices[i]).transpose();
      const Eigen::RowVector3d area = scale * lumen.areas_W.row(static_cast<Eigen::Index>(i));
      lattice.ForEachFunction(lattice.SiteOf(p_W, inside_W), [&](int column, double value) {
        row.segment<3>(3 * column) += value * area;
      });
    }
  }
  return rows;
}

WeightMatrix FillingsAndLayers::LayerRows(const Lattice& lattice) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t s = 0; s < samples_.size(); ++s) {
    const Sample& sample = samples_[s];
    const LayerOptions& layer = layers_[ToSize(sample.layer)];
    const double sum = std::sqrt(sample.area * SumStiffness(layer));
    const double shear = std::sqrt(sample.area * ShearStiffness(layer));
    const auto row = static_cast<int>(3 * s);
    const Vector3d first = sample.plane.col(0), second = sample.plane.col(1);
    lattice.ForEachGradient(SiteOf(lattice, sample), [&](int column, const Vector3d& gradient) {
      const Vector3d along = gradient.dot(first) * first, across = gradient.dot(second) * second;
      const Vector3d sheared = gradient.dot(second) * first + gradient.dot(first) * second;
      for (int d = 0; d < 3; ++d) {
        entries.emplace_back(row, 3 * column + d, sum * (along[d] + across[d]));
        entries.emplace_back(row + 1, 3 * column + d, shear * (along[d] - across[d]));
        entries.emplace_back(row + 2, 3 * column + d, shear * sheared[d]);
      }
    });
  }
  WeightMatrix rows(3 * static_cast<Eigen::Index>(samples_.size()), 3 * lattice.size());
  rows.setFromTriplets(entries.begin(), entries.end());
  return rows;
}

void FillingsAndLayers::AddTo(const Lattice& lattice, Eigen::MatrixXd* K) const {
  if (!samples_.empty()) {
    const WeightMatrix rows = LayerRows(lattice);
    const WeightMatrix added = rows.transpose() * rows;
    // Symmetric to the last bit, whatever the order of summation.
    *K += 0.5 * (added + WeightMatrix(added.transpose()));
  }
  if (lumens_.empty()) return;
  const Eigen::MatrixXd rows = FillingRows(lattice);
  for (Eigen::Index l = 0; l < rows.rows(); ++l) *K += rows.row(l).transpose() * rows.row(l);
}

}  // namespace hpdm
