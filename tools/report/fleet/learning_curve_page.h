#pragma once

#include <span>
#include <string>

#include "tools/report/fleet/learning_curve.h"

namespace hpdm {

/// Returns a self-contained HTML page, without scripts, that draws each task's figures over its sessions.
std::string LearningCurvePage(std::span<const LearningCurve> curves);

}  // namespace hpdm
