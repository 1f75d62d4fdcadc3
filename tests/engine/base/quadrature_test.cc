#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <filesystem>

#include "engine/baselines/surface_error.h"
#include "engine/contact/surface_kernel.h"
#include "engine/organ.h"
#include "engine/tissue/interior.h"
#include "engine/tissue/support.h"
#include "scenes/loader/scene.h"

/// Checks that the interior has enough quadrature points for the surface displacement.

namespace hpdm {
namespace {

/// Returns the surface displacement of a case under its first load, integrated over `tissue`.
Points Displacement(const OrganModel& model, const LoadOptions& load, const Quadrature& tissue) {
  const OrganOptions& options = model.options();
  const Lattice& lattice = model.lattice_organ()->lattice();
  std::vector<Quadrature> regions;
  const Box bounds = AxisAlignedBounds(model.rest().vertices);
  for (const SupportOptions& support : options.supports) {
    regions.push_back(SampleSupport(model.rest(), support, bounds, ControlPointSpacing(lattice)));
  }
  FullStiffness K = StrainStiffness(lattice, tissue, options.material, Dilatation::kProjected);
  AddAlongEachAxis(
      SupportStiffness(lattice, tissue, options.supports, regions, options.material.young), &K);
  Points forces = Points::Zero(model.rest().vertices.rows(), 3);
  for (const SurfaceSample& s : SurfaceKernel(model.rest(), load.p_centre_W, load.radius)) {
    for (int k = 0; k < 3; ++k) {
      forces.row(model.rest().triangles(s.triangle, k)) +=
          s.weight * s.barycentric[k] * load.force_W->transpose();
    }
  }
  const WeightMatrix weights = lattice.Weights(model.rest().vertices);
  Points U = weights.transpose() * forces;
  Eigen::Map<Eigen::VectorXd> unknowns(U.data(), U.size());
  unknowns = K.llt().solve(unknowns).eval();
  return weights * U;
}

class QuadraturePoints : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(SolidAndHollow, QuadraturePoints,
                         testing::Values("liver_press", "stomach_press"));

TEST_P(QuadraturePoints, DoublingChangesTheResultByLessThanOnePercent) {
  const std::filesystem::path cases = std::filesystem::path(HPDM_SOURCE_DIR) / "scenes/cases";
  Scene scene = LoadScene(cases / (std::string(GetParam()) + ".toml"));
  scene.organs.at(0).lattice.cells = {4, 4, 4};  // large cells have the most samples each
  std::vector<std::string> repairs;
  const OrganModel model(scene.organs.at(0), LoadPosedMesh(scene.organs[0], &repairs));
  const auto sample = [&](const InteriorOptions& options) {
    const TissueQuadrature tissue =
        SampleTissue(model.rest(), model.lattice_organ()->lattice().box(),
                     scene.organs[0].lattice.cells, options);
    return Quadrature{tissue.points, tissue.weights};
  };
  const auto displacement = [&](const Quadrature& tissue) {
    return Displacement(model, scene.loads.at(0), tissue);
  };
  const Quadrature base = sample({});
  const Points u = displacement(base);
  // Twice the points in the cells, and twice the samples along each axis at the surface.
  const Quadrature finer = sample({.resolution = 256, .gauss_points = 4, .moment_degree = 4});
  EXPECT_GT(finer.weights.size(), 1.8 * static_cast<double>(base.weights.size()));
  EXPECT_LT(RelativeSurfaceError(model.rest(), u, displacement(finer)), 0.01);
}

}  // namespace
}  // namespace hpdm
