#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "tools/haptics/contact_tables.h"

/// Tables of the contact between organs (organ_trials.h) and of the shaft (shaft_trials.h), each
/// with a target.
namespace hpdm {

/// Two elastic spheres against Hertz; two blocks and two bars; presses of 20 mm in the scene
/// abdomen_on_springs.toml of the folder `scenes`, or none if it is not there. `done` hears of each table.
/// `quick`: fewer rows.
std::vector<ContactTable> MeasureOrganContacts(
    const std::filesystem::path& scenes, bool quick,
    const std::function<void(const ContactTable&)>& done);

/// A shaft swept sideways into a lobe of 10 mm.
std::vector<ContactTable> MeasureShaft(bool quick,
                                       const std::function<void(const ContactTable&)>& done);

}  // namespace hpdm
