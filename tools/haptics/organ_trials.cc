#include "tools/haptics/organ_trials.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "engine/contact/surface_kernel.h"
#include "engine/mesh/collision.h"
#include "engine/mesh/mesh_edges.h"
#include "engine/mesh/winding_number.h"
#include "engine/statics/static_loads.h"
#include "tools/shared/simple_bodies.h"

namespace hpdm {
namespace {

constexpr double kHalfPeriod = 1;  // s: then an organ's offset is its whole displacement
constexpr int kApproachSteps = 40, kRestSteps = 20;

OrganOptions PressedOrgan(const std::string& name, const MaterialOptions& material) {
  OrganOptions options;
  options.name = name;
  options.energy.type = EnergyType::kStrain;
  options.material = material;
  options.lattice.margin = 0.001;
  options.lattice.local.functions = 0;
  return options;
}

// Moves the organs' supports by their whole displacement, then rests.
void MoveTogether(OrganBench* bench) {
  for (int step = 0; step <= kApproachSteps + kRestSteps; ++step) {
    bench->StayAt(std::min(kHalfPeriod, step * kHalfPeriod / kApproachSteps));
    bench->Step();
  }
}

OrganMotion MovedBy(const Vector3d& way) { return {way, 0.5 / kHalfPeriod}; }

double ThirdLaw(const OrganBench& bench) {
  return (bench.PairForce(0) + bench.PairForce(1)).norm() / bench.PairForce(1).norm();
}

// m, of the bodies with spherical caps.
constexpr double kCapRadius = 0.3, kCapWidth = 0.15, kCapHeight = 0.09, kCapApart = 1e-4,
                 kTouchRadius = 0.015;

// The body below z = 0, which its cap touches; `up`: above it instead.
SurfaceMesh Cap(int squares, bool up) {
  const int layers = static_cast<int>(std::lround(squares * kCapHeight / kCapWidth));
  SurfaceMesh mesh = GridBox(Vector3d(-kCapWidth / 2, -kCapWidth / 2, -kCapHeight),
                             Vector3d(kCapWidth / 2, kCapWidth / 2, 0), {squares, squares, layers});
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    auto p = mesh.vertices.row(v);
    const double r2 = p[0] * p[0] + p[1] * p[1];
    const double sag = kCapRadius - std::sqrt(kCapRadius * kCapRadius - r2);
    p[2] -= sag * (1 + p[2] / kCapHeight);
    if (up) p[2] = -p[2];
  }
  if (up) mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

OrganOptions CapOptions(const SphereCase& given, bool up) {
  OrganOptions options =
      PressedOrgan(up ? "upper" : "lower", {.young = 5000, .poisson = given.poisson});
  const int layers = static_cast<int>(std::lround(given.cells * kCapHeight / kCapWidth));
  options.lattice.cells = {given.cells, given.cells, layers};
  BoxFraction end;
  (up ? end.min : end.max).z() = up ? 0.97 : 0.03;
  options.supports.push_back({end, {}});
  options.lattice.adaptive.functions = given.functions;
  LoadOptions touch;
  touch.organ = options.name;
  touch.radius = kTouchRadius;
  touch.force_W = Vector3d::UnitZ();
  options.loads.push_back(touch);
  return options;
}

// Returns by how much more the body's middle yields to a unit force spread there than that of a
// half-space, m/N.
double YieldBesideHalfSpace(const OrganModel& cap) {
  constexpr double kSide = 0.4 * kCapWidth;
  LoadOptions load;
  load.organ = cap.options().name;
  load.pressure = 1;
  load.region = Box{Vector3d(-kSide / 2, -kSide / 2, -0.01), Vector3d(kSide / 2, kSide / 2, 0.01)};
  const Points u = StaticLoads(cap, {load}).Solve().vertex_displacements;
  Eigen::Index middle = 0;
  cap.rest().vertices.rowwise().norm().minCoeff(&middle);
  const MaterialOptions& material = cap.options().material;
  const double influence = 4 / std::numbers::pi * std::log(1 + std::numbers::sqrt2);
  const double half_space =
      influence * kSide * (1 - material.poisson * material.poisson) / material.young;
  return (std::abs(u(middle, 2)) - half_space) / (kSide * kSide);
}

// m, of the bars.
constexpr double kBarWidth = 0.05, kBarBelow = 0.05, kBarAbove = 0.03;

void AddBar(double from, double to, double held, double young, const BarsCase& given, int squares,
            double press, std::optional<double> friction, OrganBench* bench) {
  OrganOptions options =
      PressedOrgan(from == 0 ? "lower" : "upper", {.young = young, .poisson = given.poisson});
  options.lattice.cells = {2, 2, 4};
  const double thin = 0.02 * (to - from);
  const double low = held > from ? held - thin : from - thin;
  options.supports.push_back({Box{Vector3d(-1, -1, low), Vector3d(1, 1, low + 2 * thin)}, {}});
  options.motion = MovedBy(Vector3d(0, 0, -press));
  bench->Add(options,
             GridBox(Vector3d(-kBarWidth / 2, -kBarWidth / 2, from),
                     Vector3d(kBarWidth / 2, kBarWidth / 2, to), {squares, squares, squares}),
             friction);
}

// Displacement of the bar's end z = `end` by a unit force spread over it, m/N.
double EndCompliance(double end, const OrganModel& bar) {
  LoadOptions load;
  load.organ = bar.options().name;
  load.pressure = 1;
  load.region = Box{Vector3d(-1, -1, end - 1e-6), Vector3d(1, 1, end + 1e-6)};
  const Points u = StaticLoads(bar, {load}).Solve().vertex_displacements;
  double sum = 0, count = 0;
  for (Eigen::Index v = 0; v < u.rows(); ++v) {
    if (std::abs(bar.rest().vertices(v, 2) - end) > 1e-9) continue;
    sum += std::abs(u(v, 2));
    count += 1;
  }
  return sum / count / (kBarWidth * kBarWidth);
}

// Largest distance of the faces at rest at z = kBarBelow from their mean plane, m.
double OffPlane(OrganBench* bench) {
  std::vector<double> heights;
  for (int o = 0; o < 2; ++o) {
    const Points& rest = bench->model(o).rest().vertices;
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
      if (std::abs(rest(v, 2) - kBarBelow) > 1e-9) continue;
      heights.push_back(bench->organ(o).vertices(v, 2) + bench->organ(o).offset_W.z());
    }
  }
  const double mean =
      std::accumulate(heights.begin(), heights.end(), 0.0) / static_cast<double>(heights.size());
  double off = 0;
  for (const double height : heights) off = std::max(off, std::abs(height - mean));
  return off;
}

// Returns the part of a closed surface that encloses the others: without the inner faces of walls.
SurfaceMesh Outer(const SurfaceMesh& mesh) {
  DisjointSets parts(static_cast<int>(mesh.vertices.rows()));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 1; k < 3; ++k) parts.Merge(mesh.triangles(t, 0), mesh.triangles(t, k));
  }
  Eigen::Index highest = 0;
  mesh.vertices.col(2).maxCoeff(&highest);
  const int outer = parts.Find(static_cast<int>(highest));
  SurfaceMesh kept{mesh.vertices, Triangles(mesh.triangles.rows(), 3), {}};
  Eigen::Index count = 0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (parts.Find(mesh.triangles(t, 0)) == outer)
      kept.triangles.row(count++) = mesh.triangles.row(t);
  }
  kept.triangles.conservativeResize(count, 3);
  return kept;
}

}  // namespace

