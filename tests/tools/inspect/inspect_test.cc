#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/base/error.h"
#include "tools/command_line.h"
#include "tools/commands.h"

namespace hpdm {
namespace {

std::string Inspect(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "inspect");
  testing::internal::CaptureStdout();
  try {
    RunCommandLine("hpdm", "", "", std::move(arguments),
                   [](Command app) { AddInspectCommand(app); });
  } catch (...) {
    testing::internal::GetCapturedStdout();
    throw;
  }
  return testing::internal::GetCapturedStdout();
}

std::string Tetrahedron() {
  const std::string path = testing::TempDir() + "inspect_" +
                           testing::UnitTest::GetInstance()->current_test_info()->name() + ".obj";
  std::ofstream(path) << "v 0 0 0\nv 30 0 0\nv 0 20 0\nv 0 0 10\nv 9 9 9\n"
                         "f 1 2 3\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  return path;
}

TEST(Inspect, JsonHoldsThePromisedKeysInMetres) {
  const auto json = nlohmann::json::parse(Inspect({Tetrahedron(), "--unit", "mm", "--json"}));
  EXPECT_EQ(json.at("vertices"), 4);
  EXPECT_EQ(json.at("triangles"), 4);
  EXPECT_EQ(json.at("boundary_edges"), 0);
  EXPECT_EQ(json.at("nonmanifold_edges"), 0);
  EXPECT_EQ(json.at("components"), 1);
  EXPECT_NEAR(json.at("volume_m3").get<double>(), 1e-6, 1e-18);  // round-off
  EXPECT_EQ(json.at("repairs"),
            nlohmann::json({{"unreferenced_vertices", 1}, {"reoriented_triangles", 1}}));
}

TEST(Inspect, TextNamesFactsAndRepairs) {
  const std::string text = Inspect({Tetrahedron(), "--unit", "0.001"});
  EXPECT_NE(text.find("4 vertices, 4 triangles"), std::string::npos) << text;
  EXPECT_NE(text.find("unreferenced_vertices 1"), std::string::npos) << text;
}

TEST(Inspect, BadUnitsAndMeshesAreInputErrors) {
  for (const char* unit : {"inch", "0", "-1", "nan", "1,5", ""}) {
    EXPECT_THROW(Inspect({Tetrahedron(), "--unit", unit}), InputError) << unit;
  }
  EXPECT_THROW(Inspect({"/no/such.obj"}), InputError);
}

TEST(Inspect, RefusesASizeOfNoOrganUnlessTheUnitIsStated) {
  try {
    Inspect({Tetrahedron()});
    FAIL() << "a mesh of 30 m in metres";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("30 m across"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("; give --unit "), std::string::npos) << error.what();
  }
  EXPECT_NE(Inspect({Tetrahedron(), "--unit", "m"}).find("volume      1e+06 l"), std::string::npos);
}

}  // namespace
}  // namespace hpdm
