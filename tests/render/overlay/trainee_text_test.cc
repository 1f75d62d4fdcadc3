// What a trainee reads on the picture: pauses, exchanges, clips, errors with their figures, results, keys.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "engine/base/angle.h"
#include "engine/base/format.h"
#include "render/overlay/status_text.h"
#include "render/overlay/text_layout.h"

namespace hpdm {
namespace {

/// A hand with four instruments in a window, over an exercise.
struct Trainee {
  Trainee() {
    view.overlays = kOverlayText;
    view.window_width = 1000;
    view.window_height = 800;
    health.tool_count = scene.tool_count = 2;
    scene.step.time_ns = 20 * kNanosecondsPerSecond;
    names.organs = {"liver", "gallbladder"};
    names.instruments = {{"grasper"}, {"hook", "clip applier", "scissors", "suction"}};
    names.layers = {"Calot's triangle", "bed"};
    names.ducts = {"cystic duct", "cystic artery"};
    ExerciseOptions& exercise = names.exercise.emplace();
    exercise.name = "gallbladder removal";
    exercise.ducts = {{"cystic duct"}, {"cystic artery"}};
    exercise.steps = {{.name = "take the fundus", .instruction = "Take it"},
                      {.name = "clip the duct", .instruction = "Clip it three times"}};
    exercise.errors = {{.name = "clip oblique, loose, or too near", .points = 4},
                       {.name = "clip lost", .points = 2}};
    health.exercise = {.present = true, .step = 1, .time = 30, .time_left = 60, .score = 40};
    health.exercise.step_times[0] = 12.5f;
  }
  StatusText Text() const {
    Status status{.view = view, .health = health, .scene = scene};
    status.X_WC = X_WC;
    status.outside = outside;
    status.optics_turn = optics_turn;
    status.optics_changed = optics_changed;
    status.to_free = to_free;
    if (!to_free.empty()) {
      status.nearest_to_free[1] = {scene.tools[1].X_WT * to_free_T, to_free.back(), to_free_gap};
    }
    status.tautness = tautness;
    return MakeStatusText(status, names);
  }

  ViewSettings view;
  SessionHealth health;
  SceneSnapshot scene;
  StatusNames names;
  std::array<bool, kMaxInstruments> outside{};
  double optics_turn = 0, optics_changed = 0;
  std::vector<int> to_free = {};  // the last of them is nearest
  double to_free_gap = 0, tautness = 0;
  Isometry3d X_WC = Isometry3d::Identity();
  Vector3d to_free_T = Vector3d::Zero();  // m
};

std::string All(const std::vector<StatusLine>& lines) {
  std::string text;
  for (const StatusLine& line : lines) text += line.key + "|" + line.text + "\n";
  return text;
}
bool Shows(const std::vector<StatusLine>& lines, const std::string& text) {
  return All(lines).find(text) != std::string::npos;
}

TEST(TraineeText, APauseShowsNoFaultOfTheSimulationAndLeavesTheMiddleFree) {
  Trainee trainee;
  trainee.health.tools[0].guard_flags = kGuardStalePatch;
  EXPECT_TRUE(Shows(trainee.Text().tools[0], "simulation behind"));
  trainee.view.paused = true;
  trainee.health.tools[0].guard_flags |= kGuardPaused;
  const StatusText text = trainee.Text();
  EXPECT_FALSE(Shows(text.tools[0], "simulation behind"));
  EXPECT_TRUE(Shows(text.alarms, "PAUSED, p: resume"));
  EXPECT_TRUE(text.banner.empty());
  trainee.health.tools[0].guard_flags |= kGuardDeviceInvalid;
  EXPECT_TRUE(Shows(trainee.Text().tools[0], "device lost"))
      << "a fault that a pause does not explain";
}

TEST(TraineeText, AClipApplierCountsItsClipsAndSaysWhenItIsEmpty) {
  Trainee trainee;
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "clips"));
  trainee.scene.readouts[1].clips_left = 17;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "clips left: 17"));
  trainee.scene.readouts[1].clips_left = 0;
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "empty"));
  trainee.scene.readouts[1].closed_empty = true;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "empty: exchange it for a\n|full one"));
}

