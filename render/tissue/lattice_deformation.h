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

/// The processor that computes Eq. 4 for the picture.
enum class FfdPath : std::uint8_t {
  kAuto,    ///< UsesShader() decides.
  kCpu,     ///< Uploads the deformation loop's vertices; MeshRenderer computes their normals.
  kShader,  ///< A vertex shader, from control displacements; organs without a lattice: kCpu.
};

/// True if a shader deforms the organ, with `renderer` the OpenGL renderer's name (GL_RENDERER).
/// kAuto chooses it for at most 350 control points on a graphics card, where that limit has not
/// been measured. A software renderer is 2.7 to 6.1 times slower than the CPU's sums (`hpdm bench
/// --only ffd`). The choice uses no timing, so every run on a machine draws the same pixels.
bool UsesShader(FfdPath path, std::string_view renderer, const OrganModel& model);

/// Free-form deformation of points of the organ's rest surface in a vertex shader:
///
///   positions   x = X + sum_a phi_a(X) U_a (Eq. 4), plus the local functions and indentations that
///               DeformationLoop adds to a snapshot's vertices. Single precision.
///   normals     n = cof(F) n_rest (Nanson), F = dx/dX. They need no neighbours. The CPU averages
///               the deformed triangles' normals; the two differ by discretisation.
///
/// A frame uploads the control displacements (16 bytes a control point), the active local functions
/// and the indentations. Transform feedback writes the result into the organ's vertex buffers, so
/// each vertex is deformed once for all programs that draw it.
///
/// Render thread only.
class LatticeDeformation {
 public:
  /// Takes the rest points (V x 3, world, m) and unit normals (V x 3). Compiles a program for the
  /// lattice's basis. `model` must have a lattice and outlive this. Throws MachineError if the
  /// driver refuses the shader.
  LatticeDeformation(const OrganModel& model, const Points& rest, const Points& rest_normals);

  /// Deforms all points by `shape` (except its vertices) into two buffers of V x 3 floats, which it
  /// resizes. Allocates nothing on the CPU. Changes the current program and vertex array.
  void Deform(const OrganSnapshot& shape, const GlObject& positions, const GlObject& normals);

 private:
  void UploadShape(const OrganSnapshot& shape);
  void UploadIndentations(const OrganSnapshot& shape) const;

  const OrganModel& model_;
  int count_;
  ShaderProgram program_;
  int active_count_, indentation_count_, indentation_centre_, indentation_normal_,
      indentation_amplitude_;
  std::vector<Eigen::Vector4f> shape_;  // the lattice's grid, then two entries per local function
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
