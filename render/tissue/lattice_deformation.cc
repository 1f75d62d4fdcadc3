#include "render/tissue/lattice_deformation.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "engine/base/check.h"
#include "engine/contact/half_space.h"
#include "render/gl/render_context.h"
#include "render/shader_sources.h"

namespace hpdm {
namespace {

constexpr int kMaxControlPoints = 350;

// The table of KernelSinking has kSinkingIntervals up to kSinkingEnd; beyond it, the shader takes
// two terms of the series.
constexpr int kSinkingIntervals = 256;
constexpr double kSinkingEnd = 3;

std::string Vector(const char* name, const std::array<int, 3>& v) {
  return std::string("#define ") + name + " ivec3(" + std::to_string(v[0]) + ", " +
         std::to_string(v[1]) + ", " + std::to_string(v[2]) + ")\n";
}

std::string Number(const char* name, int value) {
  return std::string("#define ") + name + " " + std::to_string(value) + "\n";
}

// Defines sizes as constants, so that the shader's compiler unrolls the sums.
std::string Sizes(const OrganModel& model) {
  const TensorBasis& basis = model.lattice_organ()->lattice().basis();
  const TensorBasis& finer =
      model.refinement_basis() != nullptr ? model.refinement_basis()->finer().basis() : basis;
  std::array<int, 3> degrees, cells, counts, finer_cells;
  for (int d = 0; d < 3; ++d) {
    degrees[d] = basis.axis(d).degree();
    cells[d] = basis.axis(d).cells();
    counts[d] = basis.axis(d).count();
    finer_cells[d] = finer.axis(d).cells();
  }
  return Number("BERNSTEIN", basis.axis(0).type() == BasisType::kBernstein ? 1 : 0) +
         Number("SUPPORT", 1 + *std::max_element(degrees.begin(), degrees.end())) +
         Vector("DEGREES", degrees) + Vector("CELLS", cells) + Vector("COUNTS", counts) +
         Vector("FINER_CELLS", finer_cells) + Number("MAX_INDENTATIONS", kMaxInstruments) +
         Number("SINKING_INTERVALS", kSinkingIntervals) + "#define SINKING_END " +
         std::to_string(kSinkingEnd) + "\n";
}

void Fill(const GlObject& buffer, const Eigen::Ref<const PointsF>& values, GLuint input) {
  const PointsF contiguous = values;
  glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(contiguous.size() * sizeof(float)),
               contiguous.data(), GL_STATIC_DRAW);
  glVertexAttribPointer(input, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  glEnableVertexAttribArray(input);
}

void Attach(const GlObject& texture, GLenum format, const GlObject& buffer) {
  glBindTexture(GL_TEXTURE_BUFFER, texture.name());
  glTexBuffer(GL_TEXTURE_BUFFER, format, buffer.name());
}

}  // namespace

bool UsesShader(FfdPath path, std::string_view renderer, const OrganModel& model) {
  if (model.lattice_organ() == nullptr || model.HasSplitFunctions()) return false;
  if (path == FfdPath::kCpu) return false;
  if (path == FfdPath::kShader) return true;
  if (IsSoftwareRenderer(renderer)) return false;
  return model.control_points() <= kMaxControlPoints;
}

LatticeDeformation::LatticeDeformation(const OrganModel& model, const Points& rest,
                                       const Points& rest_normals)
    : model_(model),
      count_(static_cast<int>(rest.rows())),
      program_("deformation",
               {Sizes(model).c_str(), glsl::kDeformationBasis, glsl::kDeformationVertex}, {},
               {"position", "normal"}),
      active_count_(program_.Uniform("active_count")),
      indentation_count_(program_.Uniform("indentation_count")),
      indentation_centre_(program_.Uniform("indentation_centre")),
      indentation_normal_(program_.Uniform("indentation_normal")),
      indentation_amplitude_(program_.Uniform("indentation_amplitude")) {
  HPDM_CHECK(model.lattice_organ() != nullptr && rest_normals.rows() == rest.rows());
  const OrientedBox& box = model.lattice_organ()->lattice().box();
  PointsF unit(rest.rows(), 3);
  for (Eigen::Index v = 0; v < rest.rows(); ++v) {
    const Vector3d c = box.ToUnit(rest.row(v).transpose());
    unit.row(v) = c.cwiseMax(0).cwiseMin(1).transpose().cast<float>();
  }
  glBindVertexArray(layout_.name());
  Fill(rest_buffer_, rest.cast<float>(), 0);
  Fill(normal_buffer_, rest_normals.cast<float>(), 1);
  Fill(unit_buffer_, unit, 2);
  glBindVertexArray(0);

  std::array<float, kSinkingIntervals + 1> sinking;
  for (int i = 0; i <= kSinkingIntervals; ++i) {
    sinking[i] = static_cast<float>(KernelSinking(kSinkingEnd * i / kSinkingIntervals));
  }
  glBindBuffer(GL_TEXTURE_BUFFER, sinking_buffer_.name());
  glBufferData(GL_TEXTURE_BUFFER, sizeof sinking, sinking.data(), GL_STATIC_DRAW);
  Attach(sinking_texture_, GL_R32F, sinking_buffer_);

  const int slots = model.RefinementSlots(kMaxInstruments);
  shape_.assign(
      static_cast<std::size_t>(model.lattice_organ()->lattice().basis().count() + 2 * slots),
      Eigen::Vector4f::Zero());
  glBindBuffer(GL_TEXTURE_BUFFER, shape_buffer_.name());
  glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(shape_.size() * sizeof(Eigen::Vector4f)),
               nullptr, GL_STREAM_DRAW);
  Attach(shape_texture_, GL_RGBA32F, shape_buffer_);

