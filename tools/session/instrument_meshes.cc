#include "tools/session/instrument_meshes.h"

#include "engine/mesh/files/mesh_import.h"

namespace hpdm {

InstrumentMeshes LoadInstrumentMeshes(const InstrumentDescription& instrument) {
  InstrumentMeshes meshes;
  if (!instrument.mesh.empty()) {
    meshes.rigid = ImportMesh(instrument.mesh, 1.0).mesh;
    for (const std::string& jaw : instrument.jaws.meshes) {
      meshes.jaws.push_back(ImportMesh(jaw, 1.0).mesh);
    }
    meshes.pivot = instrument.jaws.pivot;
    meshes.opening = instrument.jaws.opening;
  } else if (instrument.geometry.tip_radius == kInstrumentRadius &&
             instrument.geometry.shaft_radius == kInstrumentRadius) {
    meshes = MakeInstrument(instrument.type);
  }
  if (instrument.insulated_from) meshes.insulated_from = *instrument.insulated_from;
  return meshes;
}

InstrumentVisual VisualOf(const InstrumentDescription& instrument, const InstrumentMeshes& meshes) {
  InstrumentVisual visual;
  visual.geometry = instrument.geometry;
  visual.insulated_from = meshes.insulated_from;
  if (meshes.rigid.triangles.rows() == 0) return visual;
  visual.parts.push_back({.mesh = &meshes.rigid});
  double opening = meshes.opening;
  for (const SurfaceMesh& jaw : meshes.jaws) {
    visual.parts.push_back({.mesh = &jaw, .pivot = meshes.pivot, .opening = opening});
    opening = -opening;
  }
  return visual;
}

}  // namespace hpdm
