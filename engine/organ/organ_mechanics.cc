#include "engine/organ/organ_mechanics.h"

#include <utility>

#include "engine/mesh/curved_surface.h"
#include "engine/tissue/support.h"

namespace hpdm {

OrganSurface::OrganSurface(const OrganOptions& organ_options, SurfaceMesh posed)
    : options(organ_options),
      rest(std::move(posed)),
      bounds(AxisAlignedBounds(rest.vertices)),
      topology(rest.vertices.rows(), rest.triangles),
      coarse(CoarseSurface::Of(rest)) {
  VertexNormals(rest.vertices, rest.triangles, &rest_normals);
  FitNormals(rest, topology, &rest_normals);
}

}  // namespace hpdm