TEST(TraineeText, JawsThatCloseBesideADuctSayHowFarItIs) {
  Trainee trainee;
  ToolReadout& readout = trainee.scene.readouts[1];
  readout = {.missed_duct = 0, .missed_by = 0.0041, .missed_ns = 19 * kNanosecondsPerSecond};
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "no duct between jaws"));
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "4 mm from cystic duct"));
  readout.missed_ns = 10 * kNanosecondsPerSecond;
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "cystic")) << "10 s ago";
  readout = {.missed_duct = 0, .missed_by = 0.03, .missed_ns = 19 * kNanosecondsPerSecond};
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "cystic")) << "not near a duct";
}

TEST(TraineeText, ABadClipSaysWhichFaultItHas) {
  Trainee trainee;
  ExerciseStatus& status = trainee.health.exercise;
  status.errors = 1;
  status.last_error = 0;
  status.last_error_time = 21;
  EXPECT_FALSE(Shows(trainee.Text().guidance, "clip oblique")) << "9 s ago";
  status.last_error_time = 23;
  status.last_error_duct = 1;
  EXPECT_TRUE(Shows(trainee.Text().guidance, "clip oblique, loose, or too near"));
  status.last_error_clip = {
      .faults = kClipOblique, .angle = 38 * kDegree, .most_angle = 20 * kDegree};
  const std::string text = All(trainee.Text().guidance);
  EXPECT_NE(text.find("bad clip on cystic artery: oblique:"), std::string::npos) << text;
  EXPECT_NE(text.find("38\u00b0"), std::string::npos) << text;
  EXPECT_NE(text.find("roll it (q, e)"), std::string::npos) << text;
  EXPECT_EQ(text.find("loose"), std::string::npos) << text;
  status.last_error = 1;
  status.last_error_duct = -1;
  status.last_error_clip = {.faults = kClipOnNothing};
  EXPECT_TRUE(Shows(trainee.Text().guidance, "clip lost: no duct between the"));
}

TEST(TraineeText, APauseListsTheErrorsSoFar) {
  Trainee trainee;
  trainee.health.exercise.error_counts[0] = 3;
  trainee.health.exercise.error_counts[1] = 1;
  EXPECT_FALSE(Shows(trainee.Text().state, "clip lost"));
  trainee.view.paused = true;
  EXPECT_TRUE(Shows(trainee.Text().state, "|3 times clip oblique, loose, or"));
  EXPECT_TRUE(Shows(trainee.Text().state, "|clip lost\n"));
  EXPECT_FALSE(Shows(trainee.Text().guidance, "clip lost")) << "it would cover the tissue";
}

TEST(TraineeText, AnExchangeThatWaitsShowsTheOrderOfTheInstruments) {
  Trainee trainee;
  trainee.view.wanted_instrument[1] = 1;
  EXPECT_TRUE(Shows(trainee.Text().alarms, "hook > [clip applier] > scissors > suction"));
  EXPECT_TRUE(Shows(trainee.Text().alarms, "clip applier: free the tip to take it"));
  trainee.view.active_instrument = 1;
  trainee.view.help = true;
  EXPECT_TRUE(Shows(trainee.Text().banner, "[hook] > clip applier > scissors > suction"));
}

TEST(TraineeText, AnExercisesResultListsItsStepsAndErrors) {
  Trainee trainee;
  trainee.health.exercise.ended = true;
  trainee.health.exercise.errors = 3;
  trainee.health.exercise.error_counts[0] = 3;
  trainee.view.paused = true;  // the window holds the picture
  const StatusText text = trainee.Text();
  EXPECT_TRUE(text.alarms.empty());
  EXPECT_TRUE(Shows(text.banner, "not passed, score 40 of 100"));
  EXPECT_TRUE(Shows(text.banner, "12.5 s|take the fundus"));
  EXPECT_TRUE(Shows(text.banner, "\u2013|clip the duct"));
  EXPECT_TRUE(Shows(text.banner, "\u221212|clip oblique, loose, or too near (3 times)"));
  EXPECT_FALSE(Shows(text.banner, "clip lost"));
  EXPECT_TRUE(Shows(text.banner, "Esc ends the session"));
}

