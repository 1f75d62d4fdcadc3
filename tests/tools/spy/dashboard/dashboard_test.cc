#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/deformation_loop.h"
#include "lcmtypes/wire/logged_surface.h"
#include "tests/support/browser.h"
#include "tests/support/dashboard_spy.h"
#include "tests/support/made_session.h"
#include "tests/support/network_namespace.h"
#include "tests/support/shapes.h"
#include "tools/shared/one_organ.h"
#include "tools/spy/dashboard/dashboard_server.h"

/// `hpdm spy --web` in a real browser.

namespace hpdm {
namespace {

using nlohmann::json;

constexpr char kProgram[] = HPDM_BINARY_DIR "/tools/hpdm";
constexpr char kScene[] = HPDM_SOURCE_DIR "/scenes/two_hands.toml";

/// Facts of the log that the page shows.
struct Truth {
  std::map<std::string, int> messages;
  std::array<double, 2> peak_force{}, peak_depth{};
};

Truth TruthOf(const std::string& log) {
  Truth truth;
  LogReader reader(log);
  for (LogEvent event; reader.Next(&event);) {
    ++truth.messages[event.channel];
    force_t force;
    if (event.channel == kForceChannel && DecodeMessage(event.data, &force)) {
      for (std::size_t i = 0; i < force.tools.size(); ++i) {
        const double newton = Eigen::Map<const Vector3d>(force.tools[i].force).norm();
        truth.peak_force[i] = std::max(truth.peak_force[i], newton);
        truth.peak_depth[i] = std::max(truth.peak_depth[i], force.tools[i].depth);
      }
    }
  }
  return truth;
}

std::string Text(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

// Sets a form's field as a hand does.
void Set(Browser* browser, const char* selector, const std::string& value) {
  browser->Execute(
      "const field = document.querySelector(arguments[0]); field.value = arguments[1];"
      "field.dispatchEvent(new Event('input')); field.dispatchEvent(new Event('change'));",
      {selector, value});
}

bool WaitForState(Browser* browser, const std::string& state, double seconds = 20) {
  return browser->WaitFor("document.getElementById('state').textContent == '" + state + "'",
                          seconds);
}

/// The vertices that the page draws of an organ.
Points Vertices(Browser* browser, int organ) {
  const json values = browser->Execute(
      "return Array.from(hpdm.scene.organs.get(arguments[0]).surface.positions)", {organ});
  Points vertices(static_cast<Eigen::Index>(values.size() / 3), 3);
  for (std::size_t i = 0; i < values.size(); ++i) vertices.data()[i] = values[i].get<double>();
  return vertices;
}

class DashboardTest : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = Browser::WhyMissing(); !why.empty()) GTEST_SKIP() << why;
  }
};

TEST_F(DashboardTest, ShowsALogAsItIs) {
  const Truth truth = TruthOf(TwoHandsLog());
  ASSERT_GT(truth.peak_force[0], 0.1);
  ASSERT_GT(truth.peak_force[1], 0.1);
  Spy spy(TwoHandsLog());
  ASSERT_FALSE(spy.address().empty()) << spy.errors();
  Browser browser;
  browser.Open(spy.address());
  ASSERT_TRUE(WaitForState(&browser, "end of the log"));
  ASSERT_TRUE(
      browser.WaitFor("hpdm.session.channels.length == 7 && hpdm.scene.organs.get(0).mesh"));
  ASSERT_TRUE(browser.WaitFor("document.querySelector('[data-event=\"session.end\"]')"));

  for (int i = 0; i < 2; ++i) {
    const std::string card = "#hands > :nth-child(" + std::to_string(i + 1) + ")";
    EXPECT_EQ(browser.Text(card + " .name"), i == 0 ? "probe" : "grasper");
    EXPECT_NE(browser.Text(card + " .force-peak").find(Text("peak %.2f N", truth.peak_force[i])),
              std::string::npos);
    EXPECT_NE(
        browser.Text(card + " .depth-peak").find(Text("peak %.1f mm", 1000 * truth.peak_depth[i])),
        std::string::npos);
  }
  // The chart's peak is the log's: to single precision, as rows are sent.
  const double charted =
      browser.Execute("return Math.max(...hpdm.charts.force.data[1])").get<double>();
  EXPECT_NEAR(charted, truth.peak_force[0], 1e-6 * truth.peak_force[0]);
  // Channels are sent once a second.
  ASSERT_TRUE(
      browser.WaitFor("hpdm.session.channels.reduce((sum, {messages}) => sum + messages, 0)"
                      " == hpdm.session.status.messages"));
  for (const auto& [channel, messages] : truth.messages) {
    const json shown = browser.Execute(
        "return hpdm.session.channels.find(({channel}) => channel == arguments[0])", {channel});
    ASSERT_TRUE(shown.is_object()) << channel;
    EXPECT_EQ(shown["messages"], messages) << channel;
    EXPECT_EQ(shown["lost"], 0) << channel;
    EXPECT_EQ(shown["unreadable"], 0) << channel;
  }
  EXPECT_NE(browser.Text("#loops").find("1000"), std::string::npos);
  EXPECT_NE(browser.Text("[data-latency=\"haptic.period\"]").find("1 ms"), std::string::npos);
  EXPECT_EQ(browser.Text("#notices"), "");
  EXPECT_EQ(browser.Text("#legend span"), "liver");
  // The canvas is not a single colour.
  EXPECT_GT(browser
                .Execute("const gl = document.querySelector('#scene canvas').getContext('webgl2');"
                         "const n = 4 * gl.drawingBufferWidth * gl.drawingBufferHeight;"
                         "const p = new Uint8Array(n); gl.readPixels(0, 0, gl.drawingBufferWidth,"
                         "gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, p);"
                         "let drawn = 0; for (let i = 3; i < n; i += 4) drawn += p[i] > 0;"
                         "return drawn / n * 4")
                .get<double>(),
            0.05);

  EXPECT_EQ(browser.Errors(), std::vector<std::string>());
  for (const std::string& request : browser.Requests()) {
    EXPECT_TRUE(request.starts_with(spy.address())) << request;
  }
}

