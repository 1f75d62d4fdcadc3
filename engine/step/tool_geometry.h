#pragma once

namespace hpdm {

/// Default radius of tips and shafts, m: a 5 mm instrument.
inline constexpr double kDefaultToolRadius = 0.0025;

/// Largest cosine between a shaft's axis and the normal of a surface that it touches. A shaft that
/// enters more end on only follows its own tip's indentation.
inline constexpr double kMaxEndOn = 0.7;

/// Least distance between two contacts of a shaft with one organ, m.
inline constexpr double kShaftApart = 0.02;

/// Effect of an instrument on tissue besides its force.
enum class ToolAction {
  kNone,
  kBurn,  ///< A hook, while its pedal is pressed.
  kCut,   ///< Scissors, when they close.
  kClip,  ///< A clip applier, when it closes.
  kSuck   ///< A suction tube, while its pedal is pressed.
};

/// Geometry of an instrument that a hand can hold (ToolPose::instrument_index), for both loops.
struct ToolGeometry {
  double tip_radius = kDefaultToolRadius;    ///< m.
  double shaft_radius = kDefaultToolRadius;  ///< m.
  double friction = 0;        ///< Coulomb coefficient; haptic loop only (sent with each tick).
  bool can_grasp = false;     ///< Deformation loop only (sent with each patch), like the jaws'.
  double closing_force = 5;   ///< N, with which closed jaws press on tissue between them.
  double jaw_friction = 0.5;  ///< Coulomb coefficient of the jaws' faces.
  ToolAction action = ToolAction::kNone;  ///< Deformation loop only, like the rest.
  double power = 40;                      ///< W, of an energised hook, into tissue.
  double opening = 0.38;                  ///< rad, of each blade of scissors when open.
  int clips = 0;                          ///< In the magazine of a clip applier at the start.

  /// Returns the length of the jaws from the tip to the shaft, m.
  double JawsLength() const { return 4 * tip_radius; }
  /// Returns the largest pull along the jaws' faces that friction on both of them holds, N.
  double Hold() const { return 2 * jaw_friction * closing_force; }
};

}  // namespace hpdm