TEST(TraineeText, TheKeysStandAlone) {
  Trainee trainee;
  trainee.health.tools[0].depth = 0.061;
  EXPECT_FALSE(trainee.Text().alarms.empty());
  trainee.view.help = true;
  const StatusText text = trainee.Text();
  EXPECT_TRUE(text.loops.empty() && text.state.empty() && text.alarms.empty());
  EXPECT_TRUE(text.guidance.empty() && text.tools[0].empty());
  for (const char* said :
       {"up: push it in", "close the jaws while held", "keep them closed",
        "shows or hides the guidance: the steps, and what to do next", "next overlay:", "Home|"}) {
    EXPECT_TRUE(Shows(text.banner, said)) << said;
  }
  // The page fits on small and large pictures.
  for (const auto& [width, height] : {std::pair{640, 480}, {1000, 800}, {1920, 1080}}) {
    const GlyphAtlas atlas(TextPixels(width, height));
    EXPECT_LT(static_cast<int>(text.banner.size()) * atlas.line_height() + 2 * atlas.pixels(),
              height);
    int widest = 0;
    for (const StatusLine& line : text.banner) {
      widest = std::max(widest, atlas.Width(line.key) + atlas.Width(line.text));
    }
    EXPECT_LT(widest, width);
  }
}

TEST(TraineeText, ATipOutsideThePictureIsNamed) {
  Trainee trainee;
  EXPECT_FALSE(Shows(trainee.Text().tools[0], "outside"));
  trainee.outside[0] = trainee.outside[1] = true;
  // The mouse's; its port, along its axis z, is on the left.
  trainee.scene.tools[0].X_WT.linear() =
      Eigen::AngleAxisd(-EIGEN_PI / 2, Vector3d::UnitY()).toRotationMatrix();
  trainee.scene.tools[0].X_WT.translation() = Vector3d(-0.08, 0.01, -0.1);
  EXPECT_TRUE(Shows(trainee.Text().tools[0], "to it: push in\n"));
  trainee.scene.tools[0].X_WT.translation() = Vector3d(0.01, -0.08, -0.1);
  EXPECT_TRUE(Shows(trainee.Text().tools[0], "to it: up\n"));
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "outside the picture"));
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "to it"));
}

TEST(TraineeText, OpticsThatAreNotAsAtTheStartAreShown) {
  Trainee trainee;
  EXPECT_FALSE(Shows(trainee.Text().state, "optics"));
  trainee.view.scope.angle = 30 * kDegree;
  EXPECT_FALSE(Shows(trainee.Text().state, "optics")) << "those of the scene";
  trainee.optics_changed = 30 * kDegree;
  EXPECT_TRUE(Shows(trainee.Text().state, "optics 30\u00b0\n|Home: first view"));
  trainee.optics_turn = -45 * kDegree;
  EXPECT_TRUE(Shows(trainee.Text().state, "optics 30\u00b0, turned -45\u00b0"));
}

TEST(TraineeText, ATipThatTouchesNothingShowsHowFarTheNearestOrganIs) {
  Trainee trainee;
  trainee.names.tip_radii = {{0.0025}, {0.0015, 0.0025}};
  trainee.health.tools[1].organ = -1;
  trainee.scene.tools[1].X_WT.translation() = Vector3d(0, 0, 0.01);
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "free"));
  trainee.scene.contacts[1].organ = 1;
  trainee.scene.contacts[1].contact_W = Vector3d(0, 0, -0.0035);
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "12 mm from gallbladder"));
  trainee.scene.tools[1].instrument_index = 1;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "11 mm from gallbladder")) << "a thicker tip";
}

