#include "engine/organ.h"

#include "engine/base/error.h"
#include "engine/contact/surface_kernel.h"
#include "engine/mesh/files/mesh_import.h"
#include "engine/mesh/mesh_subdivision.h"
#include "engine/mesh/organ_size.h"
#include "engine/organ/rigid_organ.h"
#include "engine/tissue/stiffness_regions.h"

namespace hpdm {
namespace {

std::unique_ptr<const OrganMechanics> BuildMechanics(const OrganSurface& surface,
                                                     std::vector<std::string>* warnings) {
  if (!surface.options.cuts.empty() && !TakesCuts(surface.options)) {
    throw InputError("organ \"" + surface.options.name + "\": cannot be cut; " + kCutRemedy);
  }
  const bool has_parts = !surface.options.lumens.empty() || !surface.options.layers.empty();
  if (has_parts && !TakesFillingsAndLayers(surface.options)) {
    throw InputError("organ \"" + surface.options.name + "\": cannot have a lumen or a layer; " +
                     kFillingsAndLayersRemedy);
  }
  switch (surface.options.model) {
    case OrganModelType::kHpdm:
      return std::make_unique<LatticeOrgan>(surface, warnings);
    case OrganModelType::kRigid:
      return std::make_unique<RigidOrgan>(surface);
    case OrganModelType::kContinuum:
    case OrganModelType::kMassSpring:
      break;
  }
  return std::make_unique<SurfaceOrgan>(surface);
}

SparseRow RowOf(const WeightMatrix& weights, int row) {
  const int first = weights.outerIndexPtr()[row];
  const auto count = static_cast<std::size_t>(weights.outerIndexPtr()[row + 1] - first);
  return {{weights.innerIndexPtr() + first, count}, {weights.valuePtr() + first, count}};
}

}  // namespace

OrganModel::OrganModel(const OrganOptions& options, SurfaceMesh rest)
    : surface_(std::make_shared<const OrganSurface>(options, std::move(rest))),
      mechanics_(BuildMechanics(*surface_, &warnings_)) {
  relocation_ = std::make_shared<const Relocation>(this->rest().vertices, weights());
  if (options.supports.empty() && !options.free && !rigid()) {
    warnings_.push_back(
        "organ \"" + options.name +
        "\": no [[organ.support]]: a weak spring holds all of it at its rest place");
  }
}

int OrganModel::RefinementSlots(int contacts) const {
  return refinement_basis() != nullptr ? contacts * LocalFunctionsOf(options()) : 0;
}

SparseRow OrganModel::LatticeRow(int vertex) const { return RowOf(weights(), vertex); }

SparseRow OrganModel::FinerRow(int vertex) const {
  return RowOf(mechanics_->finer_weights(), vertex);
}

IndentationSnapshot AppliedIndentation(const LocalIndentation& indentation,
                                       const Vector3d& p_rest_W, const Vector3d& force_W) {
  return {.p_rest_W = p_rest_W,
          .normal_W = indentation.normal_W(),
          .radius = indentation.radius(),
          .resolved_radius = indentation.resolved_radius(),
          .amplitude_W = indentation.factor_W() * force_W};
}

MaterialOptions OrganModel::MaterialAt(const SurfacePoint& at) const {
  MaterialOptions material = options().material;
  material.young =
      YoungAt(options(), surface_->bounds, at.Position(rest().vertices, rest().triangles));
  return material;
}

LocalIndentation OrganModel::Indentation(const SurfacePoint& at, double radius) const {
  if (!mechanics_->HasModulus()) return LocalIndentation(radius);
  return {MaterialAt(at), InterpolatedNormal(rest().vertices, rest().triangles, topology(), at),
          radius, ResolvedRadius(at, radius)};
}

LocalIndentation OrganModel::AddLoadToRow(const Vector3d& p_centre_W, double radius,
                                          const ActiveRefinement& active,
                                          Eigen::Ref<Eigen::RowVectorXd> row) const {
  const LocalIndentation indentation = Indentation(NearestSurfacePoint(rest(), p_centre_W), radius);
  for (const SurfaceSample& sample :
       SurfaceKernel(rest(), p_centre_W, indentation.resolved_radius())) {
    AddToRow({sample.triangle, sample.barycentric}, sample.weight, active, row);
  }
  return indentation;
}

SurfaceMesh LoadPosedMesh(const OrganOptions& options, std::vector<std::string>* repairs) {
  ImportedMesh imported = ImportMesh(options.mesh, options.unit_m);
  for (const auto& [what, count] : imported.repairs.List()) {
    repairs->push_back(options.mesh + ": repaired: " + what + " (" + std::to_string(count) + ")");
  }
  if (const OrganSize size = SizeOfOrgan(imported.mesh, options.unit_m); !size.IsOrgan()) {
    const bool named = size.likely_unit.find('m') != std::string::npos;
    const std::string unit = named ? '"' + size.likely_unit + '"' : size.likely_unit;
    throw InputError(options.mesh + ": organ \"" + options.name + "\": " + size.Text() +
                         "; set organ.unit = " + unit,
                     {"organ", options.name, "unit"});
  }
  SurfaceMesh mesh = Subdivided(imported.mesh, options.subdivisions, options.mesh.c_str());
  Points& vertices = mesh.vertices;
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
    vertices.row(v) = options.X_WO * Vector3d(vertices.row(v));
  }
  return mesh;
}

}  // namespace hpdm