TEST_F(DashboardTest, ShowsScoreTimeStepAndErrorsOfAnExercise) {
  ExerciseOptions exercise;
  exercise.name = "soft touch";
  exercise.time_limit = 10;
  exercise.target_time = 5;
  exercise.steps = {{.name = "press", .touches = ExerciseContact{1, {}}},
                    {.name = "free", .instruction = "Free the bed", .frees = {0}, .freed_area = 1}};
  exercise.errors = {{.name = "more than 3 N", .limit = 3, .points = 7}};
  MadeSession session({"probe"}, {}, exercise);
  for (int step = 0; step < 8; ++step) {
    session.Press(33, 4, 1);
    session.PressStep(4, 1);
  }
  const ExerciseResult result = session.telemetry().Summary().exercise.value();
  session.Finish();
  Spy spy(session.log());
  ASSERT_FALSE(spy.address().empty()) << spy.errors();
  Browser browser;
  browser.Open(spy.address());
  ASSERT_TRUE(WaitForState(&browser, "end of the log"));
  ASSERT_TRUE(browser.WaitFor("!document.getElementById('exercise').hidden"));
  EXPECT_EQ(browser.Text("#exercise .name"), "soft touch");
  EXPECT_EQ(browser.Text("#exercise .instruction"), "2/2 Free the bed");
  EXPECT_EQ(browser.Text("#exercise .error"), "more than 3 N (at 0.0 s)");
  EXPECT_EQ(browser.Text("#exercise .score"), Text("%.0f", result.score));
  EXPECT_EQ(browser.Text("#exercise .errors"), "1");
  EXPECT_EQ(browser.Text("#exercise .restarts"), "0");
  EXPECT_EQ(browser.Text("#exercise .left"), "10 s");
  EXPECT_EQ(browser.Errors(), std::vector<std::string>());
}

TEST_F(DashboardTest, ASessionWithoutAnExerciseHasNoPanelAndTheColoursAreKept) {
  Spy spy(TwoHandsLog());
  ASSERT_FALSE(spy.address().empty()) << spy.errors();
  Browser browser;
  browser.Open(spy.address());
  ASSERT_TRUE(browser.WaitFor("hpdm.session.rows.length > 0"));
  EXPECT_TRUE(browser.Execute("return document.getElementById('exercise').hidden"));
  const std::string bad =
      "return getComputedStyle(document.documentElement).getPropertyValue('--bad')";
  const json standard = browser.Execute(bad);
  browser.Click("#palette");
  const json safe = browser.Execute(bad);
  EXPECT_NE(safe, standard);
  EXPECT_EQ(browser.Execute("return document.getElementById('palette').ariaPressed"), "true");
  browser.Open(spy.address());
  ASSERT_TRUE(browser.WaitFor("hpdm.session.rows.length > 0"));
  EXPECT_EQ(browser.Execute(bad), safe) << "kept in the browser";
  browser.Open(spy.address() + "?palette=standard");
  ASSERT_TRUE(browser.WaitFor("hpdm.session.rows.length > 0"));
  EXPECT_EQ(browser.Execute(bad), standard) << "by the address";
}

