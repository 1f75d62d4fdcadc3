#include "render/overlay/lattice_marks.h"

#include <algorithm>
#include <array>

namespace hpdm {
namespace {

const Colour kLineColour(0.62f, 0.80f, 1.0f);
const Colour kPointColour(0.85f, 0.95f, 1.0f);
const Colour kLocalColour(1.0f, 0.72f, 0.15f);

Mark PointAt(const Points& points, Eigen::Index row, float radius, const Colour& colour,
             float opacity = 1) {
  const Eigen::Vector3f p = points.row(row).cast<float>();
  return {.a_W = p,
          .radius_a = radius,
          .b_W = p,
          .radius_b = radius,
          .colour = colour,
          .opacity = opacity};
}

}  // namespace

Eigen::VectorXf ControlPointPresence(const OrganModel& model) {
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(model.control_points());
  const WeightMatrix& weights = model.weights();
  for (int row = 0; row < weights.outerSize(); ++row) {
    for (WeightMatrix::InnerIterator it(weights, row); it; ++it) moved[it.col()] += it.value();
  }
  constexpr double kFull = 0.25, kNone = 0.05;  // of the largest share
  return ((moved / moved.maxCoeff()).array() - kNone)
             .cwiseMax(0.0)
             .cwiseMin(kFull - kNone)
             .cast<float>() /
         static_cast<float>(kFull - kNone);
}

Points DisplacedControlPoints(const Lattice& lattice, const OrganSnapshot& shape) {
  Points points = lattice.ControlPoints() + shape.control_displacements;
  points.rowwise() += shape.offset_W.transpose();
  return points;
}

Points DisplacedLocalFunctions(const OrganModel& model, const OrganSnapshot& shape) {
  const auto slots = static_cast<Eigen::Index>(shape.local_functions.size());
  Points points(slots, 3);
  Eigen::Index used = 0;
  for (Eigen::Index slot = 0; slot < slots; ++slot) {
    const int function = shape.local_functions[static_cast<std::size_t>(slot)];
    if (function < 0) continue;
    const Vector3d centre =
        model.refinement_basis()->centres().row(model.refinement_basis()->finer().Column(function));
    Vector3d p = centre + shape.offset_W + shape.local_displacements.row(slot).transpose();
    model.lattice_organ()->lattice().ForEachFunction(centre, [&](int column, double value) {
      p += value * shape.control_displacements.row(column).transpose();
    });
    points.row(used++) = p;
  }
  return points.topRows(used);
}

void AddLatticeMarks(const OrganModel& model, const Eigen::VectorXf& presence,
                     const OrganSnapshot& shape, Marks* marks) {
  if (model.lattice_organ() == nullptr) return;
  const Lattice& lattice = model.lattice_organ()->lattice();
  const TensorBasis& basis = lattice.basis();
  const Points points = DisplacedControlPoints(lattice, shape);
  // The lines of the coarsest level. What a front's functions have is no displacement.
  const int coarse = static_cast<int>(lattice.kept().size()),
            fronts = coarse - lattice.front_functions();
  for (int a = 0; a < fronts; ++a) {
    const int index = lattice.kept()[a];
    const int ny = basis.axis(1).count(), nz = basis.axis(2).count();
    const std::array<int, 3> at = {index / (ny * nz), index / nz % ny, index % nz};
    for (int d = 0; d < 3; ++d) {
      std::array<int, 3> next = at;
      if (++next[d] == basis.axis(d).count()) continue;
      const int b = lattice.Column(basis.Index(next[0], next[1], next[2]));
      if (b < 0 || std::min(presence[a], presence[b]) == 0) continue;
      marks->push_back({.a_W = points.row(a).cast<float>(),
                        .radius_a = 0.6f,
                        .b_W = points.row(b).cast<float>(),
                        .radius_b = 0.6f,
                        .colour = kLineColour,
                        .opacity = 0.5f * std::min(presence[a], presence[b])});
    }
  }
  for (Eigen::Index a = 0; a < points.rows(); ++a) {
    if (presence[a] == 0 || (fronts <= a && a < coarse)) continue;
    marks->push_back(PointAt(points, a, 2, kPointColour, presence[a]));
  }
  const Points local = DisplacedLocalFunctions(model, shape);
  for (Eigen::Index a = 0; a < local.rows(); ++a) {
    marks->push_back(PointAt(local, a, 2.6f, kLocalColour));
  }
}

}  // namespace hpdm
