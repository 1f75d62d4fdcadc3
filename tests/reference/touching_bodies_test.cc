#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "engine/baselines/surface_error.h"
#include "tools/shared/organ_bench.h"
#include "tools/shared/touching_bodies.h"

namespace hpdm {
namespace {

const std::filesystem::path kFolder = std::filesystem::path(HPDM_SOURCE_DIR) / "tests/reference";

nlohmann::json Facts() {
  std::ifstream file(kFolder / "touching_bodies.json");
  return nlohmann::json::parse(file);
}

// Rest positions and displacements of both surfaces, one below the other.
Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> Rows() {
  std::ifstream file(kFolder / "touching_bodies.csv");
  std::string line;
  std::getline(file, line);
  std::vector<double> numbers;
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) numbers.push_back(std::stod(field));
  }
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>>(
      numbers.data(), static_cast<Eigen::Index>(numbers.size() / 6), 6);
}

TEST(TouchingBodies, ReferenceHasConverged) {
  const nlohmann::json facts = Facts();
  EXPECT_EQ(facts["press_m"], kTouchingPress);
  const nlohmann::json& last = facts["coarser"].back();
  for (const nlohmann::json& each : {last, facts["penalty_a_fifth"]}) {
    EXPECT_NEAR(double{each["force_N"][2]} / double{facts["force_N"][2]}, 1, 0.03);
    for (const double error : each["errors"]) EXPECT_LT(error, 0.03);
  }
}

// A soft body pressed onto a stiffer one: the force and both surfaces, as the step has them.
TEST(TouchingBodies, PressEachOtherAsTetrahedraDo) {
  OrganBench bench;
  std::vector<int> nodes;
  for (std::size_t b = 0; b < 2; ++b) {
    const TouchingBody& body = kTouchingBodies[b];
    OrganOptions options = TouchingOptions(body);
    options.lattice.cells = {6, 6, 6};
    options.lattice.margin = 0.001;
    if (b == 1) options.motion = {Vector3d(0, 0, -kTouchingPress), 0.5};
    bench.Add(options, TouchingSurface(TouchingMesh(body, kTouchingBricks), &nodes),
              b == 1 ? std::optional(0.0) : std::nullopt);
  }
  bench.Start();
  for (int step = 0; step <= 50; ++step) {
    bench.StayAt(std::min(1.0, step / 30.0));
    bench.Step();
  }
  const nlohmann::json facts = Facts();
  const auto rows = Rows();
  const double force = facts["force_N"][2];
  EXPECT_NEAR(bench.PairForce(1).z(), force, 0.08 * force);
  Eigen::Index first = 0;
  for (int b = 0; b < 2; ++b) {
    const Points& rest = bench.model(b).rest().vertices;
    ASSERT_LE(first + rest.rows(), rows.rows());
    const auto of_body = rows.middleRows(first, rest.rows());
    ASSERT_LT((of_body.leftCols(3) - rest).cwiseAbs().maxCoeff(), 1e-6);  // six digits
    const Points u = bench.organ(b).vertices - rest;
    const double error = RelativeSurfaceError(bench.model(b).rest(), u, of_body.rightCols(3));
    EXPECT_LT(error, 0.08) << bench.model(b).options().name;
    RecordProperty(bench.model(b).options().name, std::to_string(error));
    first += rest.rows();
  }
}

}  // namespace
}  // namespace hpdm
