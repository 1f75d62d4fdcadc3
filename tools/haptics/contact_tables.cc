#include "tools/haptics/contact_tables.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/haptics/bonded_disc.h"
#include "tools/haptics/edge_grasp.h"
#include "tools/shared/edge_wedge.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kBallError = 0.05, kDiscError = 0.1, kStiffnessError = 0.1,
                 kStiffnessSpread = 0.05;
constexpr double kMaxTurn = 0.5;      // degrees
constexpr double kMaxStillSpeed = 1;  // mm/s
constexpr double kMaxLateTicks = 1;   // ticks
constexpr double kTouching = 0.2;     // depth over the radius, up to which Hertz holds
constexpr double kUnbounded = JudgedValue::kUnbounded;

std::string LatticeName(int cells, int functions) {
  return Format("%d^3", cells) + (functions > 0 ? Format(" + %d", functions) : "");
}

std::string ValueText(const ContactTable::Column& column, const JudgedValue& judged) {
  return Format("%.*f", column.decimals, judged.value);
}

// A range that has become NaN stays NaN.
void Widen(const RatioRange& more, RatioRange* range) {
  if (!std::isnan(range->low) && !(more.low >= range->low)) range->low = more.low;
  if (!std::isnan(range->high) && !(more.high <= range->high)) range->high = more.high;
}

struct LatticeCase {
  int cells;
  int functions;
};

}  // namespace

int ContactTable::Missed() const {
  int missed = 0;
  for (const Row& row : rows) {
    for (const JudgedValue& value : row.values) missed += value.Missed() ? 1 : 0;
  }
  return missed;
}

RatioRange ForceOverLaw(const std::vector<BallPress>& presses,
                        const std::function<double(double depth)>& law, double from, double to) {
  constexpr double kSame = 1e-9;  // m
  RatioRange range{kUnbounded, -kUnbounded};
  for (const BallPress& press : presses) {
    if (press.depth < from - kSame || press.depth > to + kSame) continue;
    for (const double force : {press.first_tick, press.step, press.settled_tick}) {
      const double ratio = force / law(press.depth);
      Widen({ratio, ratio}, &range);
    }
  }
  return range;
}

ContactTable MeasureBalls(bool quick) {
  ContactTable table{
      "ball",
      "Rigid ball on a frictionless block 200 mm wide: force over Hertz's to d = 0.2 R, and over "
      "Sneddon's beyond it to d = R; least and largest of the step, of the first tick and of the "
      "settled one, over meshes of 25, 12.5 and 6.25 mm.",
      Format("Target: within %.0f %%.", 100 * kBallError),
      {{"Hertz, low", "hertz_low"},
       {"high", "hertz_high"},
       {"Sneddon, low", "sneddon_low"},
       {"high", "sneddon_high"}},
      {}};
  const std::vector<LatticeCase> lattices =
      quick ? std::vector<LatticeCase>{{4, 27}} : std::vector<LatticeCase>{{4, 0}, {4, 27}, {6, 8}};
  const std::vector<int> meshes = quick ? std::vector{16} : std::vector{8, 16, 32};
  if (quick) table.title.replace(table.title.rfind(", over"), std::string::npos, ".");
  for (const double poisson : {0.3, 0.45}) {
    for (const auto& [cells, functions] : lattices) {
      for (const double radius : {0.0025, 0.005, 0.01}) {
        RatioRange hertz{kUnbounded, -kUnbounded}, sneddon = hertz;
        for (const int squares : meshes) {
          const WideBlock block{poisson, cells, functions, squares};
          const MaterialOptions material = block.Options().material;
          const std::vector<BallPress> presses =
              PressBall(block, radius,
                        {0.02 * radius, 0.05 * radius, 0.1 * radius, kTouching * radius,
                         0.4 * radius, 0.7 * radius, radius});
          Widen(ForceOverLaw(
                    presses, [&](double d) { return HertzForce(d, radius, material); }, 0,
                    kTouching * radius),
                &hertz);
          Widen(ForceOverLaw(
                    presses, [&](double d) { return SneddonForce(d, radius, material); },
                    kTouching * radius, radius),
                &sneddon);
        }
        table.rows.push_back({Format("R %.1f mm, nu %.2f, %s", 1e3 * radius, poisson,
                                     LatticeName(cells, functions).c_str()),
                              {Near(hertz.low, kBallError), Near(hertz.high, kBallError),
                               Near(sneddon.low, kBallError), Near(sneddon.high, kBallError)}});
      }
    }
  }
  return table;
}

