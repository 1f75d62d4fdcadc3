#include "engine/organ/rigid_organ.h"

#include "engine/base/error.h"
#include "engine/baselines/skin.h"
#include "engine/mesh/mesh_facts.h"

namespace hpdm {

RigidOrgan::RigidOrgan(const OrganSurface& surface) : OrganMechanics(surface) {
  weights_ = WeightMatrix(rest().vertices.rows(), 0);
  MeasureSkin(rest(), options().name);  // refuses a surface that encloses nothing
  if (const MeshFacts facts = ComputeMeshFacts(rest()); !facts.Closed()) {
    throw InputError("organ \"" + options().name + "\": a rigid organ's mesh must be closed, and " +
                     options().mesh + " has " + std::to_string(facts.boundary_edges) +
                     " boundary and " + std::to_string(facts.nonmanifold_edges) +
                     " non-manifold edges; repair it");
  }
  tissue_volume_ = EnclosedVolume(rest().vertices, rest().triangles);
  centre_of_volume_W_ = EnclosedCentre(rest().vertices, rest().triangles);
}

std::unique_ptr<Relaxation> RigidOrgan::MakeRelaxation(
    int /*slots*/, std::function<Nanoseconds()> /*clock*/) const {
  return MakeRigidRelaxation();
}

}  // namespace hpdm
