#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/baselines/surface_error.h"
#include "engine/organ.h"
#include "engine/statics/static_loads.h"
#include "scenes/loader/scene.h"

/// The committed references are those of the committed cases.

namespace hpdm {
namespace {

const std::filesystem::path kProject = HPDM_SOURCE_DIR;

/// The rows of a reference: rest positions and displacements, V x 3, m.
std::pair<Points, Points> ReadCsv(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line, "x,y,z,ux,uy,uz");
  std::vector<double> numbers;
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) numbers.push_back(std::stod(field));
  }
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>> rows(
      numbers.data(), static_cast<Eigen::Index>(numbers.size() / 6), 6);
  return {rows.leftCols(3), rows.rightCols(3)};
}

class Reference : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Cases, Reference,
                         testing::Values("beam", "bent_organ_lift", "gallbladder_duct",
                                         "gallbladder_press", "liver_lift", "liver_lift_40mm",
                                         "liver_lift_40mm_firm_support",
                                         "liver_lift_40mm_soft_support", "liver_lift_5000",
                                         "liver_press", "liver_press_5000", "liver_press_tip_2_5mm",
                                         "liver_press_tip_5mm", "notch", "stomach_lift",
                                         "stomach_press"));

TEST_P(Reference, BelongsToItsCase) {
  const std::string name = GetParam();
  const Scene scene = LoadScene(kProject / "scenes/cases" / (name + ".toml"));
  std::vector<std::string> repairs;
  const SurfaceMesh rest = LoadPosedMesh(scene.organs.at(0), &repairs);
  const auto [vertices, u] = ReadCsv(kProject / "tests/reference" / (name + ".csv"));
  ASSERT_EQ(vertices.rows(), rest.vertices.rows());
  EXPECT_LT((vertices - rest.vertices).cwiseAbs().maxCoeff(), 1e-6);  // six digits

  std::ifstream file(kProject / "tests/reference" / (name + ".json"));
  const nlohmann::json facts = nlohmann::json::parse(file);
  EXPECT_EQ(facts["young_Pa"], scene.organs[0].material.young);
  EXPECT_EQ(facts["poisson"], scene.organs[0].material.poisson);
  const LoadOptions& load = scene.loads.at(0);
  const auto vector = [&](const char* key) {
    const auto v = facts["loads"][0][key].get<std::vector<double>>();
    return Vector3d(v[0], v[1], v[2]);
  };
  const Vector3d force = vector("force_N"), moved = vector("displacement_m");
  if (load.force_W) {
    EXPECT_LT((force - *load.force_W).norm(), 1e-9);
  } else {
    EXPECT_LT((moved - *load.displacement_W).norm(), 1e-9);
  }
  EXPECT_NEAR(facts["compliance_m_per_N"], moved.dot(force) / force.squaredNorm(),
              1e-9 * double{facts["compliance_m_per_N"]});
  EXPECT_NEAR(facts["surface_volume_change"], RelativeVolumeChange(rest, u), 1e-5);  // six digits
  // Support conditions hold: no vertex moves further than the loaded patch by more than half.
  EXPECT_LT(u.rowwise().norm().maxCoeff(), 1.6 * moved.norm());
}

TEST_P(Reference, HasConvergedFarBelowWhatItMeasures) {
  std::ifstream file(kProject / "tests/reference" / (std::string(GetParam()) + ".json"));
  const nlohmann::json facts = nlohmann::json::parse(file);
  const double change = facts["coarser_quadratic"].back()["error"];
  EXPECT_LT(change, 0.05);
  // The even linear meshes, which the models are to beat, are at least twice as far.
  for (const auto& mesh : facts["linear"]) {
    if (mesh["graded"]) continue;
    EXPECT_GT(double{mesh["error"]}, 2 * change);
  }
}

struct ClosedFormCase {
  const char* name;
  double error;  // at most
};

class ClosedForm : public testing::TestWithParam<ClosedFormCase> {};
INSTANTIATE_TEST_SUITE_P(
    Cases, ClosedForm,
    testing::Values(
        // The pull's end at the support, off the cells: measured 1.0 %.
        ClosedFormCase{"bar", 0.015},
        // A wall of one and a quarter cells bends 1 / r^2: measured 10.1 %, 5.2 % with 8 cells.
        ClosedFormCase{"sphere_pressure", 0.11}));

TEST_P(ClosedForm, TheLatticeAgreesWithIt) {
  const std::string name = GetParam().name;
  const Scene scene = LoadScene(kProject / "scenes/cases" / (name + ".toml"));
  std::vector<std::string> repairs;
  const OrganModel model(scene.organs.at(0), LoadPosedMesh(scene.organs[0], &repairs));
  const auto [vertices, u] = ReadCsv(kProject / "tests/reference" / (name + ".csv"));
  ASSERT_EQ(vertices.rows(), model.rest().vertices.rows());
  EXPECT_LT((vertices - model.rest().vertices).cwiseAbs().maxCoeff(), 1e-6);  // six digits
  std::ifstream file(kProject / "tests/reference" / (name + ".json"));
  const nlohmann::json facts = nlohmann::json::parse(file);
  EXPECT_EQ(facts["young_Pa"], scene.organs[0].material.young);
  EXPECT_EQ(facts["poisson"], scene.organs[0].material.poisson);
  EXPECT_EQ(facts["pressure_Pa"], scene.loads.at(0).pressure.value());

  const StaticSolution solution = StaticLoads(model, scene.loads).Solve();
  EXPECT_LT(RelativeSurfaceError(model.rest(), solution.vertex_displacements, u), GetParam().error);
}

TEST(SofaLiver, IsPressedAsFarAsTheReferenceSays) {
  const std::filesystem::path mesh = kProject / "../shared/data/organs/sofa_liver2.obj";
  if (!std::filesystem::exists(mesh)) GTEST_SKIP() << "no shared data: " << mesh;
  const Scene scene = LoadScene(kProject / "scenes/cases/sofa_liver2_press.toml");
  std::vector<std::string> repairs;
  const OrganModel model(scene.organs.at(0), LoadPosedMesh(scene.organs[0], &repairs));
  std::ifstream file(kProject / "tests/reference/sofa_liver2_press.json");
  const nlohmann::json facts = nlohmann::json::parse(file);
  EXPECT_EQ(facts["surface_vertices"], model.rest().vertices.rows());
  EXPECT_LT(double{facts["coarser_quadratic"].back()["error"]}, 0.02);
  const double ratio =
      StaticLoads(model, scene.loads).Solve().Compliance() / double{facts["compliance_m_per_N"]};
  // The lattice resolves a press of R = 15 mm: on liver_press it has 0.97 of the compliance. What
  // another shape and the support add is some per cent.
  EXPECT_GT(ratio, 0.90);
  EXPECT_LT(ratio, 1.05);
}

TEST(SurfaceMeshes, MeshesOfOneBodyGiveOneAnswer) {
  // Two meshes of one body: 1,332 triangles cut its curves short by up to 1 % of its size.
  for (const std::string name : {"liver_press", "liver_lift"}) {
    double compliance[2];
    for (const bool fine : {false, true}) {
      std::ifstream file(kProject / "tests/reference" / (name + (fine ? "_5000.json" : ".json")));
      compliance[fine] = nlohmann::json::parse(file)["compliance_m_per_N"];
    }
    EXPECT_NEAR(compliance[1] / compliance[0], 1, 0.05) << name;
  }
}

}  // namespace
}  // namespace hpdm
