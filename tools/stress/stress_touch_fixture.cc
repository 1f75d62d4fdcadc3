#include "tools/stress/stress_touch_fixture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "engine/base/check.h"
#include "tools/shared/force_signal.h"
#include "tools/shared/report_text.h"
#include "tools/stress/point_proxy.h"

namespace hpdm {
namespace {

constexpr double kApproachSpeed = 0.1;  // m/s

const std::array<Vector3d, 12>& IcosahedronCorners() {
  constexpr double g = std::numbers::phi;
  static const std::array<Vector3d, 12> corners = {{{-1, g, 0},
                                                    {1, g, 0},
                                                    {-1, -g, 0},
                                                    {1, -g, 0},
                                                    {0, -1, g},
                                                    {0, 1, g},
                                                    {0, -1, -g},
                                                    {0, 1, -g},
                                                    {g, 0, -1},
                                                    {g, 0, 1},
                                                    {-g, 0, -1},
                                                    {-g, 0, 1}}};
  return corners;
}

constexpr std::array<std::array<int, 3>, 20> kIcosahedronFaces = {
    {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
     {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
     {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};

// Runs the proxy at the tip's lowest point against the surface of the newest step.
FeltTouch FeelProxy(const StressTouchFixture& fixture, const StressTool& tool, double seconds) {
  constexpr double kStiffness = 100;  // N/m
  const TimingOptions& timing = fixture.timing;
  PointProxy proxy(fixture.rest, kStiffness);
  FeltTouch felt;
  const auto ticks = static_cast<int>(seconds * timing.haptic_hz);
  for (int tick = 0; tick < ticks; ++tick) {
    const auto at_ns = [&](int n) { return n * (kNanosecondsPerSecond / timing.haptic_hz); };
    const int begun = tick * timing.deformation_hz / timing.haptic_hz;  // steps
    proxy.MoveSurface(
        fixture.organ.motion.Offset(at_ns(begun * timing.haptic_hz / timing.deformation_hz)));
    ToolSample& sample = felt.series.emplace_back();
    sample.p_tip_W = tool.motion(1. * tick / timing.haptic_hz).p_tip_W;
    sample.force_W =
        proxy.Tick(sample.p_tip_W - tool.tool.geometries[0].tip_radius * Vector3d::UnitZ());
    sample.reaction_W = sample.force_W;
  }
  return felt;
}

OrganOptions Options(StressModel model, bool quick) {
  OrganOptions options;
  options.name = "organ";
  options.energy.alpha = 500;  // Pa: under the tip about as stiff as the strain energy with 5 kPa
  options.lattice.cells = {3, 3, quick ? 2 : 3};
  options.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}}};
  if (model != StressModel::kPointProxy) Choose(model, &options);
  return options;
}

}  // namespace

SurfaceMesh GeodesicEllipsoid(const Vector3d& radii, int frequency) {
  HPDM_CHECK(frequency >= 1);
  // A vertex's name is its integer weights of the icosahedron's corners, so faces share the
  // vertices of their edges.
  using Name = std::map<int, int>;
  std::map<Name, int> index;
  std::vector<Vector3d> vertices;
  const auto vertex = [&](const std::array<int, 3>& face, int a, int b, int c) {
    Name name;
    for (const auto& [corner, weight] :
         {std::pair{face[0], a}, std::pair{face[1], b}, std::pair{face[2], c}}) {
      if (weight > 0) name[corner] = weight;
    }
    const auto [at, is_new] = index.try_emplace(name, static_cast<int>(vertices.size()));
    if (is_new) {
      Vector3d p = Vector3d::Zero();
      for (const auto& [corner, weight] : name) p += weight * IcosahedronCorners()[corner];
      vertices.push_back(p.normalized().cwiseProduct(radii));
    }
    return at->second;
  };
  SurfaceMesh mesh;
  mesh.triangles.resize(20 * frequency * frequency, 3);
  Eigen::Index t = 0;
  for (const std::array<int, 3>& face : kIcosahedronFaces) {
    for (int b = 0; b < frequency; ++b) {
      for (int c = 0; c + b < frequency; ++c) {
        const int a = frequency - b - c;
        mesh.triangles.row(t++) << vertex(face, a, b, c), vertex(face, a - 1, b + 1, c),
            vertex(face, a - 1, b, c + 1);
        if (a < 2) continue;
        mesh.triangles.row(t++) << vertex(face, a - 1, b + 1, c), vertex(face, a - 2, b + 1, c + 1),
            vertex(face, a - 1, b, c + 1);
      }
    }
  }
  mesh.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    mesh.vertices.row(static_cast<Eigen::Index>(v)) = vertices[v];
  }
  return mesh;
}

SurfaceMesh HollowEllipsoid(const Vector3d& radii, double wall, int frequency) {
  const SurfaceMesh outer = GeodesicEllipsoid(radii, frequency);
  const SurfaceMesh inner = GeodesicEllipsoid(radii - Vector3d::Constant(wall), frequency);
  SurfaceMesh mesh;
  const auto count = static_cast<int>(outer.vertices.rows());
  mesh.vertices.resize(2 * count, 3);
  mesh.vertices << outer.vertices, inner.vertices;
  mesh.triangles.resize(2 * outer.triangles.rows(), 3);
  mesh.triangles << outer.triangles, (inner.triangles.array() + count).matrix();
  mesh.triangles.bottomRows(inner.triangles.rows())
      .col(1)
      .swap(mesh.triangles.bottomRows(inner.triangles.rows()).col(2));
  return mesh;
}

Vector3d StressTouchFixture::Top(double x, double y) const {
  return Top(SurfaceTree(rest.vertices, rest.triangles), x, y);
}