ContactTable MeasureDiscs(bool quick) {
  ContactTable table{"disc",
                     "Disc of 5 mm tied to a block 200 mm wide, by the rows that tie a jaw: "
                     "stiffness over the half-space's; the block's held sides add 3 to 4 %.",
                     Format("Target: within %.0f %%.", 100 * kDiscError),
                     {{"normal", "normal"},
                      {"tangential", "tangential"},
                      {"rocking", "rocking"},
                      {"twist", "twist"}},
                     {}};
  std::vector<DiscCase> discs;
  for (const double nu : {0.3, 0.45}) {
    discs.push_back({nu, 20, 4, 27});
    if (quick) continue;
    discs.insert(discs.end(), {{nu, 8, 4, 27}, {nu, 41, 4, 27}, {nu, 20, 6, 64}, {nu, 20, 8, 64}});
  }
  for (const DiscCase& disc : discs) {
    const DiscStiffness measured = MeasureDisc(disc), exact = ExactDiscStiffness(disc.poisson);
    table.rows.push_back({Format("nu %.2f, %s, edges of %.0f mm", disc.poisson,
                                 LatticeName(disc.cells, disc.functions).c_str(),
                                 1e3 * 40 * kDiscRadius / disc.squares),
                          {Near(measured.normal / exact.normal, kDiscError),
                           Near(measured.tangential / exact.tangential, kDiscError),
                           Near(measured.rocking / exact.rocking, kDiscError),
                           Near(measured.twist / exact.twist, kDiscError)}});
  }
  return table;
}

namespace {

std::vector<LatticeCase> GraspLattices(bool quick) {
  return quick ? std::vector<LatticeCase>{{4, 27}}
               : std::vector<LatticeCase>{{4, 27}, {6, 64}, {8, 64}};
}

}  // namespace

ContactTable MeasureGrasps(bool quick) {
  ContactTable table{
      "grasp",
      "Grasp of 8 mm of a wedge like the liver's edge, pulled along the edge, off it and across "
      "it: "
      "stiffness on the hand over quadratic elements.",
      Format("Targets: within %.0f %%, and %.0f %% between any two rows.", 100 * kStiffnessError,
             100 * kStiffnessSpread),
      {{"along the edge", "along"}, {"off the edge", "off"}, {"across the edge", "across"}},
      {}};
  const std::vector<double> edges =
      quick ? std::vector{0.008, 0.003} : std::vector{0.008, 0.005, 0.003, 0.002};
  RatioRange along{kUnbounded, -kUnbounded}, off = along, across = along;
  for (const auto& [cells, functions] : GraspLattices(quick)) {
    for (const double edge : edges) {
      const EdgeStiffness measured = PullEdge(edge, cells, functions);
      const double none = std::numeric_limits<double>::quiet_NaN();
      const double ratio_along = measured.holds ? measured.along / EdgeWedge::kAlongEdge : none;
      const double ratio_off = measured.holds ? measured.off / EdgeWedge::kOffEdge : none;
      Widen({ratio_along, ratio_along}, &along);
      const double ratio_across = measured.holds ? measured.across / EdgeWedge::kAcrossEdge : none;
      Widen({ratio_off, ratio_off}, &off);
      Widen({ratio_across, ratio_across}, &across);
      table.rows.push_back(
          {Format("%s, edges of %.0f mm", LatticeName(cells, functions).c_str(), 1e3 * edge),
           {Near(ratio_along, kStiffnessError), Near(ratio_off, kStiffnessError),
            Near(ratio_across, kStiffnessError)}});
    }
  }
  table.rows.push_back({"largest over least",
                        {{along.high / along.low, 1, 1 + kStiffnessSpread},
                         {off.high / off.low, 1, 1 + kStiffnessSpread},
                         {across.high / across.low, 1, 1 + kStiffnessSpread}}});
  return table;
}

