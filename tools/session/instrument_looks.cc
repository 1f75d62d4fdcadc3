#include "tools/session/instrument_looks.h"

#include "engine/mesh/files/mesh_import.h"

namespace hpdm {

InstrumentModel LoadLooks(const InstrumentDescription& instrument) {
  InstrumentModel looks;
  if (!instrument.mesh.empty()) {
    looks.rigid = ImportMesh(instrument.mesh, 1.0).mesh;
    for (const std::string& jaw : instrument.jaws.meshes) {
      looks.jaws.push_back(ImportMesh(jaw, 1.0).mesh);
    }
    looks.pivot = instrument.jaws.pivot;
    looks.opening = instrument.jaws.opening;
  } else if (instrument.tip_radius == kInstrumentRadius &&
             instrument.shaft_radius == kInstrumentRadius) {
    looks = MakeInstrument(instrument.type);
  }
  if (instrument.insulated_from) looks.insulated_from = *instrument.insulated_from;
  return looks;
}

InstrumentView ViewOf(const InstrumentDescription& instrument, const InstrumentModel& looks) {
  InstrumentView view;
  view.tip_radius = instrument.tip_radius;
  view.shaft_radius = instrument.shaft_radius;
  view.insulated_from = looks.insulated_from;
  if (looks.rigid.triangles.rows() == 0) return view;
  view.parts.push_back({.mesh = &looks.rigid});
  double opening = looks.opening;
  for (const SurfaceMesh& jaw : looks.jaws) {
    view.parts.push_back({.mesh = &jaw, .pivot = looks.pivot, .opening = opening});
    opening = -opening;
  }
  return view;
}

}  // namespace hpdm