TEST_F(DashboardTest, PlaysPausesAndSeeks) {
  // Ten times slower: the 3 s of the log are not over before a browser has started.
  Spy spy(TwoHandsLog(), 0, "--speed 0.1");
  ASSERT_FALSE(spy.address().empty()) << spy.errors();
  Browser browser;
  browser.Open(spy.address());
  ASSERT_TRUE(browser.WaitFor("hpdm.session.status && hpdm.session.rows.length > 0"));
  browser.Click("#play");
  ASSERT_TRUE(WaitForState(&browser, "log, paused"));
  EXPECT_EQ(browser.Text("#play"), "Play");
  const double paused_at =
      browser.Execute("return hpdm.session.status.player.position").get<double>();

  EXPECT_GT(paused_at, 0);
  ASSERT_TRUE(browser.WaitFor("hpdm.session.updates > " +
                              browser.Execute("return hpdm.session.updates").dump()));
  EXPECT_EQ(browser.Execute("return hpdm.session.status.player.position"), paused_at);

  Set(&browser, "#seek", "2");
  ASSERT_TRUE(browser.WaitFor("hpdm.session.status.player.position == 2"));
  // Events before the position are sent without playing; meshes stay.
  ASSERT_TRUE(browser.WaitFor("hpdm.session.tools?.time > 1.9 && hpdm.session.tools.step > 0"));
  EXPECT_LT(browser.Execute("return hpdm.session.tools.time - 0.9").get<double>(), 2.01);
  EXPECT_TRUE(browser.Execute("return hpdm.scene.organs.get(0).mesh != null"));
  EXPECT_EQ(browser.Execute("return hpdm.session.status.player.position"), 2);
  EXPECT_NE(browser.Text("#events").find("session.start"), std::string::npos);
  EXPECT_EQ(browser.Text("#notices"), "") << "a seek is no loss";

  browser.Click("#play");
  ASSERT_TRUE(WaitForState(&browser, "log, playing"));
  ASSERT_TRUE(browser.WaitFor("hpdm.session.status.player.position > 2.02"));
  Set(&browser, "#speed", "10");
  ASSERT_TRUE(WaitForState(&browser, "end of the log"));
  EXPECT_EQ(browser.Text("#play"), "Replay");
  Set(&browser, "#speed", "0.1");
  browser.Click("#play");
  EXPECT_TRUE(browser.WaitFor("hpdm.session.status.player.position < 1"));
  EXPECT_EQ(browser.Errors(), std::vector<std::string>());
}

struct SurfaceCase {
  BasisType basis;
  int degree;
  int local_functions;
};

/// An ellipsoid on such a lattice, pressed by one probe.
struct PressedEllipsoid {
  explicit PressedEllipsoid(const SurfaceCase& test)
      : options(Options(test)), models(OneOrgan(options, Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3))) {
    DeformationLoop loop(models, {ToolOptions()}, {tools, patch, render, telemetry});
    ToolState state;
    state.tool_count = 1;
    for (const double z : {0.055, 0.050, 0.047, 0.044, 0.040}) {
      ++state.tick;
      state.tools[0].X_WT.translation() = Vector3d(0.02, 0.01, z);
      state.tools[0].p_trocar_W = Vector3d(0.02, 0.01, 0.3);
      loop.Step(state, 0);
    }
    render.Update();
    telemetry.Update();
  }

  static OrganOptions Options(const SurfaceCase& test) {
    OrganOptions options;
    options.name = "ellipsoid";
    options.energy.type = EnergyType::kStrain;
    options.lattice.basis = test.basis;
    options.lattice.degree = {test.degree, test.degree, test.degree};
    options.lattice.cells = {3, 4, 5};
    if (test.basis == BasisType::kBernstein) options.lattice.cells = {1, 1, 1};
    options.lattice.local.functions = test.local_functions;
    options.supports.push_back({BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}});
    return options;
  }

  OrganDescription Description() const {
    const Lattice& lattice = models[0].lattice_organ()->lattice();
    OrganDescription description{
        "ellipsoid", models[0].rest().vertices, models[0].rest().triangles, {}};
    description.lattice =
        LatticeDescription{.basis = options.lattice.basis,
                           .degree = options.lattice.degree,
                           .cells = options.lattice.cells,
                           .origin_W = lattice.box().origin_W,
                           .axes = lattice.box().axes,
                           .lengths = lattice.box().lengths,
                           .kept = lattice.kept(),
                           .local_refinement = options.lattice.local.functions > 0 ? 2 : 0};
    return description;
  }

  OrganOptions options;
  std::vector<OrganModel> models;
  TripleBuffer<ToolState> tools;
  TripleBuffer<ContactPatch> patch;
  TripleBuffer<SceneSnapshot> render{SizedSnapshot(models, 1, true)};
  TripleBuffer<SceneSnapshot> telemetry{SizedSnapshot(models, 1, false)};
};

