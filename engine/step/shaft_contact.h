#pragma once

#include "engine/step/grasp.h"
#include "engine/step/tip_contact.h"
#include "engine/step/tool_geometry.h"

namespace hpdm {

/// Outcome of AddShaftContact.
struct ShaftContact {
  bool touches = false;
  bool complete = true;  ///< False if the organ's rows were full.
};

/// Adds a row where the shaft of tool number `tool` pushes the organ. The jaws' part of the shaft,
/// and the `below` (m) under the surface, belong to the tip. Tissue beside `grasp` (this tool's on
/// this organ, or nullptr) moves with the jaws. A shaft that pushed it away would lever the held
/// tissue out of the jaws, with forces far beyond both. A rigid organ gets no row: nothing
/// moves, and the hand does not feel the shaft. Deformation thread; allocates nothing.
ShaftContact AddShaftContact(int tool, const ToolPose& pose_W, const ToolGeometry& geometry,
                             double below, const Grasp* grasp, const OrganModel& model,
                             OrganState* state);

}  // namespace hpdm
