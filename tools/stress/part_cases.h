#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "engine/attachment/attachment_options.h"
#include "engine/duct/duct_options.h"
#include "tools/shared/organ_bench.h"
#include "tools/stress/stress_case.h"

/// The cases of organs of several parts, by what they load. All of them are in small strain, which
/// attachments, ducts, layers and lumens need.
namespace hpdm {

std::vector<StressCase> AttachmentStress(bool quick);
std::vector<StressCase> DuctStress(bool quick);
std::vector<StressCase> LayerAndLumenStress(bool quick);
std::vector<StressCase> FreeOrganStress();

/// Returns a case of the group "parts" that `run` runs at a value of the parameter.
StressCase PartCase(const std::string& name, const std::string& title,
                    const StressParameter& parameter, const std::string& truth,
                    std::function<StressTrial(double value)> run);

inline constexpr double kPartDegraded = 0.1;  ///< Error from which a case has degraded.
inline constexpr double kPartFailed = 0.5;    ///< And failed.
inline constexpr double kPartAtRest = 1e-4;   ///< m: what may stay when all has let go.
inline constexpr double kPartHalf = 1000;     ///< s: an organ's motion is then whole.

/// Judges by kPartDegraded and kPartFailed. The trial has failed, and harms, if anything is not
/// finite or `stays` (m) is more than kPartAtRest; `how` describes another fault that fails it.
StressTrial JudgePart(double error, bool finite, double stays, const std::string& how = "");

/// Sets the time of the next step to that at which organs with a motion of half a period kPartHalf
/// have moved by a share of it.
void MovePartTo(double share, OrganBench* bench);
/// Moves them from share to share in `steps` steps.
void MovePart(double from, double to, int steps, OrganBench* bench);

/// Returns the largest distance of a vertex of the organ from its place at rest, in the organ's own
/// offset frame, m.
double OffRest(const OrganBench& bench, int organ);
/// True if all organs' vertices are finite.
bool ShapesFinite(const OrganBench& bench);

/// Returns a layer like that of a gallbladder's bed between the facing sides of two organs that are
/// up to 1 mm apart.
AttachmentOptions PartLayer(const std::string& a, const std::string& b);

}  // namespace hpdm