ContactTable MeasureGraspTurns(bool quick) {
  ContactTable table{
      "grasp_turns",
      "The same grasp, turned about the middle of the held tissue: torque of the step's ties over "
      "quadratic elements. A device of three axes does not display it.",
      Format("Target: within %.0f %%.", 100 * kStiffnessError),
      {{"in the jaws' faces", "in_faces"}, {"about the edge", "about_edge"}, {"twist", "twist"}},
      {}};
  const GraspTurns exact = ExactGraspTurns();
  for (const auto& [cells, functions] : GraspLattices(quick)) {
    const GraspTurns measured = TurnGrasp(0.003, cells, functions);
    table.rows.push_back({LatticeName(cells, functions),
                          {Near(measured.in_faces / exact.in_faces, kStiffnessError),
                           Near(measured.about_edge / exact.about_edge, kStiffnessError),
                           Near(measured.twist / exact.twist, kStiffnessError)}});
  }
  return table;
}

ContactTable MeasureStillness(bool quick) {
  ContactTable table{
      "stillness",
      "Tip on a slab: largest turns between two ticks of one pose as a new patch arrives, of the "
      "force before the guard and of the contact's normal (the force of a new patch fades in), in "
      "a "
      "slide 10 mm deep at 0.05 m/s; RMS speed in a still hand, 20 mm deep.",
      Format("Targets: %.1f degrees, %.0f mm/s.", kMaxTurn, kMaxStillSpeed),
      {{"force, degrees", "force_turn_degrees"},
       {"normal, degrees", "normal_turn_degrees"},
       {"still hand, mm/s", "rms_speed_mm_per_s"}},
      {}};
  const std::vector<int> meshes = quick ? std::vector{32} : std::vector{10, 32};
  for (const double radius : {0.0025, 0.005, 0.01}) {
    for (const int squares : meshes) {
      const SlideTurn turn = TurnOfSlide(radius, squares);
      const StillHandTrial hand = SpeedOfStillHand(radius, squares);
      const double none = std::numeric_limits<double>::quiet_NaN();
      table.rows.push_back(
          {Format("R %.1f mm, edges of %.1f mm", 1e3 * radius, 200.0 / squares),
           {AtMost(turn.least_force > 0 ? turn.force : none, kMaxTurn),
            AtMost(turn.least_force > 0 ? turn.normal : none, kMaxTurn),
            AtMost(hand.least_force > 0 ? 1e3 * hand.rms_speed : none, kMaxStillSpeed)}});
    }
  }
  return table;
}

ContactTable MeasureApproaches(bool quick) {
  ContactTable table{
      "approach",
      "Tip of 2.5 mm that comes down on an organ 45 degrees to its surface: ticks without force "
      "1.5 mm deep and more, and depth in the rest surface before the first force.",
      Format("Target: at most %.0f tick late.", kMaxLateTicks),
      {{"ticks late", "ticks_late", 0}, {"depth, mm", "depth_mm", 2}},
      {}};
  const std::vector<int> meshes = quick ? std::vector{4, 6} : std::vector{4, 5, 6};
  for (const int splits : meshes) {
    for (const double speed : {0.3, 1.0}) {
      const Approach approach = ComeDown(splits, speed);
      table.rows.push_back(
          {Format("edges of %.3g mm, %.1f m/s", 80.0 / (1 << splits), speed),
           {AtMost(approach.felt ? approach.ticks_late : kUnbounded, kMaxLateTicks),
            NotJudged(1e3 * approach.deepest)}});
    }
  }
  return table;
}

