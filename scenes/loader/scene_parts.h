#pragma once

#include <optional>
#include <vector>

#include "engine/base/angle.h"
#include "scenes/loader/scene.h"
#include "scenes/loader/table_reader.h"

/// The parts of LoadScene. Each turns its tables into validated options and throws InputError at
/// the first fault.
namespace hpdm {

/// Limit of coordinates and lengths in a scene. An operating field is well below a metre across,
/// so a number beyond 10 m is most likely in millimetres.
inline constexpr double kMaxCoordinate = 10;
inline constexpr Interval kCoordinate = Interval::Within(kMaxCoordinate, "m");
/// Points of a path: a duct's axis, a leaf's line, the line of an error.
inline constexpr std::size_t kMaxPathPoints = 64;

/// Reads angles about x, y and z in degrees: R = Rz Ry Rx, so the world's x axis comes first.
void ReadRotation(const TableReader& table, std::string_view key, Matrix3d* rotation);

/// Validates a parsed document as LoadScene does. An `observer` is for the TableReader.
Scene ReadScene(const TomlDocument& document, KeyObserver* observer = nullptr);

OrganOptions ReadOrgan(const TableReader& table);
/// Returns the table's box, box_fraction or sphere, if it has one.
std::optional<Region> ReadRegion(const TableReader& table);
std::vector<LumenOptions> ReadLumens(const TableReader& organ);
std::vector<LayerOptions> ReadLayers(const TableReader& organ);
/// Adds the contact to its first organ's options.
void ReadContact(const TableReader& table, std::vector<OrganOptions>* organs);
AttachmentOptions ReadAttachment(const TableReader& table, const std::vector<OrganOptions>& organs);
/// `attachments`: the scene's; they bear the weight of a free organ.
DuctOptions ReadDuct(const TableReader& table, const std::vector<OrganOptions>& organs,
                     const std::vector<AttachmentOptions>& attachments);
/// Adds the cut to its organ's options. `number`: among the scene's cuts.
void ReadCut(const TableReader& table, int number, std::vector<OrganOptions>* organs);
LoadOptions ReadLoad(const TableReader& table, const std::vector<OrganOptions>& organs);
InstrumentOptions ReadInstrument(const TableReader& table, const std::vector<OrganOptions>& organs);

/// Reads the exercise. `scene`: with its organs, attachments and instruments.
ExerciseOptions ReadExercise(const TableReader& table, const Scene& scene);

/// Most steps and kinds of errors of an exercise.
inline constexpr std::size_t kMaxExerciseSteps = 32, kMaxExerciseErrors = 32;
/// Most pairs of organs that touch each other.
inline constexpr std::size_t kMaxContactPairs = 8;
/// Most cuts of a scene, and edges of one.
inline constexpr std::size_t kMaxCuts = 16, kMaxBladeEdges = 256;

/// Fails at `key` unless its value `name` is the name of an organ.
void RequireOrgan(const TableReader& table, std::string_view key, const std::string& name,
                  const std::vector<OrganOptions>& organs);

}  // namespace hpdm
