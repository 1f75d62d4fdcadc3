#include "tools/haptics/z_width.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>

#include "haptics/safety/stability.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "tools/haptics/stability_trial.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

constexpr double kContactPush = 1;      // N
constexpr double kStiffestShown = 2e5;  // N/m: the largest stiffness tried
constexpr double kWidthGrowth = 1.4;
constexpr double kWidthTolerance = 0.01;
constexpr double kFarthestPress = 0.02;     // m along the guide, to press with kContactPush
constexpr double kComesFrom = 5e-4;         // m
constexpr double kComesWith = 0.02;         // m/s
constexpr double kSmallMove = 1e-7;         // m, of the difference that gives a stiffness
constexpr double kFarthestOutside = 0.002;  // m
constexpr double kStableMargin = 2;         // of the boundary over the shipped stiffness
constexpr double kRootError = 0.05;

// The pose at which a contact presses with kContactPush, and its stiffness there.
struct PressedPose {
  double x = 0;          // m along the guide
  double stiffness = 0;  // N/m
};

PressedPose PressWith(const ShippedContact& contact, const ToolPatches& patches) {
  const auto force = [&](double x) { return StaticForce(contact, patches, x); };
  // The curved surface may lie outside of the vertices' plane, where x is 0.
  double low = contact.grasps ? -kFarthestPress : -kFarthestOutside, high = 1e-6;
  if (contact.grasps) {
    high = kFarthestPress;
  } else {
    while (high < kFarthestPress && force(high) < kContactPush) high *= 2;
  }
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (force(middle) < kContactPush ? low : high) = middle;
  }
  const double move = std::clamp(0.1 * std::abs(high), 1e-9, kSmallMove);
  return {high, (force(high + move) - force(high - move)) / (2 * move)};
}

PressedPose PressStiffer(const ShippedContact& contact, double stiffer) {
  return PressWith(contact, Stiffened(contact.patches, contact.session->organs(), stiffer));
}

// Returns how many times stiffer a contact must be for a stiffness (N/m) under kContactPush. The
// stiffness of a light touch grows less than the tissue's.
double StifferFor(const ShippedContact& contact, double stiffness) {
  double low = -10, high = 25;  // logarithms
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (PressStiffer(contact, std::exp(middle)).stiffness < stiffness ? low : high) = middle;
  }
  return std::exp(high);
}

// A disturbance by a hand, at another phase of the encoders.
struct Kick {
  double speed = 0;  // m/s
  double phase = 0;  // of an encoder count
};
constexpr Kick kKicks[] = {{0.02, 0}, {-0.02, 0.3}, {0.005, 0.6}};

// True if the contact at `stiffer` times its stiffness is displayed without vibration.
bool IsDisplayedStably(const ShippedContact& contact, const DisplayConditions& display, bool steps,
                       bool linear, double seconds, double stiffer, const Kick& kick) {
  PressedPose pose = PressStiffer(contact, stiffer);
  if (!linear) pose.x += kick.phase * EncoderStepAlong(contact, pose.x);
  ContactLoop loop(contact, display, pose.x, stiffer, steps);
  if (contact.grasps && steps) {  // the jaws close first
    loop.plant().SetJaw(1);
    loop.Hold(-pose.x + 0.004, -pose.x, kComesWith);
    loop.Rest(0.2);
    loop.plant().SetJaw(0);
    loop.Rest(0.2);
    loop.Hold(-pose.x, 0, kComesWith);
  } else {
    loop.Hold(-kComesFrom, 0, kComesWith);
  }
  loop.Rest(steps ? 0.3 : 0.03);
  loop.plant().Push(-loop.plant().force());
  return IsStable({.stiffness = pose.stiffness,
                   .mass = loop.axis().mass,
                   .linear = linear,
                   .kick = kick.speed,
                   .quiet = kContactPush / 4,
                   .ticks = static_cast<int>(seconds / loop.period())},
                  &loop.plant(), [&] { loop.Tick(); });
}

