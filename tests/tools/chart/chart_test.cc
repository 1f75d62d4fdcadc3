// Tests the results of `hpdm chart` and `hpdm bench` and both commands as a user runs them.

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "engine/baselines/surface_error.h"
#include "engine/statics/static_loads.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/read_file.h"
#include "tests/support/shapes.h"
#include "tools/bench/bench_results.h"
#include "tools/bench/power_law.h"
#include "tools/chart/chart_report.h"
#include "tools/chart/static_case_model.h"
#include "tools/shared/flat_subdivision.h"
#include "tools/shared/report_text.h"
#include "tools/shared/static_case.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = HPDM_SOURCE_DIR;
const std::string kPress = (kSource / "scenes/cases/liver_press.toml").string();

ChartPoint Point(double step_us, double error, const std::string& load_case = "case") {
  ChartPoint point;
  point.load_case = load_case;
  point.model = "hpdm";
  point.energy = "strain";
  point.strain = "small";
  point.basis = "bspline";
  point.solver = "cholesky";
  point.degree = 2;
  point.cells = {4, 4, 4};
  point.unknowns = 178;
  point.error = error;
  point.response = Timing{step_us, step_us};
  return point;
}

TEST(ChartPoints, ParetoFrontIsWhatNothingElseBeats) {
  std::vector<ChartPoint> points = {Point(100, 0.3),  Point(50, 0.4),  Point(100, 0.2),
                                    Point(200, 0.25), Point(300, 0.1), Point(60, 0.4)};
  EXPECT_EQ(ParetoFront(points), (std::vector<std::size_t>{1, 2, 4}));
  // Every point is on the front or beaten by one of it.
  for (const ChartPoint& point : points) {
    bool explained = false;
    for (const std::size_t f : ParetoFront(points)) {
      explained |= points[f].StepMicroseconds() <= point.StepMicroseconds() &&
                   points[f].error <= point.error;
    }
    EXPECT_TRUE(explained);
  }
}

TEST(ChartPoints, PointsThatDidNotConvergeOrWereNotTimedAreNeverBest) {
  std::vector<ChartPoint> points = {Point(10, 0.3), Point(5, 0.01), Point(4, 0.02), Point(3, 0.03)};
  points[1].converged = false;
  points[2].response.reset();  // linear tetrahedra: error only
  points[3].error = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(ParetoFront(points), (std::vector<std::size_t>{0}));
  EXPECT_EQ(BestWithin(points, 1e3), &points[0]);
  EXPECT_EQ(BestWithin(points, 9), nullptr);
}

TEST(ChartPoints, AStepIsChargedWithTheRelocationOfThirtyThousandTriangles) {
  ChartPoint point = Point(100, 0.1);
  point.relocation = Timing{10, 9};
  point.relocation_30k = Timing{250, 240};
  EXPECT_EQ(point.StepMicroseconds(), 350);
  EXPECT_EQ(point.StepMinimumMicroseconds(), 340);
}

TEST(ChartPoints, CsvColumnsStayAsScriptsKnowThem) {
  ChartPoint tetrahedra;
  tetrahedra.load_case = "case";
  tetrahedra.model = "linear_tetrahedra";
  const std::string csv = ChartCsv({Point(100, 0.25), tetrahedra}, {"processor: one"});
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "# processor: one");
  std::getline(lines, line);
  EXPECT_EQ(line,
            "case,hollow,model,energy,strain,basis,degree,cells,unknowns,solver,local_functions,"
            "local_refinement,error,compliance_ratio,fitted,iterations,residual,converged,setup_ms,"
            "response_us,response_min_us,relocation_us,relocation_min_us,relocation_30k_us,"
            "relocation_30k_min_us,step_us,step_min_us,adaptive_levels");
  const auto commas = std::count(line.begin(), line.end(), ',');
  while (std::getline(lines, line)) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), commas) << line;
  }
  EXPECT_NE(csv.find("case,0,linear_tetrahedra,,,,0,0,0,,0,0,0.0,,0,,,1,,,,,,,,,,0\n"),
            std::string::npos);  // absent values are empty
  const ChartPoint odd = Point(1, std::numeric_limits<double>::quiet_NaN(), "a \"b\", c");
  EXPECT_NE(ChartCsv({odd}, {}).find(
                "\n\"a \"\"b\"\", c\",0,hpdm,strain,small,bspline,2,4,178,cholesky,0,0,,"),
            std::string::npos);
}

TEST(ChartPoints, CellsThatDifferByAxisAreNamedEach) {
  ChartPoint point = Point(100, 0.05);
  EXPECT_EQ(Describe(point), "strain, quadratic B-spline 4^3, n 178");
  EXPECT_EQ(ToJson(point)["cells"], "4");
  point.cells = {14, 16, 7};
  EXPECT_EQ(Describe(point), "strain, quadratic B-spline 14 x 16 x 7, n 178");
  EXPECT_EQ(ToJson(point)["cells"], "14x16x7");
}