// The page rebuilds the engine's surface from messages, for each kind of lattice.
TEST_F(DashboardTest, RebuildsSurfacesAsTheEngineHasThem) {
  Browser browser;
  for (const SurfaceCase& test :
       {SurfaceCase{BasisType::kBSpline, 1, 20}, SurfaceCase{BasisType::kBSpline, 2, 20},
        SurfaceCase{BasisType::kBSpline, 3, 20}, SurfaceCase{BasisType::kBernstein, 4, 0}}) {
    PressedEllipsoid pressed(test);
    DashboardServer server({"127.0.0.1", 0}, "a test", true);
    LogEvent event;
    for (const mesh_t& part : SplitMesh(0, pressed.Description())) {
      event.channel = kMeshChannel;
      EncodeMessage(part, &event.data);
      server.Take(event);
    }
    organ_t shape{};
    OrganSnapshot moved = pressed.telemetry.Front().organs[0];
    moved.offset_W = Vector3d(0.001, -0.002, 0.003);  // as a breathing organ's
    ToMessage(StepRecord(), 0, moved, &shape);
    event.channel = kOrganChannel;
    EncodeMessage(shape, &event.data);
    server.Take(event);

    SCOPED_TRACE(testing::Message()
                 << (test.basis == BasisType::kBSpline ? "B-spline" : "Bernstein") << " of degree "
                 << test.degree);
    browser.Open(server.address());
    ASSERT_TRUE(
        browser.WaitFor("hpdm.scene.organs.get(0)?.mesh && "
                        "hpdm.scene.organs.get(0).dirty === false"));
    EXPECT_EQ(shape.local_count > 0, test.local_functions > 0);
    EXPECT_EQ(shape.indentation_count, 1);
    Points engine = pressed.render.Front().organs[0].vertices.cast<double>();
    EXPECT_GT((engine - pressed.models[0].rest().vertices).rowwise().norm().maxCoeff(), 1e-3);
    engine.rowwise() += moved.offset_W.transpose();
    // Positions of 0.1 m cross in float and are kept in float. The indentation's frame is fitted to the
    // smooth surface, of which the browser knows the vertices alone: 2 um.
    EXPECT_LT((Vertices(&browser, 0) - engine).cwiseAbs().maxCoeff(), 3e-6);
    EXPECT_EQ(browser.Errors(), std::vector<std::string>());
    browser.Open("about:blank");  // before its server ends
    browser.Errors();
  }
}

// The page at the end of a session's log.
TEST_F(DashboardTest, RebuildsTheLastShapeOfALog) {
  organ_t last{};
  std::vector<mesh_t> parts;
  LogReader reader(TwoHandsLog());
  double deepest_local = 0;
  for (LogEvent event; reader.Next(&event);) {
    organ_t organ;
    mesh_t part;
    if (event.channel == kOrganChannel && DecodeMessage(event.data, &organ)) last = organ;
    if (event.channel == kMeshChannel && DecodeMessage(event.data, &part)) parts.push_back(part);
  }
  for (const float x : last.local_displacements)
    deepest_local = std::max<double>(deepest_local, std::abs(x));
  ASSERT_GT(deepest_local, 0);
  OrganDescription organ;
  std::string error;
  ASSERT_TRUE(JoinMesh(parts, &organ, &error)) << error;
  OrganSnapshot shape;
  ASSERT_TRUE(FromMessage(last, &shape));
  Points engine;
  ASSERT_TRUE(LoggedSurface(organ).Deform(shape, &engine));

  Spy spy(TwoHandsLog());
  ASSERT_FALSE(spy.address().empty()) << spy.errors();
  Browser browser;
  browser.Open(spy.address());
  Set(&browser, "#speed", "10");
  ASSERT_TRUE(WaitForState(&browser, "end of the log"));
  ASSERT_TRUE(
      browser.WaitFor("hpdm.scene.organs.get(0).shape?.step == " + std::to_string(last.step) +
                      " && hpdm.scene.organs.get(0).dirty === false"));
  const double size = (engine.colwise().maxCoeff() - engine.colwise().minCoeff()).norm();
  EXPECT_LT((Vertices(&browser, 0) - engine).rowwise().norm().maxCoeff(), 1e-6 * size);
}

