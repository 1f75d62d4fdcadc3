#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/check.h"
#include "scenes/generator/anatomy/anatomy.h"
#include "scenes/generator/anatomy/anatomy_scene.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "scenes/loader/scene.h"

namespace hpdm {

inline AnatomyVariant VariantNamed(std::string_view name) {
  for (const auto& [known, variant] : kAnatomyVariants) {
    if (known == name) return variant;
  }
  HPDM_CHECK(false);
  return AnatomyVariant::kUsual;
}

inline void WriteMesh(const SurfaceMesh& mesh, const std::string& name, const std::string& path) {
  std::ofstream(path) << ObjText(mesh, name);
}

/// The axis of a tube along y, m: from the middles of slices of its mesh towards where its field is least.
inline std::vector<Vector3d> AxisOf(const ImplicitShape& shape, const SurfaceMesh& tube,
                                    double radius) {
  constexpr int kSlices = 20;
  const double low = tube.vertices.col(1).minCoeff(), high = tube.vertices.col(1).maxCoeff();
  std::vector<Vector3d> axis;
  for (int s = 0; s < kSlices; ++s) {
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    for (const auto& p : tube.vertices.rowwise()) {
      if (static_cast<int>(kSlices * (p.y() - low) / (high - low)) != s) continue;
      sum += p.transpose();
      ++count;
    }
    if (count == 0) continue;
    const Vector3d middle = sum / count;
    const FieldSample field = shape.Sample(middle);
    axis.push_back(middle - (field.value + radius) * field.gradient);
  }
  return axis;
}

/// scenes/gallbladder_removal.toml with the organs, ducts and leaf of another anatomy, whose meshes go to
/// `folder`. Lattices are coarse and the hook is strong, so that steps and dissection are fast. The steps of
/// the critical view need 30 mm^2 of each layer only: what is tested comes before or after them.
inline Scene RemovalOf(AnatomyVariant variant, std::uint64_t seed, const std::string& folder) {
  Scene scene = LoadScene(std::string(HPDM_SOURCE_DIR) + "/scenes/gallbladder_removal.toml");
  const Anatomy anatomy(variant, seed);
  std::vector<const Anatomy::Organ*> made = {&anatomy.gallbladder};
  for (const Anatomy::Organ& organ : anatomy.fixed) made.push_back(&organ);
  constexpr double kBileDuctRadius = 0.0035;  // m, within 0.1 mm
  std::vector<Vector3d> axis;
  for (OrganOptions& organ : scene.organs) {
    organ.lattice.cells = {4, organ.name == "liver" ? 4 : 7, 4};
    organ.lattice.local.functions = 0;
    organ.texture.clear();
    for (const Anatomy::Organ* other : made) {
      if (other->name != organ.name) continue;
      const SurfaceMesh mesh = MeshOrgan(*other->shape, other->mesh);
      organ.mesh = folder + "/" + FileStem(organ.name) + ".obj";
      WriteMesh(mesh, organ.name, organ.mesh);
      if (organ.name == "bile duct") axis = AxisOf(*other->shape, mesh, kBileDuctRadius);
    }
  }
  for (std::size_t d = 0; d < scene.ducts.size(); ++d) {
    const Anatomy::Tube& tube = anatomy.tubes[d];
    DuctOptions& duct = scene.ducts[d];
    HPDM_CHECK(duct.name == tube.name);
    duct.path_W.resize(static_cast<Eigen::Index>(tube.path.size()), 3);
    for (std::size_t i = 0; i < tube.path.size(); ++i) {
      duct.path_W.row(static_cast<Eigen::Index>(i)) = tube.path[i].transpose();
    }
    duct.radius = tube.radius;
    duct.wall = tube.wall;
    duct.young = tube.young;
  }
  for (AttachmentOptions& attachment : scene.attachments) {
    if (attachment.IsLeaf()) {
      attachment.paths_W = {anatomy.leaf.on_gallbladder, anatomy.leaf.on_liver};
    }
  }
  for (ExerciseStepOptions& step : scene.exercise->steps) {
    step.freed_area = 3e-5 * static_cast<double>(step.frees.size());
  }
  for (ExerciseErrorOptions& error : scene.exercise->errors) {
    if (error.kind == ExerciseErrorKind::kNearBurn && error.ducts.empty()) error.path_W = axis;
  }
  scene.instruments[1].geometry.power = 400;
  return scene;
}

}  // namespace hpdm