TEST(TraineeText, AnOpenClipApplierSaysHowTheClipWouldLieAndWhichKeyTurnsIt) {
  Trainee trainee;
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "between jaws"));
  ToolReadout& readout = trainee.scene.readouts[1];
  readout.clips_left = 3;
  readout.clip_ahead.duct = 0;
  readout.clip_ahead.coverage = 1;
  readout.clip_ahead.arc = 0.01;
  readout.clip_ahead.length = 0.02;
  readout.clip_ahead.angle = 18 * kDegree;
  EXPECT_TRUE(
      Shows(trainee.Text().tools[1], "in jaws: cystic duct\n|close now\n|18\u00b0 oblique"));
  readout.clip_ahead.angle = 34 * kDegree;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "in jaws: cystic duct\n|do not close yet"));
  readout.clip_roll = 31 * kDegree;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "34\u00b0 oblique: roll 31\u00b0, e"));
  readout.clip_roll = -31 * kDegree;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "roll 31\u00b0, q"));
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "cover it"));
  readout.clip_ahead.coverage = 0.8;
  readout.clip_roll = 0;
  trainee.names.duct_jaws = {{0}, {0.01}};
  readout.clip_ahead.place_W = Vector3d(0, 0, 0.001);
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "push in to cover it")) << "it is at the tip";
  readout.clip_ahead.place_W = Vector3d(0, 0, 0.009);
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "pull back to cover it"));
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "34\u00b0 oblique: turn the\n|tube, other hand"))
      << "no roll helps";
  SolvedContact& hold = trainee.scene.contacts[0];
  hold = {.organ = 1, .kind = ContactKind::kGrasp};
  hold.contact_W = Vector3d(0, 0.008, 0);
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "34\u00b0 oblique: ease the\n|pull, other hand"));
  hold.contact_W = Vector3d(0, 0.002, 0);
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "turn the\n|tube")) << "it is hardly drawn";
  hold = {};
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "from a clip")) << "no clip yet";
  readout.clips_beside.gap = 0.0024;  // between the middles of clips of 1 mm
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "1.4 mm from a clip: 2\n|needed"));
  readout.clips_beside.gap = 0.0031;
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "from a clip"));
  readout.clips_left = -1;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "in jaws: cystic duct"));
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "oblique")) << "scissors";
}

TEST(TraineeText, AClipApplierMayCloseOnlyWhereTheExerciseCountsTheClipAsGood) {
  Trainee trainee;
  ExerciseOptions& exercise = *trainee.names.exercise;
  exercise.ducts[0].organ_end = 0;  // the other end stays
  exercise.errors.push_back(
      {.kind = ExerciseErrorKind::kBadClip, .name = "oblique", .limit = 10 * kDegree});
  ToolReadout& readout = trainee.scene.readouts[1];
  readout.clips_left = 3;
  const auto text = [&](double angle, double coverage, double gap, double to_end) {
    readout.clip_ahead = {
        .duct = 0, .arc = 0.02 - to_end, .length = 0.02, .angle = angle * kDegree};
    readout.clip_ahead.coverage = coverage;
    readout.clips_beside.gap = gap;
    return trainee.Text().tools[1];
  };
  EXPECT_TRUE(Shows(text(9, 1, 0.0031, 0.0036), "close now"));
  EXPECT_TRUE(Shows(text(9, 1, 0.0031, 0.0196), "close now")) << "near the end that is taken out";
  EXPECT_TRUE(Shows(text(11, 1, 0.0031, 0.0036), "do not close yet")) << "the exercise's angle";
  EXPECT_TRUE(Shows(text(9, 0.97, 0.0031, 0.0036), "do not close yet"));
  EXPECT_TRUE(Shows(text(9, 1, 0.0029, 0.0036), "do not close yet"));
  EXPECT_TRUE(Shows(text(9, 1, 0.0031, 0.0034), "do not close yet"));
  EXPECT_TRUE(Shows(text(9, 1, 0.0031, 0.0034), "2.9 mm from its end: 3\n|needed"));
  exercise.errors.push_back({.kind = ExerciseErrorKind::kEarlyClip, .name = "early", .before = 1});
  EXPECT_TRUE(Shows(text(9, 1, 0.0031, 0.0036), "do not close yet\n|first clip the duct"));
  trainee.health.exercise.present = false;
  EXPECT_TRUE(Shows(text(9, 1, 0.0031, 0.0036), "close now")) << "a replay knows no step";
  trainee.health.exercise.present = true;
  exercise.steps.push_back({.name = "the last"});
  trainee.health.exercise.step = 2;
  EXPECT_TRUE(Shows(text(9, 1, 0.0031, 0.0036), "close now")) << "that step is done";
}