SpherePress PressSpheres(const SphereCase& given) {
  constexpr double kEffective = kCapRadius / 2;
  const double approach = given.approach * kEffective;
  OrganBench bench;
  bench.Add(CapOptions(given, false), Cap(given.squares, false));
  OrganOptions upper = CapOptions(given, true);
  SurfaceMesh above = Cap(given.squares, true);
  above.vertices.col(2).array() += kCapApart;
  upper.motion = MovedBy(Vector3d(0, 0, -approach - kCapApart));
  bench.Add(upper, above, 0.0);
  bench.Start();
  MoveTogether(&bench);

  SpherePress press;
  const double force = bench.PairForce(1).z();
  const double beside = 2 * YieldBesideHalfSpace(bench.model(0)) * force;
  press.finite_size = beside / approach;
  const MaterialOptions& material = bench.model(0).options().material;
  const double modulus = material.young / (1 - material.poisson * material.poisson) / 2;
  const auto hertz = [&](double depth) {
    return 4.0 / 3 * modulus * std::sqrt(kEffective) * std::pow(depth, 1.5);
  };
  const double depth = approach - beside;
  press.force = force / hertz(depth);
  // Hertz's pressure sqrt(1 - r^2 / a^2) has the mean r^2 = 2/5 a^2. A row's force acts on its cell's
  // samples. Quadratic splines on cells of width h give back their mean x^2 from those of the control
  // points: sum_a phi_a(x) X_a^2 = x^2 + h^2 / 4. Finer levels add nothing to it.
  double moment = 0, sum = 0;
  const ContactConstraints& rows = bench.organ(0).contacts;
  const Lattice& lattice = bench.model(0).lattice_organ()->lattice();
  Eigen::VectorXd r2 = lattice.ControlPoints().leftCols<2>().rowwise().squaredNorm();
  if (!lattice.levels().empty()) r2.tail(r2.size() - lattice.FirstColumn(0)).setZero();
  const double cell = lattice.box().lengths.x() / given.cells;
  for (int i = 0; i < rows.size(); ++i) {
    const double f = -rows[i].force_W.z();
    moment += f * (rows.Weights().row(i).dot(r2) - cell * cell / 2);
    sum += f;
  }
  press.radius = std::sqrt(2.5 * moment / sum / (kEffective * depth));
  press.third_law = ThirdLaw(bench);
  return press;
}

