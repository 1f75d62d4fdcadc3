#pragma once

#include <array>
#include <filesystem>

#include "engine/tissue/interior.h"

namespace hpdm {

/// Where sampled tissue is kept between runs: $HPDM_CACHE when that is an absolute path, none when
/// it is anything else but empty ("off"); else $XDG_CACHE_HOME/hpdm or ~/.cache/hpdm; empty when
/// none of these is set.
std::filesystem::path TissueCacheFolder();

/// SampleTissue (interior.h), bit for bit, but kept in a file of `folder` for the next time: 30,000
/// triangles take half a second to sample and some milliseconds to find again.
///
/// A file is named after a 128-bit digest of all that decides the result: vertices, triangles, box,
/// cells, options, and the sampler's own source and compiler. It holds the digest, its sizes and a
/// digest of its contents; one that does not agree in all of them is as good as none and written
/// anew. Files appear whole (renamed into place) or not at all, so programs may share the folder;
/// past 256 MiB the longest unused are removed. A folder that is empty, missing or read-only is no
/// error: then nothing is kept. Set-up only; any thread. Throws what SampleTissue throws.
TissueQuadrature CachedTissue(const SurfaceMesh& mesh_W, const OrientedBox& box_W,
                              const std::array<int, 3>& cells,
                              const InteriorOptions& options = InteriorOptions(),
                              const std::filesystem::path& folder = TissueCacheFolder());

}  // namespace hpdm
