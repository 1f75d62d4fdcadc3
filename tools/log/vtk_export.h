#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace hpdm {

/// Result of the export of one organ.
struct ExportedOrgan {
  std::string name;
  std::uint64_t surfaces = 0;  ///< Files written.
  std::uint64_t skipped = 0;   ///< Unreadable messages, and those that do not fit the organ's mesh.
};

struct ExportedSurfaces {
  std::filesystem::path index;
  std::uint64_t steps = 0;
  std::vector<ExportedOrgan> organs;
};

/// Writes the deformed surface of each organ by deformation step, from a log's HPDM_MESH and
/// HPDM_ORGAN, as VTK XML files in `folder`, which is created if missing. ParaView opens the index.
///
///     ORGAN_000012.vtp   the surface after step 12: vertices (world, m, float), triangles,
///                        and the vertices' `displacement` from rest (m). Step 0 is the rest shape.
///                        A step that did not change the organ, or whose shape did not reach the
///                        log, has no file.
///     surfaces.pvd       for each step its session time (s) and the files of all organs. Every time
///                        is there once: step 0 is left out if step 1 has time 0 as well.
///
/// File names are those of FileNames. Either all files appear, complete, or none. Memory: one
/// surface of each organ. Throws InputError if a file cannot be used or the log has no organ.
/// `at_event` is called for each event of the log and may throw to end the export.
ExportedSurfaces ExportVtk(
    const std::string& log, const std::filesystem::path& folder,
    const std::function<void()>& at_event = [] {});

}  // namespace hpdm