BarsPress PressBars(const BarsCase& given) {
  OrganBench bench;
  AddBar(0, kBarBelow, 0, given.young_below, given, given.squares_below, 0, {}, &bench);
  AddBar(kBarBelow, kBarBelow + kBarAbove, kBarBelow + kBarAbove, given.young_above, given,
         given.squares_above, given.press, given.friction, &bench);
  bench.Start();
  MoveTogether(&bench);
  BarsPress press;
  const double compliance =
      EndCompliance(kBarBelow, bench.model(0)) + EndCompliance(kBarBelow, bench.model(1));
  press.force = bench.PairForce(1).z() * compliance / given.press;
  press.flatness = OffPlane(&bench) / given.press;
  press.third_law = ThirdLaw(bench);
  return press;
}

void PenetrationMeter::Measure(OrganBench* bench) {
  bool touches = false;
  for (int a = 0; a < bench->organs(); ++a) {
    for (const OrganContactOptions& contact : bench->model(a).options().contacts) {
      for (int b = 0; b < bench->organs(); ++b) {
        if (bench->model(b).options().name != contact.with) continue;
        Measure(bench->Drawn(a), bench->Drawn(b));
        touches = touches || bench->PairForce(a).norm() > 0;
      }
    }
  }
  result_.steps += touches ? 1 : 0;
}

void PenetrationMeter::Measure(const SurfaceMesh& first, const SurfaceMesh& second) {
  double area = 0;
  MeasureSamples(first, second, &area);
  MeasureSamples(second, first, &area);
  result_.touching = std::max(result_.touching, area);
}

Penetration PenetrationMeter::result() const {
  Penetration result = result_;
  result.mean = weight_ > 0 ? sum_ / weight_ : 0;
  return result;
}

void PenetrationMeter::MeasureSamples(const SurfaceMesh& samples, const SurfaceMesh& body,
                                      double* area) {
  constexpr double kApart = 0.002;  // m
  const SurfaceMesh outer = Outer(body);
  const Vector3d low = outer.vertices.colwise().minCoeff(),
                 high = outer.vertices.colwise().maxCoeff();
  std::optional<SurfaceTree> tree;
  std::optional<WindingNumber> winding;
  const auto measure = [&](const Vector3d& p, double weight) {
    if ((p.array() < low.array()).any() || (p.array() > high.array()).any()) return;
    if (!tree) {
      tree.emplace(outer.vertices, outer.triangles);
      winding.emplace(outer);
    }
    if (winding->At(p) < 0.5) return;
    const double depth = tree->Closest(p, std::numeric_limits<double>::infinity()).distance;
    result_.largest = std::max(result_.largest, depth);
    sum_ += weight * depth;
    weight_ += weight;
    *area += weight;
  };
  // Only triangles that reach into the other's box are split into samples.
  const auto reaches = [&](Eigen::Index t) {
    Vector3d least = samples.vertices.row(samples.triangles(t, 0)), most = least;
    for (int k = 1; k < 3; ++k) {
      const Vector3d p = samples.vertices.row(samples.triangles(t, k));
      least = least.cwiseMin(p);
      most = most.cwiseMax(p);
    }
    return (least.array() <= high.array()).all() && (most.array() >= low.array()).all();
  };
  SurfaceMesh near{samples.vertices, Triangles(samples.triangles.rows(), 3), {}};
  Eigen::Index count = 0;
  for (Eigen::Index t = 0; t < samples.triangles.rows(); ++t) {
    if (reaches(t)) near.triangles.row(count++) = samples.triangles.row(t);
  }
  if (count == 0) return;
  near.triangles.conservativeResize(count, 3);
  for (const SurfaceSample& sample : SurfaceInRegion(near, std::nullopt, {}, kApart)) {
    measure(AtSample(sample, near.triangles, near.vertices), sample.weight);
  }
}

}  // namespace hpdm
