#include "scenes/generator/organ_mesh.h"

#include "scenes/generator/meshing/surface_mesher.h"
#include "scenes/generator/texturing/texture_atlas.h"

namespace hpdm {

SurfaceMesh MeshOrgan(const ImplicitShape& shape, const OrganMeshOptions& options) {
  SurfaceMesherOptions mesher;
  mesher.triangle_count = options.outer_triangles;
  SurfaceMesh mesh = MeshImplicitSurface(shape, mesher);
  if (options.cavity_triangles > 0) {
    mesher.triangle_count = options.cavity_triangles;
    mesher.level = -options.wall;
    SurfaceMesh cavity = MeshImplicitSurface(shape, mesher);
    DeepenToDistance(shape, &cavity);
    mesh = Joined(mesh, TurnedInsideOut(cavity));
  }
  mesh.texture_coordinates = MakeTextureAtlas(mesh, options.outer_triangles);
  return mesh;
}

}  // namespace hpdm
