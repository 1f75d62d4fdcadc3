#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/exercise/exercise_options.h"
#include "lcmtypes/wire/mesh_codec.h"

namespace hpdm {

/// An attachment of two organs.
struct AttachmentDescription {
  std::string name;  ///< "gallbladder and liver".
  double area = 0;   ///< Of its whole bed, m^2.
};

/// A layer of an organ.
struct LayerDescription {
  std::string name;     ///< "layer[0] of liver".
  double strength = 0;  ///< N/m; 0: not known.
};

/// Parts of a session, by index.
struct SessionInfo {
  std::vector<std::string> instruments;
  std::vector<std::vector<std::string>> held;  ///< Names by instrument and
                                               ///< ToolPose::instrument_index.
  std::vector<OrganDescription> organs;
  std::vector<AttachmentDescription> attachments;
  std::vector<LayerDescription> layers;  ///< Of the organs in turn.
  std::vector<std::string> lumens;       ///< Names of the filled ones of the organs in turn.
  std::vector<std::string> ducts;        ///< Names.
  std::optional<ExerciseOptions> exercise;
  bool left_handed = false;  ///< The first two instruments have exchanged their ports.
};

/// Name of a session's first event. Its text lists the instruments.
inline constexpr std::string_view kSessionStart = "session.start";

/// Name of the event after it in a session whose first two instruments have exchanged their ports.
inline constexpr std::string_view kLeftHanded = "session.left_handed";

/// Name of the event with which a teacher's bleeding begins, at the event's time.
inline constexpr std::string_view kBleeding = "teacher.bleeding";

/// Returns the text of kSessionStart: "instruments: left, right".
std::string SessionStartText(const std::vector<std::string>& instruments);

/// Returns up to `max` instruments that SessionStartText lists; none for any other text. The last
/// of `max` takes the rest, so a single name may contain ", ".
std::vector<std::string> InstrumentsIn(std::string_view start_text, std::size_t max);

}  // namespace hpdm
