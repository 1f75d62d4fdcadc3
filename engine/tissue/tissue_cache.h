#pragma once

#include <array>
#include <filesystem>

#include "engine/tissue/interior.h"

namespace hpdm {

/// Returns the folder that keeps sampled tissue between runs:
/// 1. $HPDM_CACHE if it is an absolute path; no folder (empty) if it is another word, such as
///    "off";
/// 2. otherwise $XDG_CACHE_HOME/hpdm, then ~/.cache/hpdm;
/// 3. empty if none of these is set.
std::filesystem::path TissueCacheFolder();

/// Returns the result of SampleTissue (interior.h), bit for bit, and keeps it in a file of
/// `folder`. A surface of 30,000 triangles takes half a second to sample and a few milliseconds to
/// read.
///
/// 1. The file name is a 128-bit digest of everything that decides the result: vertices, triangles,
///    box, cells, options, cuts, the sampler's source and the compiler.
/// 2. The file contains that digest, its sizes and a digest of its contents. A file that disagrees
///    in any of them is replaced.
/// 3. Files are renamed into place, so programs may share the folder.
/// 4. Above 256 MiB the least recently used files are removed.
/// 5. An empty folder name, or a missing or read-only folder, keeps nothing and is not an error.
///
/// Set-up only; any thread. Throws what SampleTissue throws.
TissueQuadrature CachedTissue(const SurfaceMesh& mesh_W, const OrientedBox& box_W,
                              const std::array<int, 3>& cells,
                              const InteriorOptions& options = InteriorOptions(),
                              const std::filesystem::path& folder = TissueCacheFolder());

}  // namespace hpdm