ContactTable MeasureOrganSlides(bool quick) {
  ContactTable table{
      "organs",
      "Tip of 2.5 mm that slides from the top of one organ to the top of the next, 3 mm deep and "
      "more: ticks without force, and the largest step between two ticks over that of the same "
      "slide on the first organ alone, which it leaves.",
      "Targets: no tick without force, steps within those of one organ.",
      {{"ticks without force", "ticks_without_force", 0},
       {"largest step, mN", "largest_step_mN", 2},
       {"over one organ's", "step_ratio", 2}},
      {}};
  const std::vector<double> speeds = quick ? std::vector{0.3} : std::vector{0.1, 0.3};
  for (const double speed : speeds) {
    const OrganSlide two = SlideOverOrgans(2, speed), one = SlideOverOrgans(1, speed);
    table.rows.push_back({Format("%.1f m/s", speed),
                          {AtMost(two.ticks_without_force, 0), NotJudged(1e3 * two.largest_step),
                           AtMost(two.largest_step / one.largest_step, 1)}});
  }
  return table;
}

std::vector<ContactTable> MeasureContacts(bool quick,
                                          const std::function<void(const ContactTable&)>& done) {
  std::vector<ContactTable> tables;
  for (const auto& measure : {MeasureBalls, MeasureDiscs, MeasureGrasps, MeasureGraspTurns,
                              MeasureStillness, MeasureApproaches, MeasureOrganSlides}) {
    tables.push_back(measure(quick));
    done(tables.back());
  }
  return tables;
}

std::string TableText(const ContactTable& table) {
  constexpr int kColumn = 20;
  std::string text = table.title + "\n" + table.target + Format(" Missed: %d.\n", table.Missed());
  text += Format("%-36s", "");
  for (const ContactTable::Column& column : table.columns) {
    text += Format(" %*s ", kColumn, column.title.c_str());
  }
  text += "\n";
  for (const ContactTable::Row& row : table.rows) {
    text += Format("%-36s", row.name.c_str());
    for (std::size_t i = 0; i < row.values.size(); ++i) {
      text += Format(" %*s%s", kColumn, ValueText(table.columns[i], row.values[i]).c_str(),
                     row.values[i].Missed() ? "*" : " ");
    }
    text += "\n";
  }
  return text;
}

std::string TableMarkdown(const ContactTable& table) {
  std::string text = table.title + " " + table.target + "\n\n| |", rule = "|---|";
  for (const ContactTable::Column& column : table.columns) {
    text += " " + column.title + " |";
    rule += "---|";
  }
  text += "\n" + rule + "\n";
  for (const ContactTable::Row& row : table.rows) {
    text += "| " + row.name + " |";
    for (std::size_t i = 0; i < row.values.size(); ++i) {
      const char* mark = row.values[i].Missed() ? "**" : "";
      text += Format(" %s%s%s |", mark, ValueText(table.columns[i], row.values[i]).c_str(), mark);
    }
    text += "\n";
  }
  return text;
}

Json TablesJson(const std::vector<ContactTable>& tables) {
  Json all = Json::array();
  for (const ContactTable& table : tables) {
    Json rows = Json::array();
    for (const ContactTable::Row& row : table.rows) {
      Json values = {{"case", row.name}};
      Json missed = Json::array();
      for (std::size_t i = 0; i < row.values.size(); ++i) {
        const double value = row.values[i].value;
        const std::string& key = table.columns[i].key;
        values[key] = std::isfinite(value) ? Json(value) : Json(nullptr);
        if (row.values[i].Missed()) missed.push_back(key);
      }
      values["missed"] = missed;
      rows.push_back(values);
    }
    all.push_back({{"name", table.name},
                   {"target", table.target},
                   {"missed", table.Missed()},
                   {"rows", rows}});
  }
  return all;
}

}  // namespace hpdm
