// A strip on a layer on a rigid organ, pulled off by its free end, against Kendall's peel
// (doi:10.1088/0022-3727/8/13/005). In small strain only a peel along the layer is one: the arm of
// another one turns, and the stretch of an arm that turns is not seen.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/bed_layer.h"
#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

constexpr double kHalfPeel = 1000;  // s: then an organ's offset is its whole displacement

// The strip's bed is from x = 0 to bed, its free arm behind it; a support holds the arm's end, which
// moves at `angle` to the layer.
struct PeeledStrip {
  std::string name = {};
  double stretch_stiffness = 2;  // E h / G_c
  double strength = 10000;       // Pa
  double angle = 0;              // rad
  double way = 0.05;             // m, of the arm's end
  int cells = 40;
  double bed = 0.09, arm = 0.02, held = 0.01, width = 0.01, height = 0.004;  // m
  double toughness = 45;                                                     // J/m^2

  double Young() const { return stretch_stiffness * toughness / height; }
  // (F/b)(1 - cos angle) + (F/b)^2 / (2 E h) = G_c
  double KendallsForce() const {
    const double turn = 1 - std::cos(angle), s = stretch_stiffness;
    return width * toughness * (-s * turn + std::sqrt(s * s * turn * turn + 2 * s));
  }
  void Start(OrganBench* bench) const {
    OrganOptions plate;
    plate.name = "plate";
    plate.model = OrganModelType::kRigid;
    bench->Add(plate, GridBox(Vector3d(-0.01, -0.02, -0.01), Vector3d(bed, 0.02, 0), {50, 20, 4}));
    OrganOptions strip;
    strip.name = "strip";
    strip.material = {.young = Young(), .poisson = 0};
    strip.lattice.cells = {cells, 1, 1};
    strip.lattice.margin = 0.0005;
    strip.lattice.local.functions = 0;
    strip.motion = {way * Vector3d(std::cos(angle), 0, std::sin(angle)), 0.5 / kHalfPeel};
    strip.supports.push_back({hpdm::Box{Vector3d(bed + arm, -1, -1), Vector3d(1, 1, 1)}, {}});
    bench->Add(strip,
               GridBox(Vector3d(0, -width / 2, 0.0003),
                       Vector3d(bed + arm + held, width / 2, 0.0003 + height), {120, 10, 4}));
    AttachmentOptions layer = BedLayer(
        "strip", "plate", hpdm::Box{Vector3d(-1, -1, -1), Vector3d(bed - 1e-4, 1, 1)}, 0.001);
    layer.strength = strength;
    layer.toughness = toughness;
    layer.young = 2 * strength;
    bench->Attach(layer);
    bench->Start();
  }
};

struct Peel {
  double force = 0;   // over Kendall's, mean over the steady part of the way
  double ripple = 0;  // half of the difference of its extremes, over the mean
  double freed = 0;   // share of the bed in the end
};

Peel PeelOff(const PeeledStrip& strip, int steps = 300) {
  OrganBench bench;
  strip.Start(&bench);
  std::vector<double> forces;
  double freed = 0;
  for (int step = 1; step <= steps; ++step) {
    bench.StayAt(kHalfPeel * std::acos(1 - 2.0 * step / steps) / std::numbers::pi);
    bench.Step();
    const AttachmentOutcome& layer = bench.loop().links()[0].outcomes()[0];
    freed = layer.freed_area / (strip.bed * strip.width);
    // The layer pulls the plate with the force that the support exerts.
    const double force = layer.load_W.norm();
    if (freed > 0.1 && freed < 0.6) forces.push_back(force);
  }
  Peel peel;
  peel.freed = freed;
  if (forces.empty()) return peel;
  const auto [least, most] = std::ranges::minmax_element(forces);
  double sum = 0;
  for (const double force : forces) sum += force;
  const double mean = sum / static_cast<double>(forces.size());
  peel.force = mean / strip.KendallsForce();
  peel.ripple = (*most - *least) / 2 / mean;
  return peel;
}

class AlongTheLayer : public testing::TestWithParam<PeeledStrip> {};
INSTANTIATE_TEST_SUITE_P(
    Cases, AlongTheLayer,
    testing::Values(PeeledStrip{.name = "soft", .stretch_stiffness = 2, .way = 0.09},
                    PeeledStrip{
                        .name = "stiff", .stretch_stiffness = 30, .strength = 30000, .way = 0.03}),
    [](const auto& param_info) { return param_info.param.name; });

TEST_P(AlongTheLayer, APeelTakesKendallsForce) {
  const Peel peel = PeelOff(GetParam());
  EXPECT_GT(peel.freed, 0.6);
  EXPECT_NEAR(peel.force, 1, 0.03);
  EXPECT_LT(peel.ripple, 0.05);
}

}  // namespace
}  // namespace hpdm