  program_.Use();
  program_.BindTexture("shape", 0);
  program_.BindTexture("sinking", 1);
  const Eigen::Matrix3f unit_from_world =
      (box.lengths.cwiseInverse().asDiagonal() * box.axes.transpose()).cast<float>();
  glUniformMatrix3fv(program_.Uniform("unit_from_world"), 1, GL_FALSE, unit_from_world.data());
  // The tail is KernelSinking(s) = (1 + tail / s^2) / (pi s).
  const double s = 2 * kSinkingEnd;
  glUniform1f(program_.Uniform("sinking_tail"),
              static_cast<float>((std::numbers::pi * s * KernelSinking(s) - 1) * s * s));
}

void LatticeDeformation::UploadShape(const OrganSnapshot& shape) {
  // First the lattice's grid, where dropped control points stay zero. Then, for each active local
  // function, its place in the finer grid and its displacement.
  const Lattice& lattice = model_.lattice_organ()->lattice();
  for (int a = 0; a < lattice.size(); ++a) {
    shape_[lattice.kept()[a]].head<3>() = shape.control_displacements.row(a).cast<float>();
  }
  std::size_t end = static_cast<std::size_t>(lattice.basis().count());
  int active = 0;
  for (std::size_t s = 0; s < shape.local_functions.size(); ++s) {
    const int function = shape.local_functions[s];
    if (function < 0) continue;
    const TensorBasis& finer = model_.refinement_basis()->finer().basis();
    const int ny = finer.axis(1).count(), nz = finer.axis(2).count();
    shape_[end++] =
        Eigen::Vector4i(function / (ny * nz), function / nz % ny, function % nz, 0).cast<float>();
    shape_[end++].head<3>() =
        shape.local_displacements.row(static_cast<Eigen::Index>(s)).cast<float>();
    ++active;
  }
  HPDM_CHECK(end <= shape_.size());
  glUniform1i(active_count_, active);
  // New storage each time: the driver need not wait for the last frame.
  glBindBuffer(GL_TEXTURE_BUFFER, shape_buffer_.name());
  glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(shape_.size() * sizeof(Eigen::Vector4f)),
               shape_.data(), GL_STREAM_DRAW);
}

void LatticeDeformation::UploadIndentations(const OrganSnapshot& shape) const {
  std::array<Eigen::Vector4f, kMaxInstruments> centre, normal, amplitude;
  for (int i = 0; i < shape.indentation_count; ++i) {
    const IndentationSnapshot& indentation = shape.indentations[i];
    centre[i] << indentation.p_rest_W.cast<float>(), static_cast<float>(indentation.radius);
    normal[i] << indentation.normal_W.cast<float>(),
        static_cast<float>(indentation.resolved_radius);
    amplitude[i] << indentation.amplitude_W.cast<float>(),
        static_cast<float>(IndentationReach(indentation.radius, indentation.resolved_radius));
  }
  glUniform1i(indentation_count_, shape.indentation_count);
  if (shape.indentation_count == 0) return;
  glUniform4fv(indentation_centre_, shape.indentation_count, centre[0].data());
  glUniform4fv(indentation_normal_, shape.indentation_count, normal[0].data());
  glUniform4fv(indentation_amplitude_, shape.indentation_count, amplitude[0].data());
}

void LatticeDeformation::Deform(const OrganSnapshot& shape, const GlObject& positions,
                                const GlObject& normals) {
  program_.Use();
  UploadShape(shape);
  UploadIndentations(shape);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_BUFFER, sinking_texture_.name());
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_BUFFER, shape_texture_.name());

  const GLsizeiptr bytes = GLsizeiptr{count_} * 3 * static_cast<GLsizeiptr>(sizeof(float));
  GLuint output = 0;
  for (const GlObject* buffer : {&positions, &normals}) {
    glBindBuffer(GL_ARRAY_BUFFER, buffer->name());
    glBufferData(GL_ARRAY_BUFFER, bytes, nullptr, GL_STREAM_DRAW);
    glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, output++, buffer->name());
  }
  glBindVertexArray(layout_.name());
  glEnable(GL_RASTERIZER_DISCARD);
  glBeginTransformFeedback(GL_POINTS);
  glDrawArrays(GL_POINTS, 0, count_);
  glEndTransformFeedback();
  glDisable(GL_RASTERIZER_DISCARD);
  glBindVertexArray(0);
  glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
  glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 1, 0);
}

}  // namespace hpdm
