#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <utility>

#include "engine/baselines/surface_error.h"
#include "engine/organ/organ_state.h"
#include "haptics/device/hand_script.h"
#include "tools/shared/report_text.h"
#include "tools/stress/motion_block.h"
#include "tools/stress/stress_cases.h"

namespace hpdm {
namespace {

StressCase ContactCase(std::string name, std::string title, StressParameter parameter) {
  StressCase stress_case;
  stress_case.name = std::move(name);
  stress_case.group = "contact";
  stress_case.title = std::move(title);
  stress_case.parameter = std::move(parameter);
  stress_case.models = BlockModels();
  return stress_case;
}

// The block held at points of its top, as by jaws. Does the part of a step between collision and
// patch.
class BlockHeldAtPoints {
 public:
  explicit BlockHeldAtPoints(const OrganOptions& options, bool quick)
      : organ_(options, BlockSurface(quick)), state_(organ_, 1) {}

  const OrganModel& organ() const { return organ_; }
  const OrganState& state() const { return state_; }

  void LetGo() { state_.contacts.Clear(); }

  // Holds the point `p` of the top (m) and demands the displacement `way`.
  void Hold(const Vector3d& p, const Vector3d& way) {
    state_.tree.Refit(organ_.rest().vertices);
    const SurfacePoint at = state_.tree.Closest(p, 1).at;
    ContactConstraints::Row& row = *state_.contacts.Add();
    row.kind = ContactConstraints::RowKind::kGrasp;
    row.p_rest_W = at.Position(organ_.rest().vertices, organ_.rest().triangles);
    row.target_W = row.p_rest_W + way;
    organ_.AddToRow(at, 1, state_.contacts.refinement,
                    state_.contacts.WeightRow(state_.contacts.size() - 1));
  }

  // Holds another point and demands the displacement that the last solution gave it.
  void HoldToo(const Vector3d& p) {
    Hold(p, Vector3d::Zero());
    const int i = state_.contacts.size() - 1;
    state_.contacts[i].target_W +=
        (state_.contacts.Weights().row(i) * state_.control_displacements).transpose();
  }

  // Returns the displacements from Eq. 26-28 alone, from rest; V x 3, m.
  Points MovedDirectly() {
    state_.control_displacements.setZero();
    Points ways(state_.contacts.size(), 3);
    for (int i = 0; i < state_.contacts.size(); ++i) {
      ways.row(i) = state_.contacts[i].target_W - state_.contacts[i].p_rest_W;
    }
    MoveDirectly(state_.contacts.Weights(), ways, state_.control_displacements);
    return Relocated();
  }

  // Returns the displacements after as many relaxation steps as any model needs to settle; V x 3,
  // m.
  Points Relaxed() {
    constexpr int kSteps = 40;
    for (int step = 0; step < kSteps; ++step) {
      state_.memory.Relax(1. / 30, state_.relaxation.get(), &state_.contacts,
                          &state_.control_displacements);
    }
    return Relocated();
  }

 private:
  Points Relocated() {
    organ_.relocation().Relocate(state_.control_displacements, &state_.vertices);
    return state_.vertices - organ_.rest().vertices;
  }