TEST(ChartPoints, ReportPutsHollowOrgansLastAndNamesTheBestOfEachBudget) {
  ChartPoint hollow = Point(100, 0.5, "stomach");
  hollow.hollow = true;
  const std::vector<ChartPoint> points = {hollow, Point(500, 0.08, "liver"),
                                          Point(20e3, 0.02, "liver"), Point(40e3, 0.01, "liver")};
  ASSERT_EQ(ByCase(points).size(), 2u);
  EXPECT_EQ(ByCase(points)[1][0].load_case, "stomach");
  const std::string text = ChartMarkdown(points, "one core");
  const std::string model = ": strain, quadratic B-spline 4^3, n 178 | ";
  EXPECT_NE(text.find("| `liver` | **8.0 %** (-), 500 us" + model + "**2.0 %** (-), 20 ms" + model +
                      "**2.0 %** (-), 20 ms" + model + "- |"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("| `stomach`, hollow | **50.0 %** (-), 100 us" + model + "the same | "),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("| `stomach`, hollow |"), std::string::npos);
}

TEST(ComparedTetrahedra, AreThoseOfTheFactsBesideTheTable) {
  const fs::path table = kSource / "tests/reference/liver_press.csv";
  std::set<std::string> kinds;
  for (const ComparedTetrahedra& mesh : ComparedBeside(table)) {
    kinds.insert(KindOf(mesh));
    EXPECT_GT(mesh.nodes, 1000);
    EXPECT_GT(mesh.error, 0.05);
  }
  EXPECT_EQ(kinds,
            (std::set<std::string>{"linear tetrahedra of one size", "linear tetrahedra, graded",
                                   "quadratic tetrahedra, graded"}));
  EXPECT_TRUE(ComparedBeside("missing.csv").empty());
  EXPECT_TRUE(ComparedBeside(kSource / "README.md").empty());
}

TEST(PowerLaws, ExponentAndFactorOfAnExactLawAreFound) {
  std::vector<double> x, y;
  for (const double size : {8., 60., 335., 1300.}) {
    x.push_back(size);
    y.push_back(0.02 * std::pow(size, 1.7));
  }
  const PowerLaw law = FitPowerLaw(x, y);
  EXPECT_NEAR(law.exponent, 1.7, 1e-12);  // round-off
  EXPECT_NEAR(law.factor, 0.02, 1e-12);
  EXPECT_NEAR(law.r_squared, 1, 1e-12);
}

TEST(PowerLaws, NoiseLeavesTheExponentAndLowersRSquared) {
  // Noise of +-10 % that is symmetric about the middle in log x has no slope of its own.
  const std::vector<double> x = {1, 10, 100, 1000};
  const std::vector<double> y = {1.1, 100 / 1.1, 1e4 / 1.1, 1.1e6};
  const PowerLaw law = FitPowerLaw(x, y);
  EXPECT_NEAR(law.exponent, 2, 1e-12);
  EXPECT_LT(law.r_squared, 1 - 1e-5);
  EXPECT_GT(law.r_squared, 0.999);
}

TEST(Timings, WorksAreTimedInTurnAndSummarised) {
  std::string order;
  const auto times = TimeInTurn({[&] { order += 'a'; }, [&] { order += 'b'; }}, {3, 3, 0});
  EXPECT_EQ(order, "abababab");  // one round before, unmeasured
  EXPECT_EQ(times[0].size(), 3u);
  const Timing summary = Summary({5, 1, 9, 3, 7});
  EXPECT_EQ(summary.median_us, 5);
  EXPECT_EQ(summary.minimum_us, 1);
}

TEST(BenchResults, RatioComesFromTheRoundsAndNotFromTheMedians) {
  // The machine slows down in the middle for both: the ratio does not notice.
  const RatioSpread ratio = RatioOf({20, 20, 80, 80, 20}, {10, 10, 40, 40, 10});
  EXPECT_EQ(ratio.median, 2);
  EXPECT_EQ(ratio.low, 2);
  EXPECT_EQ(ratio.high, 2);
  const RatioSpread wide = RatioOf({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, std::vector<double>(11, 1));
  EXPECT_EQ(wide.low, 2);
  EXPECT_EQ(wide.median, 6);
  EXPECT_EQ(wide.high, 10);
}

TEST(BenchResults, MarkdownHasARowForEachComparison) {
  BenchResults results;
  results.models.push_back({"strain", "anew", false, {20, 19}, {100, 90}, 1e-13, 1e-12, {5, 4, 6}});
  results.models.push_back({"strain", "anew", true, {50, 49}, {400, 390}, 1e-13, 1e-12, {8, 7, 9}});
  results.models.push_back({"metric", "anew", false, {10, 9}, {40, 30}, 1e-13, 1e-12, {4, 3, 5}});
  results.meshes.push_back({"strain", 2, 1124, {10, 9}, {15, 14}, 274, 1332, {1.5, 1.4, 1.6}});
  results.costs.push_back(
      {"relocate", "vertices", {550, 500000}, {8, 9000}, {1.02, 1, 0.999}, 2000});
  const std::string text = BenchMarkdown(results, "one core");
  for (const char* row :
       {"| strain | anew | 50,000 | 10,000 | 5 (4-6) | 20,000 | 2,500 | 8 (7-9) | 1e-13 / 1e-12 "
        "|\n",
        "| metric | anew | 100,000 | 25,000 | 4 (3-5) | - | - | - | 1e-13 / 1e-12 |\n",
        "| strain | 2, of 1,124 polygons together | 100,000 | 66,667 | 1.5 (1.4-1.6) |\n"}) {
    EXPECT_NE(text.find(row), std::string::npos) << row << text;
  }
  EXPECT_NE(text.find("| relocate | 550 vertices: 8 us | 500,000: 9 ms | 1.02 | 0.999 | 2,000 |"),
            std::string::npos)
      << text;
}

TEST(BenchResults, MarkdownHasOnlyMeasuredResults) {
  BenchResults results;
  results.ticks.resize(2);
  TickResults& ticks = results.ticks.back();
  ticks.organs = 2;
  ticks.coarse_triangles = 274;
  ticks.fine_triangles = 120000;
  ticks.ratio = {1.1, 1, 1.2};
  for (int i = 1; i <= 4; ++i) ticks.fine.Add(i);
  const std::string text = BenchMarkdown(results, "one core");
  EXPECT_NE(text.find("| tick, two organs each, 120,000 triangles | 0.00 | 0.00 | 0.00 | 0.00 |"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("Many triangles over few, two organs each: 1.1 (1-1.2)."), std::string::npos)
      << text;
  for (const char* other : {"Table 1", "Table 2", "Cost against size", "hand-over"}) {
    EXPECT_EQ(text.find(other), std::string::npos) << other;
  }
}

TEST(ReportText, NumbersReadAsPeopleWriteThem) {
  EXPECT_EQ(WithCommas(1234567), "1,234,567");
  EXPECT_EQ(WithCommas(-123), "-123");
  EXPECT_EQ(Duration(12.34), "12.3 us");
  EXPECT_EQ(Duration(999.7), "1 ms");
  EXPECT_EQ(Duration(2.5e6), "2.5 s");
}

TEST(FlatSubdivision, KeepsTheSurfaceAndStaysClosed) {
  const SurfaceMesh coarse = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 1);
  const SurfaceMesh fine = FlatSubdivided(coarse);
  EXPECT_EQ(fine.triangles.rows(), 4 * coarse.triangles.rows());
  EXPECT_EQ(fine.vertices.rows(), 2 * coarse.triangles.rows() + 2);  // Euler: of a sphere
  EXPECT_NEAR(EnclosedVolume(fine.vertices, fine.triangles) /
                  EnclosedVolume(coarse.vertices, coarse.triangles),
              1, 1e-12);  // round-off
  EXPECT_EQ(fine.vertices.topRows(coarse.vertices.rows()), coarse.vertices);
}

TEST(StaticCases, ACavityMakesAnOrganHollow) {
  const SurfaceMesh outer = MakeSphere(1, 0.1);
  EXPECT_FALSE(IsHollow(outer));
  EXPECT_TRUE(IsHollow(Joined(outer, Reversed(MakeSphere(1, 0.08)))));
  EXPECT_FALSE(IsHollow(Joined(MakeBox(Vector3d::Zero(), Vector3d::Ones()),
                               MakeBox(Vector3d::Constant(2), Vector3d::Constant(3)))));
}

// The real-time step under grasped patches against the static solver under the forces.
TEST(StaticCaseModels, StepsToTheStaticSolution) {
  StaticCase load_case = LoadStaticCase(kPress);
  load_case.organ.lattice.local.functions = 27;
  StaticCaseModel body(load_case, load_case.organ);
  EXPECT_EQ(body.local_functions(), 27);
  ASSERT_TRUE(body.Balance());
  const StaticCaseModel::StepTimes times = body.TimeSteps();
  EXPECT_GT(times.response.minimum_us, 0);
  EXPECT_LE(times.response.minimum_us, times.response.median_us);
  EXPECT_GT(times.relocation.minimum_us, 0);
  const OrganModel model(load_case.organ, load_case.rest);
  const StaticSolution solution = StaticLoads(model, load_case.scene.loads).Solve();
  // The tolerance of the force and a part in 1e9 of the contacts' padding.
  EXPECT_LT(RelativeSurfaceError(load_case.rest, body.VertexDisplacements(),
                                 solution.vertex_displacements),
            2e-4);
  EXPECT_NEAR(body.Compliance() / solution.Compliance(), 1, 2e-4);
}

TEST(StaticCaseModels, SurfaceModelsFollowThePatchOfTheReference) {
  const StaticCase load_case = LoadStaticCase(kPress);
  const CaseReference reference = LoadCaseReference(load_case, kSource / "tests/reference");
  OrganOptions options = load_case.organ;
  options.model = OrganModelType::kContinuum;
  StaticCaseModel body(load_case, options);
  EXPECT_EQ(body.unknowns(), load_case.rest.vertices.rows());
  body.MoveTo(reference.displacements);
  const double error =
      RelativeSurfaceError(load_case.rest, body.VertexDisplacements(), reference.displacements);
  EXPECT_LT(error, 1);  // nearer than standing still
  EXPECT_GT(error, 0);
}

// The programs, as a user runs them.
class FlowChart : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / (std::string("hpdm_chart_") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  int Hpdm(const std::string& arguments) {
    const fs::path program = fs::path(HPDM_BINARY_DIR) / "tools" / "hpdm";
    const int status = std::system(("cd " + folder_.string() + " && " + program.string() + " " +
                                    arguments + " >stdout 2>stderr </dev/null")
                                       .c_str());
    out_ = ReadFile(folder_ / "stdout");
    err_ = ReadFile(folder_ / "stderr");
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  fs::path folder_;
  std::string out_, err_;
};

TEST_F(FlowChart, WritesEveryFormOfTheSamePoints) {
  const std::string beam = (kSource / "scenes/cases/beam.toml").string();
  ASSERT_EQ(Hpdm("chart " + beam + " --quick --out chart"), 0) << err_;
  EXPECT_NE(out_.find("within  1 ms: error"), std::string::npos) << out_;
  const nlohmann::json json = nlohmann::json::parse(ReadFile(folder_ / "chart/chart.json"));
  EXPECT_FALSE(json["machine"]["flags"].get<std::string>().empty());
  EXPECT_FALSE(json["machine"]["processor"].get<std::string>().empty());
  const std::string csv = ReadFile(folder_ / "chart/chart.csv");
  const auto rows = std::count(csv.begin(), csv.end(), '\n') - 5;  // four facts and the names
  EXPECT_EQ(static_cast<std::size_t>(rows), json["points"].size());
  std::set<std::string> models;
  for (const auto& point : json["points"]) {
    models.insert(point["model"]);
    EXPECT_GE(point["error"].get<double>(), 0);
    EXPECT_TRUE(point["step_us"].is_null() || point["step_us"].get<double>() > 0);
  }
  EXPECT_EQ(models,
            (std::set<std::string>{"continuum", "hpdm", "linear_graded", "linear_tetrahedra",
                                   "mass_spring", "quadratic_graded"}));
  EXPECT_NE(ReadFile(folder_ / "chart/chart.md").find("| `beam` |"), std::string::npos);
  if (err_.find("no plot") == std::string::npos) {
    EXPECT_EQ(ReadFile(folder_ / "chart/chart.png").substr(1, 3), "PNG");
    EXPECT_NE(ReadFile(folder_ / "chart/chart.svg").find("<svg"), std::string::npos);
  }
}

TEST_F(FlowChart, WithoutACaseOrItsReferenceSaysWhatToDo) {
  EXPECT_EQ(Hpdm("chart --out chart"), 2);  // no scenes/cases here
  EXPECT_NE(err_.find("scenes/cases"), std::string::npos) << err_;
  EXPECT_EQ(Hpdm("chart missing.toml --out chart"), 2);
  EXPECT_NE(err_.find("missing.toml"), std::string::npos) << err_;
  EXPECT_EQ(Hpdm("chart " + kPress + " --references . --out chart"), 2);
  EXPECT_NE(err_.find("liver_press.csv: is missing; create it with hpdm_yardstick"),
            std::string::npos)
      << err_;
  std::ofstream(folder_ / "liver_press.csv")
      << ReadFile(kSource / "tests/reference/liver_press.csv");
  std::ofstream(folder_ / "liver_press.json") << "{}";
  EXPECT_EQ(Hpdm("chart " + kPress + " --references . --out chart"), 2);
  EXPECT_NE(err_.find("liver_press.json: does not hold a reference solution"), std::string::npos)
      << err_;
  EXPECT_FALSE(fs::exists(folder_ / "chart"));  // nothing was measured or written
}

}  // namespace
}  // namespace hpdm
