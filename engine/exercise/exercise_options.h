#pragma once

#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/types.h"

/// A scene's exercise, validated by the loader (scenes/loader/scene.h), SI units.
namespace hpdm {

/// An instrument that a hand can hold, by its numbers in the scene.
struct ExerciseTool {
  int hand = 0;
  int instrument_index = 0;  ///< As in ToolPose.
};

/// A duct or a vessel of the scene.
struct ExerciseDuct {
  std::string name = {};
  /// The end that the organ which is taken out holds: 0 is a, 1 is b; -1: none.
  int organ_end = -1;
};

/// A condition of one organ's contact with a hand.
struct ExerciseContact {
  int organ = -1;
  std::vector<ExerciseTool> with = {};  ///< One of them; empty: any instrument.
};

/// A step of an exercise. It is done once all its conditions have held for `time` without a break.
struct ExerciseStepOptions {
  std::string name = {};         ///< Short: "lift the fundus".
  std::string instruction = {};  ///< For the trainee, one sentence; empty: the name.

  std::optional<ExerciseContact> holds = {};  ///< Jaws hold the organ.
  double lift = 0;  ///< m: what they hold is at least so far from its place.
  std::optional<ExerciseContact> touches = {};  ///< A tip presses the organ.
  std::optional<Vector3d> at_W = {};            ///< The press, or else the held tissue, is
                                                ///< within `within` of this, m.
  double within = 0;                            ///< m.
  std::vector<int> frees = {};                  ///< Attachments that are freed
  double freed_area = 0;                        ///< by this area together, m^2.
  std::vector<int> clips = {};                  ///< Ducts of which each has
  int clip_count = 3;                           ///< so many good clips (duct_judge.h).
  std::vector<int> cuts = {};                   ///< Ducts of which each is cut well.
  std::optional<int> releases = {};             ///< Organ that no jaws hold.
  std::optional<double> force = {};             ///< N: no instrument exerts more on tissue.
  double time = 0;                              ///< s.
};

/// Largest angle of a good clip if no rule says another, rad.
inline constexpr double kClipAngle = 20 * std::numbers::pi / 180;
/// Clips that stay in the body after a cut.
inline constexpr int kClipsThatStay = 2;

enum class ExerciseErrorKind {
  kForce,      ///< An instrument exerts more than `limit` N on tissue.
  kTear,       ///< Pulling, not burning or cutting, frees another `limit` m^2.
  kBurn,       ///< An energised hook is on an organ for `limit` s and burns no attachment.
  kStrayBurn,  ///< It touches nothing for `limit` s and burns no attachment.
  kNearBurn,  ///< Its tip is within `within` m of `path_W`, or its surface of a duct's, for `limit` s,
              ///< whatever it burns.
  kDrop,  ///< The last jaws lose an organ while it is held more than `limit` m from its place, or,
          ///< with a `path_W`, more than `within` m from that.
  kInverted,   ///< Tissue is inverted.
  kBadClip,    ///< A clip on a duct is not good, with the angle `limit` rad (duct_judge.h).
  kWrongClip,  ///< A clip is put on another duct than `ducts`, or an applier closes on `organ`.
  kLostClip,  ///< A clip falls. An applier that closes on the `organ` of kWrongClip does not count.
  kWrongCut,  ///< Scissors that press `organ` close.
  kEarlyClip,    ///< A duct is clipped before the step `before` is done.
  kEarlyCut,     ///< A duct is cut before it.
  kBadCut,       ///< After a cut, a duct is not cut well (duct_judge.h).
  kBleeding,     ///< A bleeding that the teacher began has lasted for `limit` s.
  kPerforation,  ///< A lumen of an organ begins to leak.
  kStretch,      ///< A duct is longer than `limit` times its length in the first step.
};

/// Something that a trainee must avoid. Each time is an error that costs `points`.
struct ExerciseErrorOptions {
  ExerciseErrorKind kind = ExerciseErrorKind::kForce;
  std::string name = {};              ///< For people: "perforation of the gallbladder".
  double limit = 0;                   ///< As the kind says.
  int organ = -1;                     ///< -1: any organ, or none (wrong clip).
  int attachment = -1;                ///< -1: all of them (tear).
  std::vector<int> ducts = {};        ///< Those that the kinds for ducts mean; empty: all.
  int before = -1;                    ///< Step of the early kinds.
  std::vector<Vector3d> path_W = {};  ///< m, of kNearBurn and kDrop: a line through these points.
  double within = 0;                  ///< m, of kNearBurn and kDrop.
  double points = 5;
};

/// A task with steps, errors, an end and a score. exercise_evaluator.h says how it is judged.
struct ExerciseOptions {
  std::string name;
  std::string goal;         ///< What the trainee must do, one sentence; may be empty.
  double time_limit = 300;  ///< s: then the exercise ends.
  double target_time = 0;   ///< s: up to here the time costs no points.
  std::vector<ExerciseStepOptions> steps;
  std::vector<ExerciseErrorOptions> errors;
  std::vector<ExerciseTool> hooks;     ///< The scene's hooks.
  std::vector<ExerciseTool> scissors;  ///< Its scissors.
  std::vector<ExerciseDuct> ducts;     ///< The scene's ducts.
  std::vector<std::string> organs;     ///< Names of the scene's organs.
  int clips_that_stay = kClipsThatStay;
};

}  // namespace hpdm