  OrganModel organ_;
  OrganState state_;
};

// A point is lifted. A second point is held at the displacement that this gives it. The second
// demand is met already, but the two equations are nearly one: 1e-18 m beside 5 mm is below
// round-off.
StressCase CoincidentContacts(bool quick) {
  StressCase stress_case = ContactCase(
      "coincident_contacts", "A point lifted by 10 mm, and a second one held where that moves it",
      {"distance", "m", 1e-3, 1e-6, 1e-18, true});
  stress_case.truth =
      "the surface moved directly (Eq. 26-28) and relaxed, against that with one point (the same "
      "point at 1e-18 m): degraded from 1 %, failed from 10 %";
  stress_case.run = [quick](StressModel model, double distance) {
    const Vector3d p(0.005, 0.003, 0), beside = p + Vector3d(distance, 0, 0);
    BlockHeldAtPoints block(BlockOrgan(model, quick), quick);
    double error = 0;
    for (Points (BlockHeldAtPoints::*answer)() :
         {&BlockHeldAtPoints::MovedDirectly, &BlockHeldAtPoints::Relaxed}) {
      block.LetGo();
      block.Hold(p, Vector3d(0, 0, 0.01));
      const Points one = (block.*answer)();
      block.HoldToo(beside);
      const Points two = (block.*answer)();
      const double off = RelativeSurfaceError(block.organ().rest(), two, one);
      error = std::max(error, std::isfinite(off) ? off : std::numeric_limits<double>::infinity());
    }
    StressTrial trial = Judge(error, 0.01, 0.1);
    if (!std::isfinite(error)) trial.how = trial.harm = "not finite";
    return trial;
  };
  return stress_case;
}

// Returns the distance of the last step's points from their targets, relative to the demands.
double Missed(const BlockHeldAtPoints& block, const Points& U) {
  const ContactConstraints& contacts = block.state().contacts;
  double missed = 0, ways = 0;
  for (int i = 0; i < contacts.size(); ++i) {
    const Vector3d way = contacts[i].target_W - contacts[i].p_rest_W;
    missed += ((contacts.Weights().row(i) * U).transpose() - way).squaredNorm();
    ways += way.squaredNorm();
  }
  return std::sqrt(missed / ways);
}

StressCase ManyContacts(bool quick) {
  StressCase stress_case =
      ContactCase("many_contacts",
                  "Points of the top pulled in different directions, lattice of 8 control points",
                  {"points", "", 1, 16, 32});
  stress_case.truth =
      "best fit of such a lattice to all points (least squares): excess distance over "
      "the demands; degraded from 5 %, failed from 50 %";
  stress_case.models = LatticeModels();
  stress_case.run = [quick](StressModel model, double points) {
    OrganOptions options = BlockOrgan(model, quick);
    options.lattice.cells = {1, 1, 1};
    options.lattice.degree = {1, 1, 1};
    options.supports.clear();
    BlockHeldAtPoints block(options, quick);
    HandRandom random(1);
    for (int i = 0; i < static_cast<int>(points); ++i) {
      const auto any = [&](double most) { return random.Uniform(-most, most); };
      const Vector3d p(any(0.045), any(0.045), 0);
      // A lift and a turn, each with a random deviation.
      block.Hold(p, Vector3d(any(0.002), any(0.002), 0.01 + 0.1 * p.x() + any(0.002)));
    }
    block.MovedDirectly();
    block.Relaxed();
    const ContactConstraints& contacts = block.state().contacts;
    Eigen::MatrixXd ways(contacts.size(), 3);
    for (int i = 0; i < contacts.size(); ++i) {
      ways.row(i) = contacts[i].target_W - contacts[i].p_rest_W;
    }
    const Eigen::MatrixXd B = contacts.Weights();
    const Points best = B.completeOrthogonalDecomposition().solve(ways);
    const Points& U = block.state().control_displacements;
    StressTrial trial = Judge(Missed(block, U) - Missed(block, best), 0.05, 0.5);
    if (!U.allFinite()) trial.how = trial.harm = "not finite";
    return trial;
  };
  return stress_case;
}

// Displacement of each grasper, m.
constexpr double kApart = 0.05;
constexpr double kLetGo = kBlockStart + 0.5;  // s

StressTool PullAside(double from, double side) {
  return BlockGrasp(side * from, AtBlock(side * (from + kApart), 0.0125, 0), 0, kLetGo,
                    side * 0.02);
}

StressCase ToolsApart(bool quick) {
  StressCase stress_case =
      ContactCase("tools_pull_apart", "Two graspers pull 50 mm against each other within a step",
                  {"distance", "mm", 40, 2, 0.01, true});
  stress_case.truth =
      "the largest force on the tissue or on a hand before its guard, over that of one grasper "
      "alone: the excess, degraded from 10 times, failed from 100 times";
  stress_case.run = [quick, alone = std::make_shared<std::map<StressModel, double>>()](
                        StressModel model, double distance) {
    const auto pull = [&](const std::vector<StressTool>& tools) {
      auto body = std::make_unique<StressSessionFixture>(BlockOrgan(model, quick),
                                                         BlockSurface(quick), tools);
      body->RunUntil(kLetGo);
      return body;
    };
    if (!alone->contains(model)) {
      const StressOutcome outcome = pull({PullAside(0, 1)})->outcome();
      (*alone)[model] = std::max(outcome.tissue_force, outcome.reaction);
    }
    const double from = distance / 2e3;
    const auto body = pull({PullAside(from, -1), PullAside(from, 1)});
    const double most = std::max(body->outcome().tissue_force, body->outcome().reaction);
    StressTrial trial = Judge(std::max(0.0, most / alone->at(model) - 1), 9, 99);
    AddReturn(body.get(), kLetGo, &trial);
    return trial;
  };
  return stress_case;
}

// A press in and out every `kPeriod`, a whole number of steps.
StressCase InAndOut(bool quick) {
  StressCase stress_case =
      ContactCase("in_and_out", "A probe pressed 10 mm into the tissue and out, repeatedly",
                  {"times", "", 10, 100, 100});
  stress_case.truth =
      "the surface at the bottom of the last press against that of the fifth: degraded from 0.1 "
      "%, failed from 1 %, or if 0.1 mm stay";
  stress_case.run = [quick](StressModel model, double times) {
    constexpr double kPeriod = 0.2, kDepth = 0.01, kTip = 0.0025;
    StressTool tool = BlockHand({{0, AtBlock(0, kTip)}});
    const int count = static_cast<int>(times);
    tool.motion = [count](double t) {
      const double turns = (t - kBlockStart) / kPeriod;
      const double in =
          turns > 0 && turns < count ? 0.5 - 0.5 * std::cos(2 * std::numbers::pi * turns) : 0;
      return AtBlock(0.004, kTip + 0.002 - (kDepth + 0.002) * in);
    };
    StressSessionFixture body(BlockOrgan(model, quick), BlockSurface(quick), {tool});
    const double step = 1. / 30 + 1e-3;  // until the step at the bottom is published
    body.RunUntil(kBlockStart + 4.5 * kPeriod + step);
    const Points fifth = Displacements(body);
    body.RunUntil(kBlockStart + (count - 0.5) * kPeriod + step);
    StressTrial trial =
        Judge(RelativeSurfaceError(body.organ().rest(), Displacements(body), fifth), 0.001, 0.01);
    AddReturn(&body, kBlockStart + count * kPeriod, &trial);
    return trial;
  };
  return stress_case;
}

}  // namespace

std::vector<StressCase> ContactStress(bool quick) {
  return {CoincidentContacts(quick), ManyContacts(quick), ToolsApart(quick), InAndOut(quick)};
}

}  // namespace hpdm