Vector3d StressTouchFixture::Top(const SurfaceTree& surface, double x, double y) const {
  const SurfaceHit hit = surface.FirstEntry(Vector3d(x, y, 1), Vector3d(x, y, -1));
  HPDM_CHECK(hit.at.triangle >= 0);
  return hit.at.Position(rest.vertices, rest.triangles);
}

double Depth(const SurfaceTree& surface, const Vector3d& p_centre_W, double radius) {
  const double distance = surface.Closest(p_centre_W, 1).distance;
  const bool inside =
      surface.FirstEntry(p_centre_W + Vector3d::UnitZ(), p_centre_W).at.triangle >= 0;
  return (inside ? distance : -distance) + radius;
}

StressTouchFixture SoftOrgan(StressModel model, bool quick) {
  return {.model = model,
          .organ = Options(model, quick),
          .rest = GeodesicEllipsoid(Vector3d(0.1, 0.07, 0.05), quick ? 6 : 10)};
}

StressTouchFixture HollowOrgan(StressModel model, bool quick) {
  return {.model = model,
          .organ = Options(model, quick),
          .rest = HollowEllipsoid(Vector3d(0.05, 0.04, 0.04), 0.003, quick ? 6 : 8)};
}

StressPose Below(const Vector3d& p_top_W, double depth, const StressTool& tool) {
  return {.p_tip_W = p_top_W + (tool.tool.geometries[0].tip_radius - depth) * Vector3d::UnitZ()};
}

StressTool OverOrgan(std::vector<std::pair<double, StressPose>> way) {
  StressTool tool;
  tool.motion = Through(std::move(way));
  tool.p_trocar_W = Vector3d(0.03, 0.02, 0.3);
  return tool;
}

StressTool PressAndSlide::Tool(const Vector3d& p_top_W, const StressTool& held) {
  constexpr double kAway = 0.01, kRests = 0.1;  // m, s
  const double press = (depth + kAway) / speed, in = kRampedIn + press, slide = length / speed;
  slides = in + kRests;
  ends = slides + 2 * slide;
  leaves = ends + kRests + depth / speed;
  out = ends + kRests + press;
  const StressPose over = Below(p_top_W, -kAway, held), deep = Below(p_top_W, depth, held),
                   far = Below(p_top_W + length * Vector3d::UnitX(), depth, held);
  StressTool tool = OverOrgan({{kRampedIn, over},
                               {in, deep},
                               {slides, deep},
                               {slides + slide, far},
                               {ends, deep},
                               {ends + kRests, deep},
                               {out, over}});
  tool.tool = held.tool;
  return tool;
}

FeltTouch Feel(const StressTouchFixture& fixture, const StressTool& tool, double seconds) {
  if (fixture.model == StressModel::kPointProxy) return FeelProxy(fixture, tool, seconds);
  StressSessionFixture body(fixture.organ, fixture.rest, {tool}, fixture.timing);
  FeltTouch felt;
  body.RunUntil(seconds, &felt.series);
  felt.outcome = body.outcome();
  return felt;
}

const FeltTimeSeries& Kept(const KeptTimeSeries& kept, StressModel model,
                           const std::function<FeltTimeSeries()>& make) {
  const auto at = kept->find(model);
  return at != kept->end() ? at->second : (*kept)[model] = make();
}

Vector3d MeanForce(const FeltTimeSeries& series, double from, double to) {
  const auto first = static_cast<std::size_t>(std::lround(1e3 * from));
  const auto last = std::min(static_cast<std::size_t>(std::lround(1e3 * to)), series.size());
  HPDM_CHECK(first < last);
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = first; i < last; ++i) sum += series[i].reaction_W;
  return sum / static_cast<double>(last - first);
}

Vector3d ForceGoneToSlowly(const StressTouchFixture& fixture, StressTool tool,
                           const StressPose& from, const StressPose& to) {
  constexpr double kSettles = 0.35;  // s
  const double arrives = kRampedIn + (to.p_tip_W - from.p_tip_W).norm() / kApproachSpeed;
  const double end = arrives + kSettles;
  tool.motion = Through({{kRampedIn, from}, {arrives, to}});
  return MeanForce(Feel(fixture, tool, end).series, end - 0.05, end);
}

double FeltError(const FeltTimeSeries& series, const FeltTimeSeries& truth, double from) {
  ForceSignal felt, meant;
  for (std::size_t i = static_cast<std::size_t>(1e3 * from); i < series.size(); ++i) {
    felt.push_back(series[i].reaction_W);
    meant.push_back(truth[i].reaction_W);
  }
  return ContactError(felt, meant);
}

double RelativeError(const Vector3d& a, const Vector3d& truth) {
  return (a - truth).norm() / truth.norm();
}

void Fail(const std::string& how, StressTrial* trial) {
  trial->fate = StressFate::kFailed;
  if (trial->how.empty()) trial->how = how;
}

void ReportForces(double force, double meant, StressTrial* trial) {
  if (trial->fate == StressFate::kSurvived || !trial->how.empty()) return;
  trial->how = Format("%.2g N for %.2g N", force, meant);
}

StressTrial JudgeTouch(StressModel model, double error, double degraded_from, double failed_from,
                       const StressOutcome& outcome, double released) {
  StressTrial trial = Judge(error, degraded_from, failed_from);
  const bool at_rest = outcome.displacement <= StressSessionFixture::kAtRest;
  AddFaults(outcome, IsOurs(model) || !at_rest ? released : std::numeric_limits<double>::infinity(),
            &trial);
  if (!trial.harm.empty()) Fail(trial.harm, &trial);
  if (!std::isfinite(error)) {
    trial.error.reset();
    Fail("no force at all", &trial);
  }
  return trial;
}

}  // namespace hpdm
