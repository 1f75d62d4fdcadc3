#include "tools/session/scene_defaults.h"

#include <cmath>

#include "engine/tissue/support.h"
#include "tools/shared/report_text.h"

namespace hpdm {

std::string HoldRear(const Scene& scene, const SurfaceMesh& rest, OrganOptions* organ) {
  constexpr double kHeld = 0.3;
  const bool rigid = organ->model == OrganModelType::kRigid;
  if (rigid || organ->free || !organ->supports.empty() || scene.instruments.empty() ||
      IsAttached(scene.attachments, organ->name)) {
    return "";
  }
  const Box bounds = AxisAlignedBounds(rest.vertices);
  Vector3d front = Vector3d::Zero();
  for (const InstrumentOptions& instrument : scene.instruments) {
    front += instrument.p_trocar_W - (bounds.min + bounds.max) / 2;
  }
  const int axis = std::abs(front.x()) > std::abs(front.y()) ? 0 : 1;
  const bool upper = front[axis] <= 0;
  BoxFraction rear;
  (upper ? rear.min : rear.max)[axis] = upper ? 1 - kHeld : kHeld;
  organ->supports.push_back({rear, {}});
  const double edge =
      bounds.min[axis] + (upper ? 1 - kHeld : kHeld) * (bounds.max[axis] - bounds.min[axis]);
  return Format("organ \"%s\": no [[organ.support]]: its rear 30 %%, %s %s %.3f m, is held",
                organ->name.c_str(), axis == 0 ? "x" : "y", upper ? "above" : "below", edge);
}

void LookAtOrgans(const Box& bounds, LaparoscopeOptions* scope) {
  const LaparoscopeOptions usual;
  if (scope->p_scope_W != usual.p_scope_W || scope->p_target_W != usual.p_target_W) return;
  const Vector3d centre = (bounds.min + bounds.max) / 2;
  scope->p_scope_W += centre;
  scope->p_target_W += centre;
}

}  // namespace hpdm
