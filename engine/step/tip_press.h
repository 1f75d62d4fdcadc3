#pragma once

#include <utility>
#include <vector>

#include "engine/contact/surface_kernel.h"
#include "engine/step/press_normal.h"
#include "engine/step/tip_contact.h"
#include "engine/step/tool_geometry.h"

namespace hpdm {

/// The virtual wall of one rigid organ at each of its vertices, N/m: V x 2, along the vertex normal
/// and across it.
using WallField = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// The press of one tool's tip, or of a part of its shaft: the kernel samples and the indentation under it (half_space.h). It
/// acts on the patch of GatherKernel() around the point under the tip, with the radius that the
/// lattice resolves. A rigid organ has the compliance of the virtual wall instead of an
/// indentation's compliance. Deformation thread; allocates nothing.
class TipPress {
 public:
  static constexpr double kMinKernelRadius = 0.001;  ///< m.

  /// `place`: of a tip, its index in ToolPatches::places. `walls`: [organ], of rigid organs that give no stiffness; those without a field have
  /// `wall_stiffness` (N/m) in every direction.
  TipPress(int tool, int place, double wall_stiffness, std::vector<WallField> walls = {})
      : tool_(tool), place_(place), wall_stiffness_(wall_stiffness), walls_(std::move(walls)) {}

  /// Returns the kernel radius of a tip, m.
  static double KernelRadius(const ToolGeometry& geometry);

  /// Adds the press row of a tip that is near enough; sets the contact's normal where it has none.
  /// `tool` is in the organ's frame; for a shaft its origin is the part that presses. False if the
  /// organ's rows were full.
  bool AddRow(const ToolPose& tool, const ToolGeometry& geometry, const OrganModel& model,
              OrganState* state, TipContact* contact);

  const LocalIndentation& indentation() const { return indentation_; }
  /// Returns the compliance of a rigid organ's virtual wall under the tip, m/N; zero for the others.
  Matrix3d WallCompliance(const OrganModel& model, const TipContact& contact) const;
  /// Returns the wall of rigid organ number `organ` at a vertex.
  WallStiffness WallAt(const OrganModel& model, int organ, int vertex) const;
  /// Adds the lattice row of the press's kernel.
  void AddKernelToRow(const OrganModel& model, const OrganState& state,
                      Eigen::Ref<Eigen::RowVectorXd> row) const;
  /// Returns that row, valid until the organ's next scratch row (TipCompliance).
  SparseRow KernelRow(const OrganModel& model, OrganState* state) const;
  /// Gathers the tilt of the surface under the contact, over the radius that the lattice resolves.
  void GatherTilt(const OrganModel& model, const TipContact& contact, OrganState* state,
                  PressNormal* normal) const;

 private:
  // Returns the organ's wall at its vertices; null if it is the same everywhere.
  const WallField* Field(const OrganModel& model, int organ) const;
  WallStiffness UniformWall(const OrganModel& model) const;

  int tool_;
  int place_;
  double wall_stiffness_;
  std::vector<WallField> walls_;
  PressNormal normal_;             // where the tick gives none
  Neighbourhood resolved_around_;  // at rest, as wide as the lattice resolves
  KernelSamples resolved_;         // kernel samples for the lattice row
  SurfacePoint resolved_at_;       // the point that they are about; triangle -1: there are none
  LocalIndentation indentation_;   // unresolved local indentation
};

}  // namespace hpdm
