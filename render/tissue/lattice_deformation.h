#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>
#include <vector>

#include "engine/organ.h"
#include "engine/snapshots.h"
#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"
#include "render/tissue/mesh_renderer.h"

namespace hpdm {

/// Who computes Eq. 4 for the picture.
enum class FfdPath : std::uint8_t {
  kAuto,    ///< UsesShader() decides.
  kCpu,     ///< The deformation loop's vertices are uploaded, their normals computed here.
  kShader,  ///< A vertex shader, from control displacements; organs without a lattice: kCpu.
};

/// Whether the path is a shader's, for an organ of n control points and the OpenGL renderer's name
/// (GL_RENDERER). kAuto: with at most 350 control points and no software renderer, which runs the
/// shader on the core that has the CPU's sums already, 2.7 to 6.1 times slower (`hpdm bench --only
/// ffd`); on a graphics card the limit has not been measured. The same on every run of a machine,
/// as the same pixels need; hence no timing.
bool UsesShader(FfdPath path, std::string_view renderer, const OrganModel& model);

/// Free-form deformation in a vertex shader (Eq. 4): x = X + sum_a phi_a(X) U_a, with the local
/// functions and indentations that DeformationLoop adds to a snapshot's vertices, for any
/// points of the organ's rest surface. Positions agree with the CPU's to single precision.
///
/// Normals are n = cof(F) n_rest (Nanson) with F = dx/dX of the same map, so no vertex needs its
/// neighbours. The CPU averages the normals of the deformed triangles: the two differ by what the
/// triangles miss of the map's curvature.
///
/// A frame sends the control displacements, the active local functions and the indentations (16
/// bytes a control point). The shader's output goes by transform feedback into the buffers that the
/// organ is drawn from, so that every vertex is deformed once however many programs draw it.
///
/// Render thread only.
class LatticeDeformation {
 public:
  /// For the rest points (V x 3, world, m) with unit normals (V x 3). Compiles a program for the
  /// lattice's basis. `model` must have a lattice and outlive this. Throws MachineError when the
  /// driver refuses the shader.
  LatticeDeformation(const OrganModel& model, const Points& rest, const Points& rest_normals);

  /// Deforms all points as `shape` says (its vertices are not read) into two buffers of V x 3
  /// floats, which it sizes. Allocates nothing on the CPU. Changes the program and vertex array in
  /// use.
  void Deform(const OrganSnapshot& shape, const GlObject& positions, const GlObject& normals);

 private:
  void UploadShape(const OrganSnapshot& shape);
  void UploadIndentations(const OrganSnapshot& shape) const;

  const OrganModel& model_;
  int count_;
  ShaderProgram program_;
  int active_count_, indentation_count_, indentation_centre_, indentation_normal_,
      indentation_amplitude_;
  std::vector<Eigen::Vector4f> shape_;  // the lattice's grid, then two entries a local function
  GlObject layout_{GlKind::kVertexArray};
  GlObject rest_buffer_{GlKind::kBuffer};
  GlObject normal_buffer_{GlKind::kBuffer};
  GlObject unit_buffer_{GlKind::kBuffer};
  GlObject shape_buffer_{GlKind::kBuffer};
  GlObject shape_texture_{GlKind::kTexture};
  GlObject sinking_buffer_{GlKind::kBuffer};
  GlObject sinking_texture_{GlKind::kTexture};
};

}  // namespace hpdm