TEST(TraineeText, WithTheGuidanceOffAnInstrumentSaysWhatIsAndNotWhatIsNext) {
  Trainee trainee;
  ToolReadout& readout = trainee.scene.readouts[1];
  readout.clips_left = 3;
  readout.clip_ahead = {.duct = 0, .arc = 0.01, .length = 0.02, .angle = 34 * kDegree};
  readout.clip_ahead.coverage = 0.8;
  readout.clip_roll = 31 * kDegree;
  readout.clips_beside.gap = 0.0024;
  ExerciseOptions& exercise = *trainee.names.exercise;
  exercise.errors.push_back({.kind = ExerciseErrorKind::kEarlyClip, .name = "early", .before = 1});
  SolvedContact& held = trainee.scene.contacts[0];
  held.kind = ContactKind::kGrasp;
  held.organ = 1;
  exercise.steps[1].holds = {.organ = 1};
  exercise.steps[1].at_W = Vector3d(0.1, 0, 0);
  const auto hints = [&] {
    const StatusText text = trainee.Text();
    std::string shown;
    for (const char* hint :
         {"close", "first", "roll", "cover", "needed", "to its place", "do not"}) {
      if (Shows(text.tools[0], hint) || Shows(text.tools[1], hint)) shown += hint;
    }
    return shown;
  };
  EXPECT_EQ(hints(), "closefirstrollcoverneededto its placedo not");
  trainee.view.guidance = false;
  EXPECT_EQ(hints(), "");
  EXPECT_TRUE(Shows(trainee.Text().tools[0], "holds gallbladder"));
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "in jaws: cystic duct\n|34\u00b0 oblique"));
}

TEST(TraineeText, JawsForDuctsTellHowFarTheNearestDuctIs) {
  Trainee trainee;
  trainee.names.duct_jaws = {{0}, {0.01}};
  trainee.names.duct_radii = {0.002, 0.001};
  trainee.health.tools[1].organ = -1;
  trainee.scene.ducts.resize(2);
  for (std::size_t d = 0; d < 2; ++d) {
    DuctSnapshot& duct = trainee.scene.ducts[d];
    const auto x = static_cast<float>(0.02 + 0.01 * static_cast<double>(d));
    duct.nodes = 2;
    duct.nodes_W[0] = {x, -0.05f, 0.005f};
    duct.nodes_W[1] = {x, 0.05f, 0.005f};
  }
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "to cystic duct"));
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "20 mm: right")) << "from the jaws' middle";
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "not between"));
  trainee.scene.tools[1].X_WT.translation().x() = 0.0158;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "4 mm: right\n|not between the jaws"));
  trainee.scene.tools[1].X_WT.translation().x() = 0;
  trainee.names.exercise->steps[1].clips = {1};
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "to cystic artery")) << "the present step's";
  trainee.names.exercise->steps[1].clips = {};
  trainee.names.exercise->steps[1].cuts = {1};
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "to cystic artery"));
  trainee.names.exercise->steps[1].cuts = {};
  trainee.scene.ducts[0].segments[0] = SegmentState::kGap;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "30 mm: right"));
  trainee.scene.ducts[1].nodes_W[0].x() = trainee.scene.ducts[1].nodes_W[1].x() = 0.08f;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "free"));
}

TEST(TraineeText, TheForceOnTissueIsShownWhereTheHandFeelsLess) {
  Trainee trainee;
  trainee.health.tools[1].force_W = Vector3d(0, 0, 2.4);
  trainee.scene.contacts[1].force_on_tissue_W = Vector3d(0, 0, -2.8);
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "on tissue"));
  trainee.scene.contacts[1].force_on_tissue_W = Vector3d(0, 0, -7.21);
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "7.2 N on tissue\n|2.40 N"));
  trainee.health.tools[1].force_W = Vector3d::Zero();
  const auto tone = [&](double force) {
    trainee.scene.contacts[1].force_on_tissue_W = Vector3d(0, 0, -force);
    for (const StatusLine& line : trainee.Text().tools[1]) {
      if (line.text == Format("%.1f N on tissue", force)) return line.tone;
    }
    return Tone::kDim;
  };
  const double limit = HandlingLimits{}.force;
  EXPECT_EQ(tone(0.45 * limit), Tone::kPlain);
  EXPECT_EQ(tone(0.55 * limit), Tone::kWarning);
  EXPECT_EQ(tone(1.05 * limit), Tone::kAlarm);
}