JudgedValue Shown(double value) {
  return {value, -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
}

// Returns the points of one sweep of one contact under the given condition, in their order.
std::vector<const ZWidthPoint*> PointsOf(const std::vector<ZWidthPoint>& points,
                                         const std::string& contact, const std::string& sweep,
                                         const std::function<bool(const ZWidthPoint&)>& chosen) {
  std::vector<const ZWidthPoint*> found;
  for (const ZWidthPoint& point : points) {
    if (point.contact == contact && point.sweep == sweep && chosen(point)) found.push_back(&point);
  }
  return found;
}

std::vector<std::string> ContactsOf(const std::vector<ZWidthPoint>& points) {
  std::vector<std::string> names;
  for (const ZWidthPoint& point : points) {
    if (names.empty() || names.back() != point.contact) names.push_back(point.contact);
  }
  return names;
}

// The scene's own controller is that of each contact's first point.
bool ControlOf(const std::vector<ZWidthPoint>& points, const std::string& contact) {
  const auto found = std::find_if(points.begin(), points.end(), [&](const ZWidthPoint& point) {
    return point.contact == contact;
  });
  return found->display.control;
}

ContactTable LoopTable(const std::vector<ZWidthPoint>& points) {
  ContactTable table{
      "z_width",
      Format("Stiffness along the guide at the scene's rate, delay and hand: of the shipped "
             "contact, and the largest that the loop displays without vibration (at most %.0f "
             "N/m are tried).",
             kStiffestShown),
      Format("Targets: at least %.0f times the shipped stiffness; without friction, encoders and "
             "controller within %.0f %% of the exact roots.",
             kStableMargin, 100 * kRootError),
      {{"shipped, N/m", "shipped_N_per_m", 0},
       {"largest stable, N/m", "largest_N_per_m", 0},
       {"over shipped", "margin", 1},
       {"no controller, N/m", "no_controller_N_per_m", 0},
       {"no guard limits, N/m", "no_guard_N_per_m", 0},
       {"with 30 Hz steps, N/m", "steps_N_per_m", 0},
       {"2 b / T, N/m", "passivity_N_per_m", 0},
       {"2 f / step, N/m", "friction_N_per_m", 0},
       {"exact roots, N/m", "exact_N_per_m", 0},
       {"linear loop over roots", "linear_ratio", 3}},
      {}};
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (const std::string& contact : ContactsOf(points)) {
    const bool control = ControlOf(points, contact);
    const auto value = [&](const std::function<bool(const ZWidthPoint&)>& chosen) {
      const auto found = PointsOf(points, contact, "loop", chosen);
      return found.empty() ? kNone : found[0]->measured;
    };
    const auto is = [](bool with_control, bool guard, bool steps) {
      return [=](const ZWidthPoint& p) {
        return p.display.control == with_control && p.display.guard == guard && p.steps == steps &&
               !p.display.ideal;
      };
    };
    const ZWidthPoint& shipped = *PointsOf(points, contact, "loop", is(control, true, false))[0];
    const double linear = value([](const ZWidthPoint& p) { return p.display.ideal; });
    table.rows.push_back({contact,
                          {Shown(shipped.shipped),
                           Shown(shipped.measured),
                           {shipped.measured / shipped.shipped, kStableMargin,
                            std::numeric_limits<double>::infinity()},
                           Shown(value(is(false, true, false))),
                           Shown(value(is(control, false, false))),
                           Shown(value(is(control, true, true))),
                           Shown(shipped.passivity),
                           Shown(shipped.friction),
                           Shown(shipped.exact),
                           {linear / shipped.exact, 1 - kRootError, 1 + kRootError}}});
  }
  constexpr std::ptrdiff_t kStepsColumn = 5;
  if (std::none_of(points.begin(), points.end(), [](const ZWidthPoint& p) { return p.steps; })) {
    table.columns.erase(table.columns.begin() + kStepsColumn);
    for (ContactTable::Row& row : table.rows) row.values.erase(row.values.begin() + kStepsColumn);
  }
  return table;
}

ContactTable SweepTable(const std::vector<ZWidthPoint>& points, const std::string& sweep,
                        const std::string& what,
                        const std::function<std::string(const ZWidthPoint&)>& title,
                        const std::function<std::string(const ZWidthPoint&)>& key) {
  ContactTable table{
      "z_width_" + sweep,
      "Largest stable stiffness, N/m, against " + what + ", with the scene's controller and guard.",
      "Not judged.",
      {},
      {}};
  for (const std::string& contact : ContactsOf(points)) {
    const bool control = ControlOf(points, contact);
    ContactTable::Row row{contact, {}};
    const bool first = table.columns.empty();
    for (const ZWidthPoint* point : PointsOf(points, contact, sweep, [&](const ZWidthPoint& p) {
           return p.display.control == control;
         })) {
      if (first) table.columns.push_back({title(*point), key(*point), 0});
      row.values.push_back(Shown(point->measured));
    }
    table.rows.push_back(row);
  }
  return table;
}

}  // namespace

