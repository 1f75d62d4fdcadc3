#include "engine/organ/surface_organ.h"

#include "engine/base/check.h"
#include "engine/baselines/skin.h"
#include "engine/mesh/mesh_facts.h"

namespace hpdm {

SurfaceOrgan::SurfaceOrgan(const OrganSurface& surface) : OrganMechanics(surface) {
  const Skin skin = MeasureSkin(rest(), options().name);
  const Eigen::VectorXd ground =
      GroundSprings(rest(), skin, options().supports, options().material.young, options().name);
  tissue_volume_ = EnclosedVolume(rest().vertices, rest().triangles);
  centre_of_volume_W_ = EnclosedCentre(rest().vertices, rest().triangles);
  weights_ = VertexWeights(rest().vertices.rows());
  if (options().model == OrganModelType::kMassSpring) {
    springs_.emplace(rest(), ground,
                     MassSpringOf(options().material, skin.thickness, options().time_step),
                     options().name);
    return;
  }
  HPDM_CHECK(options().model == OrganModelType::kContinuum);
  continuum_.emplace(rest(), ground,
                     ContinuumOf(options().material, skin.thickness, options().time_step),
                     options().name);
  stiffness_ = continuum_->stiffness();
}

std::unique_ptr<Relaxation> SurfaceOrgan::MakeRelaxation(
    int /*slots*/, std::function<Nanoseconds()> /*clock*/) const {
  if (continuum_) return std::make_unique<SurfaceContinuum>(*continuum_);
  return std::make_unique<MassSpring>(*springs_);
}

void SurfaceOrgan::AddToRow(const SurfacePoint& at, double weight,
                            const ActiveRefinement& /*active*/,
                            Eigen::Ref<Eigen::RowVectorXd> row) const {
  for (int k = 0; k < 3; ++k) {
    row[rest().triangles(at.triangle, k)] += weight * at.barycentric[k];
  }
}

}  // namespace hpdm
