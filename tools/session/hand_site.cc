#include "tools/session/hand_site.h"

#include "engine/base/error.h"
#include "engine/mesh/collision.h"
#include "engine/mesh/surface_topology.h"
#include "engine/tissue/support.h"

namespace hpdm {

HandSite SiteOnOrgan(const InstrumentOptions& instrument, const SurfaceMesh& rest,
                     const Vector3d& centre_of_volume_W) {
  const SurfaceTree tree(rest.vertices, rest.triangles);
  const Box bounds = AxisAlignedBounds(rest.vertices);
  const double size = (bounds.max - bounds.min).norm();
  SurfacePoint at;
  if (instrument.hand.target.has_value()) {
    at = tree.Closest(*instrument.hand.target, 10 * size).at;
  } else {
    at = tree.FirstEntry(instrument.p_trocar_W, centre_of_volume_W).at;
  }
  if (at.triangle < 0) {
    throw InputError(
        "instrument \"" + instrument.name + "\": the hand finds no surface of organ \"" +
            instrument.hand.organ +
            "\"; set instrument.hand.target near it, or the trocar outside it",
        {"instrument", instrument.name, instrument.hand.target ? "hand.target" : "trocar"});
  }
  HandSite site;
  site.p_target_W = at.Position(rest.vertices, rest.triangles);
  site.normal_W = InterpolatedNormal(rest.vertices, rest.triangles,
                                     SurfaceTopology(rest.vertices.rows(), rest.triangles), at);
  site.p_trocar_W = instrument.p_trocar_W;
  site.organ_size = size;
  return site;
}

}  // namespace hpdm