ZWidthPoint MeasureZWidthPoint(const ShippedContact& contact, const DisplayConditions& display,
                               bool steps, bool linear, double seconds) {
  const StabilityPlantOptions device = GuidedDevice(contact, display, contact.depth);
  const HandOptions& hand = InstrumentOf(contact).hand;
  AxisDynamics axis = device.axis;
  axis.damping += display.hand * hand.damping;
  axis.stiffness = display.hand * hand.stiffness;
  ZWidthPoint point{.contact = contact.name,
                    .sweep = "loop",
                    .display = display,
                    .steps = steps,
                    .shipped = contact.stiffness};
  point.exact = StabilityLimit(axis, display.period, display.delay);
  point.passivity = PassivityBound(axis.damping, 0, 0, display.period, display.delay);
  const double step = EncoderStepAlong(contact, contact.depth);
  point.friction = device.friction > 0 && step > 0 ? 2 * device.friction / step : 0;

  const double least = std::min(0.3 * point.passivity, kStiffestShown);
  const std::size_t kicks = linear ? 1 : std::size(kKicks);
  const StabilityBoundary boundary = FindBoundary(
      StifferFor(contact, least), StifferFor(contact, kStiffestShown), kWidthGrowth,
      kWidthTolerance, [&](double stiffer) {
        return std::all_of(kKicks, kKicks + kicks, [&](const Kick& kick) {
          return IsDisplayedStably(contact, display, steps, linear, seconds, stiffer, kick);
        });
      });
  point.beyond = boundary.beyond;
  if (boundary.value > 0) point.measured = PressStiffer(contact, boundary.value).stiffness;
  return point;
}

std::vector<ZWidthPoint> MeasureZWidth(const ShippedContact& contact, bool quick) {
  using Sweep = std::vector<double>;
  const double seconds = quick ? 0.5 : 2;
  const Scene& scene = contact.session->scene();
  const DeviceProfile& device = InstrumentOf(contact).device;
  const DisplayConditions shipped{.period = 1.0 / scene.timing.haptic_hz,
                                  .delay = device.delay,
                                  .control = device.passivity_control};
  std::vector<ZWidthPoint> points;
  const auto add = [&](const char* sweep, const DisplayConditions& display, bool steps = false,
                       bool linear = false) {
    const auto same = std::find_if(points.begin(), points.end(), [&](const ZWidthPoint& point) {
      return point.display == display && point.steps == steps;
    });
    points.push_back(same != points.end()
                         ? ZWidthPoint(*same)
                         : MeasureZWidthPoint(contact, display, steps, linear, seconds));
    points.back().sweep = sweep;
  };
  add("loop", shipped);
  DisplayConditions varied = shipped;
  varied.control = !shipped.control;
  add("loop", varied);
  varied = shipped;
  varied.guard = false;
  add("loop", varied);
  varied.control = false;
  varied.ideal = true;
  add("loop", varied, false, true);
  if (!quick) add("loop", shipped, true);
  for (const bool control : {true, false}) {
    varied = shipped;
    varied.control = control;
    for (const double rate : quick ? Sweep{500} : Sweep{250, 500, 1000, 2000, 4000}) {
      varied.period = 1 / rate;
      add("rate", varied);
    }
    varied.period = shipped.period;
    for (const double delay : quick ? Sweep{0.002} : Sweep{0, 0.001, 0.002, 0.005}) {
      varied.delay = delay;
      add("delay", varied);
    }
    varied.delay = shipped.delay;
    for (const double hand : quick ? Sweep{0} : Sweep{0, 1.0 / 3, 1, 3}) {
      varied.hand = hand;
      add("hand", varied);
    }
  }
  return points;
}

std::vector<ContactTable> ZWidthTables(const std::vector<ZWidthPoint>& points) {
  if (points.empty()) return {};
  return {LoopTable(points),
          SweepTable(
              points, "rate", "the rate of the haptic loop",
              [](const ZWidthPoint& p) { return Format("%.0f Hz", 1 / p.display.period); },
              [](const ZWidthPoint& p) { return Format("at_%.0f_Hz", 1 / p.display.period); }),
          SweepTable(
              points, "delay", "the delay beyond the hold",
              [](const ZWidthPoint& p) { return Format("%.0f ms", 1e3 * p.display.delay); },
              [](const ZWidthPoint& p) { return Format("at_%.0f_ms", 1e3 * p.display.delay); }),
          SweepTable(
              points, "hand", "the hand's impedance over the scene's (0: no hand)",
              [](const ZWidthPoint& p) { return Format("%.2g", p.display.hand); },
              [](const ZWidthPoint& p) { return Format("hand_%.2g", p.display.hand); })};
}

void WriteZWidthCsv(const std::vector<ZWidthPoint>& points, const std::string& path) {
  std::string text =
      "contact,sweep,rate_hz,delay_s,hand,control,guard,ideal,steps,shipped_N_per_m,"
      "measured_N_per_m,beyond,exact_N_per_m,passivity_N_per_m,friction_N_per_m\n";
  for (const ZWidthPoint& point : points) {
    const DisplayConditions& d = point.display;
    text += Format("%s,%s,%.6g,%.6g,%.4g,%d,%d,%d,%d,%.6g,%.6g,%d,%.6g,%.6g,%.6g\n",
                   point.contact.c_str(), point.sweep.c_str(), 1 / d.period, d.delay, d.hand,
                   d.control, d.guard, d.ideal, point.steps, point.shipped, point.measured,
                   point.beyond, point.exact, point.passivity, point.friction);
  }
  WriteTextFile(path, text);
}

}  // namespace hpdm