TEST(TraineeText, WhatIsToBeCarriedSaysHowFarItsPlaceIs) {
  Trainee trainee;
  ExerciseStepOptions& step = trainee.names.exercise->steps[1];
  step.holds = {.organ = 1};
  SolvedContact& contact = trainee.scene.contacts[0];
  contact.kind = ContactKind::kGrasp;
  contact.organ = 1;
  contact.contact_W = Vector3d(0.01, 0, 0);
  EXPECT_FALSE(Shows(trainee.Text().tools[0], "to its place"));
  step.at_W = Vector3d(-0.06, 0, 0.01);
  step.within = 0.02;
  EXPECT_TRUE(Shows(trainee.Text().tools[0], "holds gallbladder\n|to its place\n|51 mm: left"));
  contact.organ = 0;
  EXPECT_FALSE(Shows(trainee.Text().tools[0], "to its place")) << "another organ";
}

TEST(TraineeText, ARestartIsShownForAWhile) {
  Trainee trainee;
  const std::string text = "begins again: instruments have let go";
  EXPECT_FALSE(Shows(trainee.Text().guidance, text));
  trainee.health.exercise.restarts = 1;
  trainee.health.exercise.restarted = 28;
  EXPECT_TRUE(Shows(trainee.Text().guidance, text));
  trainee.health.exercise.time = 40;
  EXPECT_FALSE(Shows(trainee.Text().guidance, text));
}

TEST(TraineeText, AForceThatCostsPointsIsGivenWithItsSize) {
  Trainee trainee;
  trainee.names.exercise->errors.push_back(
      {.kind = ExerciseErrorKind::kForce, .name = "more than 4 N on tissue", .limit = 4});
  ExerciseStatus& status = trainee.health.exercise;
  status.last_error = static_cast<int>(trainee.names.exercise->errors.size()) - 1;
  status.last_error_time = 29;
  status.last_error_force = 5.24;
  EXPECT_TRUE(Shows(trainee.Text().guidance, "more than 4 N on tissue: 5.2 N"));
}

TEST(TraineeText, AnInstructionGivesWayToTheStepsNameUntilAPause) {
  Trainee trainee;
  const ExerciseStepOptions& step = trainee.names.exercise->steps[1];
  trainee.health.exercise.time = 32;  // the step began at 12.5 s
  EXPECT_TRUE(Shows(trainee.Text().guidance, "2/2 " + step.instruction));
  trainee.health.exercise.time = 33;
  EXPECT_TRUE(Shows(trainee.Text().guidance, "2/2 " + step.name + " (p: how)"));
  trainee.view.paused = true;
  EXPECT_TRUE(Shows(trainee.Text().guidance, "2/2 " + step.instruction));
  trainee.view.paused = false;
  trainee.health.exercise.restarts = 1;
  trainee.health.exercise.restarted = 15;
  EXPECT_TRUE(Shows(trainee.Text().guidance, "2/2 " + step.instruction)) << "it began again";
}

TEST(TraineeText, AStepThatHasJustBeenDoneIsNamed) {
  Trainee trainee;
  const std::string first = trainee.names.exercise->steps[0].name;
  trainee.health.exercise.step = 1;
  trainee.health.exercise.time = 30;
  trainee.health.exercise.step_times[0] = 27;
  EXPECT_TRUE(Shows(trainee.Text().guidance, "done: " + first));
  trainee.health.exercise.time = 33;
  EXPECT_FALSE(Shows(trainee.Text().guidance, "done: " + first));
}

