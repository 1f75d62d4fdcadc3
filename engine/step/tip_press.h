#pragma once

#include "engine/contact/surface_kernel.h"
#include "engine/step/tip_contact.h"
#include "engine/step/tool_geometry.h"

namespace hpdm {

/// The press of one tool's tip: the kernel samples and the indentation under it (half_space.h). It
/// acts on the patch of GatherKernel() around the point under the tip, with the radius that the
/// lattice resolves. A rigid organ has the isotropic compliance of the virtual wall instead of an
/// indentation's compliance. Deformation thread; allocates nothing.
class TipPress {
 public:
  static constexpr double kMinKernelRadius = 0.001;  ///< m.

  /// `wall_stiffness` (N/m): of rigid organs that give none.
  TipPress(int tool, double wall_stiffness) : tool_(tool), wall_stiffness_(wall_stiffness) {}

  /// Returns the kernel radius of a tip, m.
  static double KernelRadius(const ToolGeometry& geometry);

  /// Adds the press row of a tip that is near enough; sets the contact's normal where it has none.
  /// `tool` is in the organ's frame. False if the organ's rows were full.
  bool AddRow(const ToolPose& tool, const ToolGeometry& geometry, const OrganModel& model,
              OrganState* state, TipContact* contact);

  /// Returns the local compliance under the tip, m/N.
  Matrix3d LocalCompliance(const OrganModel& model) const;
  /// Adds the lattice row of the press's kernel.
  void AddKernelToRow(const OrganModel& model, const OrganState& state,
                      Eigen::Ref<Eigen::RowVectorXd> row) const;

 private:
  Vector3d KernelNormal(const OrganModel& model, const OrganState& state, const TipContact& contact,
                        const Vector3d& facing, double radius);

  int tool_;
  double wall_stiffness_;
  KernelPatch kernel_;             // around the contact, for a normal that the tick does not give
  Neighbourhood resolved_around_;  // at rest, as wide as the lattice resolves
  KernelSamples resolved_;         // kernel samples for the lattice row
  LocalIndentation indentation_;   // unresolved local indentation
};

}  // namespace hpdm
