#include "tools/haptics/organ_tables.h"

#include <algorithm>
#include <string>

#include "tools/haptics/organ_trials.h"
#include "tools/haptics/scene_press.h"
#include "tools/haptics/shaft_trials.h"
#include "tools/shared/report_text.h"
#include "tools/shared/simple_bodies.h"

namespace hpdm {
namespace {

constexpr double kHertzForce = 0.05, kHertzRadius = 0.08, kBarError = 0.01, kThirdLaw = 1e-12;
constexpr double kScenePress = 0.02;              // m
constexpr double kMeanDepth = 0.2, kDeepest = 1;  // mm
constexpr double kStepRatio = 3;

ContactTable MeasureSpheres(bool quick) {
  ContactTable table{
      "spheres",
      "Two equal elastic spheres pressed together: force and radius of the contact over Hertz's. "
      "The bodies are caps of 0.3 m radius, 150 mm wide and 90 mm high; the approach is that of "
      "whole spheres' centres, by the stated share of it for the bodies' ends. Where functions are "
      "stated, finer ones are placed for a load where the spheres touch.",
      Format("Targets: force within %.0f %%, radius within %.0f %%, the organs' forces opposite to "
             "1e-12 of them.",
             100 * kHertzForce, 100 * kHertzRadius),
      {{"force", "force"},
       {"radius", "radius"},
       {"third law, 1e-12", "third_law_1e12"},
       {"ends, %", "ends_percent", 1}},
      {}};
  std::vector<SphereCase> cases = {{0.3, 0.01, 10, 30}};
  if (!quick) {
    cases.insert(cases.end(), {{0.3, 0.005, 10, 30},
                               {0.45, 0.01, 10, 30},
                               {0.45, 0.005, 10, 30},
                               {0.3, 0.01, 8, 30},
                               {0.3, 0.01, 10, 20},
                               {0.3, 0.01, 8, 40, 1200},
                               {0.45, 0.01, 8, 40, 1200},
                               {0.3, 0.005, 8, 60, 1600}});
  }
  for (const SphereCase& given : cases) {
    const SpherePress press = PressSpheres(given);
    table.rows.push_back(
        {Format("nu %.2f, approach %.3f R, %d cells, edges of %.1f mm", given.poisson,
                given.approach, given.cells, 150.0 / given.squares) +
             (given.functions > 0 ? Format(", %d functions", given.functions) : ""),
         {Near(press.force, kHertzForce), Near(press.radius, kHertzRadius),
          AtMost(press.third_law / 1e-12, kThirdLaw / 1e-12), NotJudged(100 * press.finite_size)}});
  }
  return table;
}

ContactTable MeasureBars(bool quick) {
  ContactTable table{
      "bars",
      "Two bars pressed on each other: force over that of their stiffnesses in series, each solved "
      "alone; largest distance of a point of the two faces from their mean plane over the press.",
      Format("Targets: %.0f %%, 1e-12 of the force.", 100 * kBarError),
      {{"force", "force"}, {"flatness", "flatness", 4}, {"third law, 1e-12", "third_law_1e12"}},
      {}};
  struct Named {
    const char* name;
    BarsCase bars;
    bool flat;  // without Poisson's ratio the faces stay flat
  };
  std::vector<Named> cases = {
      {"equal", {}, true},
      {"5 on 8 kPa, edges of 5 and 2.2 mm", {5000, 8000, 0, 10, 23, 0.001}, true}};
  if (!quick) {
    cases.insert(cases.end(),
                 {{"9 on 3 kPa, pressed by 4 mm", {9000, 3000, 0, 14, 14, 0.004}, true},
                  {"equal, friction 0.3", {5000, 5000, 0, 14, 14, 0.002, 0.3}, true},
                  {"nu 0.30", {5000, 5000, 0.3}, false},
                  {"nu 0.45", {5000, 5000, 0.45}, false}});
  }
  for (const auto& [name, bars, flat] : cases) {
    const BarsPress press = PressBars(bars);
    table.rows.push_back({name,
                          {Near(press.force, kBarError),
                           flat ? AtMost(press.flatness, kBarError) : NotJudged(press.flatness),
                           AtMost(press.third_law / 1e-12, kThirdLaw / 1e-12)}});
  }
  return table;
}

struct PressCase {
  const char* scene;
  ScenePress press;
};

// In abdomen_on_springs.toml the gallbladder lies in its bed under the liver, 0.65 mm away from it. The left lobe
// of liver_on_stomach.toml lies over the stomach.
std::vector<PressCase> PressCases(bool quick) {
  const char* const abdomen = "abdomen_on_springs.toml";
  const char* const lobe_on_stomach = "liver_on_stomach.toml";
  const Vector3d quadrate(0.035, -0.062, 0.045), fundus(0.008, -0.110, 0.032),
      left(0.106, 0.03, 0.032), none = Vector3d::Zero(), down = -Vector3d::UnitZ();
  std::vector<PressCase> presses = {
      {abdomen, {"liver, quadrate lobe, into it", "liver", quadrate, none, 0.005}},
      {abdomen,
       {"gallbladder, body, to the liver",
        "gallbladder",
        {0.008, -0.09, 0.0},
        Vector3d(0, 0.5, 0.87),
        0.005}}};
  if (quick) return presses;
  const Vector3d aside(-1, 0, -0.5);
  presses.insert(
      presses.end(),
      {{abdomen, {"liver, quadrate lobe, to the gallbladder", "liver", quadrate, aside, 0.005}},
       {abdomen, {"the same, 10 mm tip", "liver", quadrate, aside, 0.010}},
       {abdomen, {"the same, 2.5 mm tip, 0.5 m/s", "liver", quadrate, aside, 0.0025, 0.5}},
       {abdomen, {"liver, over the bed, down", "liver", {0.008, -0.06, 0.05}, down, 0.005}},
       {abdomen, {"gallbladder, fundus, to the liver", "gallbladder", fundus, {0, 1, 0}, 0.005}},
       {lobe_on_stomach, {"left lobe, down onto the stomach", "liver", left, down, 0.010}},
       {lobe_on_stomach, {"the same, 5 mm tip, 0.5 m/s", "liver", left, down, 0.005, 0.5}}});
  return presses;
}

ContactTable MeasurePenetration(const std::filesystem::path& scenes, bool quick) {
  ContactTable table{
      "penetration",
      "Presses of 20 mm in abdomen_on_springs.toml and liver_on_stomach.toml and back, at 0.1 m/s "
      "if not "
      "stated, "
      "by haptic ticks and steps as in a session, with a contact of liver and "
      "gallbladder added, which abdomen_on_springs.toml leaves out: depth of the drawn organs in "
      "each "
      "other after each step, at samples at most 2 mm apart, inside by the winding number of the "
      "other's outer surface.",
      Format("Targets: mean of the samples inside %.1f mm, largest %.0f mm; steps of the felt "
             "force at most %.0f times those without the added contact; no contact dropped.",
             kMeanDepth, kDeepest, kStepRatio),
      {{"mean, mm", "mean_mm"},
       {"largest, mm", "largest_mm"},
       {"area inside, mm^2", "area_mm2", 0},
       {"force between organs, N", "pair_force_N", 2},
       {"felt, N", "felt_N", 2},
       {"largest step of it in a tick, mN", "largest_step_mN", 1},
       {"over that without the added contact", "step_ratio", 2},
       {"steps in contact", "steps", 0},
       {"dropped", "dropped", 0}},
      {}};
  for (auto [scene, press] : PressCases(quick)) {
    if (!std::filesystem::exists(scenes / scene)) continue;
    const ScenePressResult apart = PressInScene(scenes / scene, press, kScenePress);
    press.all_pairs = true;
    const ScenePressResult result = PressInScene(scenes / scene, press, kScenePress);
    table.rows.push_back(
        {press.name,
         {AtMost(1e3 * result.penetration.mean, kMeanDepth),
          AtMost(1e3 * result.penetration.largest, kDeepest),
          NotJudged(1e6 * result.penetration.touching), NotJudged(result.pair_force),
          NotJudged(result.felt), NotJudged(1e3 * result.largest_jump),
          AtMost(result.largest_jump / apart.largest_jump, kStepRatio),
          NotJudged(result.penetration.steps), AtMost(result.dropped ? 1 : 0, 0)}});
  }
  return table;
}

}  // namespace

std::vector<ContactTable> MeasureOrganContacts(
    const std::filesystem::path& scenes, bool quick,
    const std::function<void(const ContactTable&)>& done) {
  std::vector<ContactTable> tables;
  const auto add = [&](ContactTable table) {
    tables.push_back(std::move(table));
    done(tables.back());
  };
  add(MeasureSpheres(quick));
  add(MeasureBars(quick));
  ContactTable penetration = MeasurePenetration(scenes, quick);
  if (!penetration.rows.empty()) add(std::move(penetration));
  return tables;
}

std::vector<ContactTable> MeasureShaft(bool quick,
                                       const std::function<void(const ContactTable&)>& done) {
  ContactTable table{
      "shaft",
      "Shaft swept sideways 6 mm deep into a lobe of 10 mm radius, rigid (300 N/m) or of 5 kPa "
      "30 mm high, and rested there: ticks late; least force after the first over the last, 0: "
      "passed through; force at the end over that of the sweep at 0.1 m/s; largest step between "
      "two ticks over that at 0.1 m/s and the same way a tick.",
      "Targets: at most 1 tick late, never without force, 3 % of the slow sweep, steps 1.15.",
      {{"ticks late", "ticks_late", 0},
       {"least force", "least_force"},
       {"force at the end", "last_force"},
       {"largest step, mN", "largest_step_mN", 2},
       {"step over the slow one", "step_ratio", 2}},
      {}};
  const std::vector<double> speeds =
      quick ? std::vector{0.1, 1.0} : std::vector{0.1, 0.3, 1.0, 3.0};
  for (const bool rigid : {true, false}) {
    const double top = rigid ? 0.01 : 0.03;
    ShaftSweep slow;
    for (const double speed : speeds) {
      FeltBench bench(rigid ? RigidLobe() : SoftLobe(), Ellipsoid(Vector3d(0.01, 0.01, top), 3));
      bench.feels_shaft = true;
      const ShaftSweep sweep = SweepShaftDown(&bench, top, 0.006, speed);
      if (speed == speeds.front()) slow = sweep;
      const double ratio = sweep.largest_step / slow.largest_step / (speed / speeds.front());
      table.rows.push_back({Format("%s, %.1f m/s", rigid ? "rigid" : "soft", speed),
                            {AtMost(sweep.late, 1),
                             {sweep.least_held / sweep.last, 1e-6, JudgedValue::kUnbounded},
                             Near(sweep.last / slow.last, 0.03),
                             NotJudged(1e3 * sweep.largest_step),
                             AtMost(ratio, 1.15)}});
    }
  }
  done(table);
  return {table};
}

}  // namespace hpdm
