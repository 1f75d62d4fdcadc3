#include "lcmtypes/wire/logged_surface.h"

#include <utility>
#include <vector>

#include "engine/contact/half_space.h"
#include "engine/mesh/surface_mesh.h"

namespace hpdm {
namespace {

Lattice LatticeOf(const LatticeDescription& description, int refinement) {
  LatticeOptions options;
  options.basis = description.basis;
  options.degree = description.degree;
  options.cells = description.cells;
  for (int& cells : options.cells) cells *= refinement;
  return Lattice({description.origin_W, description.axes, description.lengths}, options);
}

/// Returns the values of the functions with these grid indices, one a column, at `points`.
WeightMatrix WeightsOf(const Lattice& lattice, const std::vector<int>& indices,
                       const Points& points) {
  std::vector<int> column(static_cast<std::size_t>(lattice.size()), -1);
  for (std::size_t a = 0; a < indices.size(); ++a) column[indices[a]] = static_cast<int>(a);
  std::vector<Eigen::Triplet<double>> values;
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    lattice.ForEachFunction(points.row(v).transpose(), [&](int index, double value) {
      if (column[index] >= 0) values.emplace_back(static_cast<int>(v), column[index], value);
    });
  }
  WeightMatrix weights(points.rows(), static_cast<Eigen::Index>(indices.size()));
  weights.setFromTriplets(values.begin(), values.end());
  return weights;
}

}  // namespace

LoggedSurface::LoggedSurface(OrganDescription organ) : organ_(std::move(organ)) {
  VertexNormals(organ_.vertices, organ_.triangles, &normals_);
  if (!organ_.lattice) return;
  weights_ = WeightsOf(LatticeOf(*organ_.lattice, 1), organ_.lattice->kept, organ_.vertices);
  const int refinement = organ_.lattice->local_refinement;
  if (refinement > 0) fine_.emplace(LatticeOf(*organ_.lattice, refinement));
}

bool LoggedSurface::Deform(const OrganSnapshot& shape, Points* vertices) const {
  *vertices = organ_.vertices;
  const Points& displacements = shape.control_displacements;
  if (organ_.lattice) {
    if (displacements.rows() != weights_.cols()) return false;
    *vertices += weights_ * displacements;
  } else if (displacements.rows() > 0) {
    if (displacements.rows() != vertices->rows()) return false;
    *vertices += displacements;
  }
  if (!AddLocalFunctions(shape, vertices)) return false;
  for (int i = 0; i < shape.indentation_count; ++i) AddIndentation(shape.indentations[i], vertices);
  vertices->rowwise() += shape.offset_W.transpose();
  return vertices->allFinite();
}

bool LoggedSurface::AddLocalFunctions(const OrganSnapshot& shape, Points* vertices) const {
  if (shape.local_functions.empty()) return true;
  if (!fine_) return false;
  for (const int index : shape.local_functions) {
    if (index < 0 || index >= fine_->size()) return false;
  }
  *vertices +=
      WeightsOf(*fine_, shape.local_functions, organ_.vertices) * shape.local_displacements;
  return true;
}

void LoggedSurface::AddIndentation(const IndentationSnapshot& indentation, Points* vertices) const {
  for (Eigen::Index v = 0; v < vertices->rows(); ++v) {
    if (normals_.row(v).dot(indentation.normal_W) <= 0) continue;
    const double d = (organ_.vertices.row(v).transpose() - indentation.p_rest_W).norm();
    vertices->row(v) += IndentationProfile(d, indentation.radius, indentation.resolved_radius) *
                        indentation.amplitude_W.transpose();
  }
}

}  // namespace hpdm