TEST_F(DashboardTest, FindsItsServerAgain) {
  std::optional<Spy> spy(std::in_place, TwoHandsLog());
  ASSERT_FALSE(spy->address().empty()) << spy->errors();
  const int port = spy->port();
  Browser browser;
  browser.Open(spy->address());
  ASSERT_TRUE(browser.WaitFor("hpdm.session.connected"));
  spy->child().Signal(SIGTERM);
  EXPECT_EQ(spy->child().Wait(5), 0) << "with a stream open";
  ASSERT_TRUE(WaitForState(&browser, "connection lost"));
  EXPECT_TRUE(browser.WaitFor(
      "document.getElementById('notices').textContent.includes('the page shows old data')"));
  spy.emplace(TwoHandsLog(), port);
  ASSERT_FALSE(spy->address().empty()) << spy->errors();
  ASSERT_TRUE(browser.WaitFor("hpdm.session.connected && hpdm.session.rows.length > 0"));
  EXPECT_TRUE(browser.WaitFor("document.getElementById('notices').textContent == ''"));
}

TEST_F(DashboardTest, WorksWithoutWebGl) {
  Spy spy(TwoHandsLog());
  ASSERT_FALSE(spy.address().empty()) << spy.errors();
  Browser browser(1000, 700, {"--disable-3d-apis"});
  browser.Open(spy.address());
  ASSERT_TRUE(browser.WaitFor("hpdm.session.rows.length > 0 && hpdm.charts.force"));
  EXPECT_NE(browser.Text("#notices").find("no WebGL"), std::string::npos);
}

TEST_F(DashboardTest, FitsAPhone) {
  Spy spy(TwoHandsLog());
  ASSERT_FALSE(spy.address().empty()) << spy.errors();
  Browser browser(360, 740);
  browser.Open(spy.address());
  ASSERT_TRUE(browser.WaitFor("hpdm.session.health && hpdm.scene.organs.get(0)?.mesh"));
  EXPECT_EQ(browser.Execute("return document.documentElement.scrollWidth"), 360);
}

// A session on the multicast of a network namespace of its own, spy and browser in it.
TEST_F(DashboardTest, ShowsALiveSession) {
  if (!InsideNetworkNamespace()) {
    const std::string enter = NetworkNamespaceCommand();
    if (enter.empty()) GTEST_SKIP() << "network namespaces are refused here";
    EXPECT_EQ(RunInNetworkNamespace(enter, "DashboardTest.ShowsALiveSession"), 0);
    return;
  }
  const ScratchFolder folder;
  Spy spy("");
  ASSERT_FALSE(spy.address().empty()) << spy.errors();
  Browser browser;
  browser.Open(spy.address());
  ASSERT_TRUE(WaitForState(&browser, "no messages yet"));
  EXPECT_NE(browser.Text("#notices").find("--live"), std::string::npos);
  EXPECT_NE(browser.Text("#nothing").find("No mesh yet"), std::string::npos);
  Child session({kProgram, "run", kScene, "--live", "--seconds", "4", "--no-pictures", "--headless",
                 "--out", folder / "session"});
  ASSERT_TRUE(WaitForState(&browser, "live"));
  ASSERT_TRUE(browser.WaitFor("hpdm.scene.organs.get(0)?.mesh && hpdm.session.rows.length > 30"));
  EXPECT_EQ(browser.Text("#nothing"), "");
  EXPECT_FALSE(browser.Execute("return document.querySelector('#player').checkVisibility()"));
  ASSERT_TRUE(WaitForState(&browser, "session ended"));
  EXPECT_EQ(session.Wait(20), 0);
  // Every tick of the log was heard: its largest force is shown.
  const Truth truth = TruthOf(folder / "session/session.lcmlog");
  ASSERT_TRUE(browser.WaitFor("hpdm.session.tools.tools.length == 2"));
  EXPECT_EQ(browser.Execute("return hpdm.session.tools.tools[0].peak_force"), truth.peak_force[0]);
  EXPECT_EQ(browser.Errors(), std::vector<std::string>());
}

}  // namespace
}  // namespace hpdm
