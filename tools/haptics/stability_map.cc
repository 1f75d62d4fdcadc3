#include "tools/haptics/stability_map.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>

#include "engine/base/error.h"
#include "haptics/haptic_loop.h"
#include "tools/haptics/stability_trial.h"
#include "tools/plots/plot_stability.h"
#include "tools/plots/python_plot.h"

namespace hpdm {
namespace {

constexpr double kInsertion0 = 0.1;  // m, start of the insertion axis
constexpr double kTipRadius = kDefaultToolRadius;
constexpr double kPush = 1;         // N
constexpr double kSeconds = 4;      // duration of a run
constexpr double kStiffest = 3e5;   // N/m: the largest stiffness tried
const Vector3d kTrocar(0, 0, 0.1);  // the shaft points down, the tip starts at the origin

struct LoopCase {
  StabilityPlantOptions plant;
  double device_damping = 0;  // b of the device without the hand
  bool control = false;
  bool linear = true;
};

// Returns an upward triangle around the tip. Its spring balances the push at the start.
ToolPatch Plane(double stiffness) {
  ToolPatch patch;
  patch.organ = 0;
  patch.kind = ContactKind::kPress;
  const double z = kPush / stiffness - kTipRadius;
  const Vector3d corners[] = {{-0.02, -0.02, z}, {0.02, -0.02, z}, {0, 0.03, z}};
  for (const Vector3d& corner : corners) {
    patch.nodes[patch.node_count++].k1 = stiffness;
    PatchPoint& point = patch.points[patch.point_count++];
    point.p_original_W = corner;
    point.normal_W = Vector3d::UnitZ();
  }
  patch.triangles[patch.triangle_count++] = {0, 1, 2};
  patch.Pack();
  return patch;
}

HapticInstrument InstrumentOf(const LoopCase& loop, Device* device) {
  HapticInstrument instrument{
      device, {kTrocar, -Vector3d::UnitZ(), DeviceProfile{}}, {{.tip_radius = kTipRadius}}};
  // Contact exists and lasts: neither start-up nor a stopped deformation loop is measured here.
  instrument.guard.ramp_in = 1e-9;
  instrument.guard.stale_age_ns = std::numeric_limits<Nanoseconds>::max();
  const StabilityPlantOptions& plant = loop.plant;
  DeviceAxes& axes = instrument.passivity.device;
  axes.inertia[kInsertion] = plant.axis.mass;
  axes.damping[kInsertion] = loop.device_damping;
  axes.friction[kInsertion] = plant.friction;
  axes.encoder_step[kInsertion] = plant.encoder_step[kInsertion];
  instrument.passivity.control = loop.control;
  // The contact is there from the start without a hand's work: nothing for an energy tank.
  instrument.passivity.still = false;
  return instrument;
}

bool DisplaysStably(const LoopCase& loop, double stiffness) {
  const Nanoseconds period = loop.plant.period_ns;
  StabilityPlant plant(loop.plant, (JointVector() << 0, 0, kInsertion0, 0, 1).finished());
  plant.Home();
  plant.EnableForce(true);
  TripleBuffer<ToolState> tool_states;
  TripleBuffer<ContactPatch> patches;
  SpscQueue<HapticSample> samples(2);  // overflows, since nothing reads it
  HapticLoop haptics({InstrumentOf(loop, &plant)}, period, {tool_states, patches, samples});
  ContactPatch& patch = patches.Back();
  patch.step.number = 1;
  patch.tool_count = 1;
  patch.tools[0].places[0] = Plane(stiffness);
  patches.Publish();

  std::uint64_t tick = 0;
  const auto run = [&] {
    haptics.Tick(tick, static_cast<Nanoseconds>(tick) * period, {});
    ++tick;
  };
  for (int i = 0; i < 20; ++i) run();  // device held: the force builds up within the slew limit
  return IsStable({.stiffness = stiffness,
                   .mass = loop.plant.axis.mass,
                   .linear = loop.linear,
                   .ticks = static_cast<int>(kSeconds / ToSeconds(period))},
                  &plant, run);
}

const char* CaseName(StabilityCase of) {
  switch (of) {
    case StabilityCase::kBare:
      return "bare";
    case StabilityCase::kHand:
      return "hand";
    case StabilityCase::kHandDevice:
      return "hand_device";
  }
  return "";
}

StabilityRow Measure(const StabilityOptions& options, StabilityCase of, bool control, bool by_delay,
                     double period, double delay) {
  LoopCase loop;
  loop.plant.axis = options.device;
  loop.device_damping = options.device.damping;
  if (of != StabilityCase::kBare) {
    loop.plant.axis.damping += options.hand_damping;
    loop.plant.axis.stiffness = options.hand_stiffness;
  }
  if (of == StabilityCase::kHandDevice) {
    loop.plant.friction = options.friction;
    loop.plant.encoder_step[kInsertion] = options.encoder_step;
  }
  loop.plant.push = kPush;
  loop.plant.period_ns = std::llround(1e9 * period);
  loop.plant.delay_ns = std::llround(1e9 * delay);
  loop.control = control;
  loop.linear = !control && of != StabilityCase::kHandDevice;

  StabilityRow row{.of = of,
                   .control = control,
                   .by_delay = by_delay,
                   .period = period,
                   .delay = delay,
                   .damping = loop.plant.axis.damping};
  row.exact = StabilityLimit(loop.plant.axis, period, delay);
  const auto bound = [&](double with_delay) {
    return PassivityBound(options.device.damping, options.friction, options.encoder_step, period,
                          with_delay);
  };
  row.passivity = bound(0);
  row.delayed_passivity = bound(delay);
  const double least = 0.2 * row.damping / (period + delay);
  const StabilityBoundary boundary =
      FindBoundary(least, kStiffest, 1.3, 2e-3,
                   [&](double stiffness) { return DisplaysStably(loop, stiffness); });
  row.measured = boundary.value;
  row.beyond = boundary.beyond;
  return row;
}

}  // namespace

StabilityMap MeasureStability(const StabilityOptions& options) {
  using Sweep = std::vector<double>;
  const Sweep delays = options.quick ? Sweep{0, 1e-3, 5e-3}
                                     : Sweep{0,      0.25e-3, 0.5e-3, 0.75e-3, 1e-3,   1.5e-3, 2e-3,
                                             2.5e-3, 3e-3,    3.5e-3, 4e-3,    4.5e-3, 5e-3};
  const Sweep periods = options.quick
                            ? Sweep{0.25e-3, 1e-3, 4e-3}
                            : Sweep{0.25e-3, 0.5e-3, 0.75e-3, 1e-3, 1.5e-3, 2e-3, 3e-3, 4e-3};
  StabilityMap map{options, {}};
  for (const StabilityCase of :
       {StabilityCase::kBare, StabilityCase::kHand, StabilityCase::kHandDevice}) {
    for (const bool control : {false, true}) {
      for (const double delay : delays) {
        map.rows.push_back(Measure(options, of, control, true, options.period, delay));
      }
      for (const double period : periods) {
        map.rows.push_back(Measure(options, of, control, false, period, 0));
      }
    }
  }
  return map;
}

double LargestDeviation(const StabilityMap& map) {
  double largest = 0;
  for (const StabilityRow& row : map.rows) {
    if (row.control || row.of == StabilityCase::kHandDevice) continue;
    largest = std::max(largest, std::abs(row.measured / row.exact - 1));
  }
  return largest;
}

void WriteStabilityCsv(const StabilityMap& map, const std::string& path) {
  std::ofstream file(path);
  file << "case,control,sweep,period_s,delay_s,damping_N_s_per_m,measured_N_per_m,beyond,"
          "exact_N_per_m,passivity_N_per_m,delayed_passivity_N_per_m\n";
  for (const StabilityRow& row : map.rows) {
    char line[256];
    std::snprintf(line, sizeof line, "%s,%d,%s,%g,%g,%g,%.6g,%d,%.6g,%.6g,%.6g\n", CaseName(row.of),
                  row.control, row.by_delay ? "delay" : "period", row.period, row.delay,
                  row.damping, row.measured, row.beyond, row.exact, row.passivity,
                  row.delayed_passivity);
    file << line;
  }
  if (!file.flush()) throw InputError(path + ": cannot be written; choose another folder");
}

std::string WriteStability(const StabilityMap& map, const std::string& folder) {
  const std::string table = folder + "/stability.csv";
  WriteStabilityCsv(map, table);
  return RunPlotScript(kPlotStabilityScript, {table, folder + "/stability.png"});
}

}  // namespace hpdm