TEST(TraineeText, AHookInALayerSaysSo) {
  Trainee trainee;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "free"));
  trainee.scene.readouts[1].layer = 0;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "in Calot's triangle"));
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "free"));
}

TEST(TraineeText, AHookInALayerAlsoSaysHowDeepItIsInAnOrgan) {
  Trainee trainee;
  trainee.scene.readouts[1].layer = 0;
  trainee.health.tools[1].organ = 0;
  trainee.health.tools[1].depth = 0.0004;
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "mm into"));
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "touches liver")) << "and would burn it";
  trainee.health.tools[1].depth = 0.0039;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "in Calot's triangle"));
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "3.9 mm into"));
}

TEST(TraineeText, AHookInALayerSaysWhichOrganIsNear) {
  Trainee trainee;
  trainee.names.tip_radii = {{0.0025}, {0.0015}};
  trainee.scene.readouts[1].layer = 0;
  trainee.health.tools[1].organ = -1;
  trainee.scene.contacts[1].organ = 0;
  trainee.scene.contacts[1].contact_W = Vector3d(0, 0, -0.0027);
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "in Calot's triangle\n|1.2 mm from liver"));
  trainee.scene.contacts[1].contact_W = Vector3d(0, 0, -0.0037);
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "from liver"));
}

TEST(TraineeText, APressSaysTheWayOutOfTheOrgan) {
  Trainee trainee;
  trainee.health.tools[1].organ = trainee.scene.contacts[1].organ = 0;
  trainee.health.tools[1].depth = 0.0032;
  trainee.scene.contacts[1].normal_W = Vector3d(0, 0.6, 0.8);  // the shaft is along z
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "3.2 mm into liver\n|out: pull back, up"));
  trainee.scene.contacts[1].normal_W = Vector3d(-1, 0, 0);
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "out: left"));
  trainee.health.tools[1].depth = 0.0009;
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "out:")) << "it touches";
}

TEST(TraineeText, AnInstrumentThatPressesAnOrganStillSaysHowFarItsTargetIs) {
  Trainee trainee;
  trainee.health.tools[1].organ = 0;
  trainee.health.tools[1].depth = 0.002;
  trainee.to_free = {1};
  trainee.to_free_T = Vector3d(0, 0, 0.008);
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "2.0 mm into"));
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "to bed"));
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "8 mm: pull back"));
}

TEST(TraineeText, ScissorsNameTheOrganThatTheyWouldCutWithADuct) {
  Trainee trainee;
  trainee.scene.readouts[1].clip_ahead.duct = 1;
  trainee.scene.readouts[1].clips_left = -1;
  trainee.health.tools[1].organ = -1;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "in jaws: cystic artery"));
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "and " + trainee.names.organs[0]));
  trainee.health.tools[1].organ = 0;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "and " + trainee.names.organs[0]));
}

TEST(TraineeText, ScissorsTellHowManyClipsAreOnBothSidesOfTheCut) {
  Trainee trainee;
  trainee.scene.readouts[1].clip_ahead.duct = 1;
  trainee.scene.readouts[1].clips_left = -1;
  const auto tone = [&](int before, int after) {
    trainee.scene.readouts[1].clips_beside.before = before;
    trainee.scene.readouts[1].clips_beside.after = after;
    for (const StatusLine& line : trainee.Text().tools[1]) {
      const bool at_a = trainee.names.exercise->ducts[1].organ_end == 0;
      const int stay = at_a ? after : before, leave = at_a ? before : after;
      if (line.text == Format("%d clip%s, %d come%s out", stay, stay == 1 ? " stays" : "s stay",
                              leave, leave == 1 ? "s" : "")) {
        return line.tone;
      }
    }
    return Tone::kAlarm;
  };
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "from a clip")) << "there is none";
  trainee.scene.readouts[1].clips_beside.gap = 0.0013;  // to its middle
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "0.8 mm from a clip"));
  trainee.scene.readouts[1].clips_beside.gap = 0.006;
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "from a clip")) << "far away";
  int& organ_end = trainee.names.exercise->ducts[1].organ_end;
  organ_end = 0;
  EXPECT_EQ(tone(1, 2), Tone::kGood);
  EXPECT_EQ(tone(2, 1), Tone::kWarning) << "one stays in the body";
  organ_end = 1;
  EXPECT_EQ(tone(2, 1), Tone::kGood);
  EXPECT_EQ(tone(1, 2), Tone::kWarning) << "one stays in the body";
  EXPECT_EQ(tone(1, 1), Tone::kWarning) << "two stay in the body";
  EXPECT_EQ(tone(3, 0), Tone::kWarning);
  organ_end = -1;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "3 and 0 clips beside it"));
}

