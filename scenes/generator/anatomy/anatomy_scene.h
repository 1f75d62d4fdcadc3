#pragma once

#include <cstdint>
#include <string>

#include "scenes/generator/anatomy/anatomy.h"

namespace hpdm {

/// Returns the scene of an anatomy as TOML. It names the files ORGAN.obj and ORGAN.png of each of
/// the anatomy's organs ("_" for a space) and liver_5000 and abdomen.png, all beside it.
/// `command`: what makes it, for the first comment.
std::string AnatomySceneText(const Anatomy& anatomy, const std::string& command);

/// Returns the name of an organ's files without their extension.
std::string FileStem(const std::string& organ);

}  // namespace hpdm