TEST(TraineeText, AHookSaysHowFarTheLayerToFreeIs) {
  Trainee trainee;
  trainee.to_free = {1};
  trainee.to_free_T = Vector3d(0.0123, 0, 0);
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "to bed"));
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "12 mm: right"));
  trainee.to_free_T = Vector3d(0.003, 0, 0.009);
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "9 mm: pull back")) << "up the shaft";
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "right")) << "hardly";
  trainee.to_free_T = Vector3d(0.002, -0.006, -0.007);
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "9 mm: push in, down"));
  trainee.scene.tools[1].X_WT.linear() =
      Eigen::AngleAxisd(EIGEN_PI / 2, Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "9 mm: push in, right")) << "a sideways tool";
  trainee.X_WC.linear() = trainee.scene.tools[1].X_WT.linear();
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "9 mm: push in, down")) << "and its picture";
  trainee.to_free_T = Vector3d(0, 0, -0.0004);
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "push in")) << "there already";
  EXPECT_TRUE(Shows(trainee.Text().tools[0], "free")) << "a grasper";
  trainee.scene.readouts[1].layer = 0;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "in Calot's triangle:\n|optional"));
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "to bed"));
  trainee.scene.readouts[1].layer = 1;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "in bed\n|burn now"));
  trainee.health.tools[1].organ = 0;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "in bed\n|burn briefly\n|touches liver"))
      << "the bed takes the heat";
  trainee.health.tools[1].depth = 0.0012;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "in bed\n|do not burn\n|1.2 mm into liver"));
  trainee.health.tools[1].organ = -1;
  trainee.scene.readouts[1].layer = 0;
  trainee.to_free = {0, 1};
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "in Calot's triangle\n|burn now"))
      << "both are wanted";
  trainee.to_free = {1};
  trainee.scene.readouts[1].layer = 1;
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "optional"));
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "to bed"));
  trainee.scene.readouts[1].layer = -1;
  trainee.to_free = {};
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "free")) << "nothing to free";
}

TEST(TraineeText, AHookThatDoesNotFitIntoTheGapSaysSo) {
  Trainee trainee;
  trainee.names.tip_radii = {{0.001}, {0.001}};
  trainee.to_free = {1};
  trainee.to_free_T = Vector3d(0.004, 0, 0);
  trainee.to_free_gap = 0.0018;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "gap 1.8 mm: pull further"));
  trainee.tautness = 0.7;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "gap 1.8 mm")) << "its strands may be short";
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "pull further")) << "others would tear";
  trainee.to_free_gap = 0.0026;
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "gap")) << "there is room";
  trainee.to_free_gap = 0.0018;
  trainee.scene.readouts[1].layer = 1;
  EXPECT_TRUE(Shows(trainee.Text().tools[1], "in bed\n|burn now\n|gap 1.8 mm"));
  trainee.scene.readouts[1].layer = -1;
  trainee.to_free_T = Vector3d(0.012, 0, 0);
  EXPECT_FALSE(Shows(trainee.Text().tools[1], "gap")) << "not there yet";
}

TEST(TraineeText, ALayerToFreeShowsHowNearItIsToTearing) {
  Trainee trainee;
  EXPECT_FALSE(Shows(trainee.Text().guidance, "pull"));
  trainee.tautness = 0.456;
  EXPECT_TRUE(Shows(trainee.Text().guidance, "pull: 46 % of tearing\n"));
  trainee.tautness = 0.8;
  EXPECT_TRUE(Shows(trainee.Text().guidance, "pull: 80 % of tearing, ease it"));
}

}  // namespace
}  // namespace hpdm
