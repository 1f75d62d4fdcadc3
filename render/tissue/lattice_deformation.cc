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

namespace hpdm {
namespace {

constexpr int kMaxControlPoints = 350;

// KernelSinking up to kSinkingEnd at as many intervals; beyond, two terms of its series.
constexpr int kSinkingIntervals = 256;
constexpr double kSinkingEnd = 3;

constexpr const char* kUnivariate = R"glsl(
// What is not zero at c of the functions along one axis: from the returned number on, their values
// and derivatives by c.
#if BERNSTEIN
int Evaluate(float c, int degree, int cells, out float value[SUPPORT], out float slope[SUPPORT]) {
  float s = 1.0 - c;
  float lower[SUPPORT];   // of degree - 1
  float power = 1.0, binomial = 1.0;
  for (int i = 0; i < degree; ++i) {
    lower[i] = binomial * power;
    power *= c;
    binomial *= float(degree - 1 - i) / float(i + 1);
  }
  power = 1.0;
  for (int i = degree - 1; i >= 0; --i) {
    lower[i] *= power;
    power *= s;
  }
  for (int i = 0; i <= degree; ++i) {
    float before = i > 0 ? lower[i - 1] : 0.0;
    float after = i < degree ? lower[i] : 0.0;
    value[i] = c * before + s * after;
    slope[i] = float(degree) * (before - after);
  }
  return 0;
}
#else
int Evaluate(float c, int degree, int cells, out float value[SUPPORT], out float slope[SUPPORT]) {
  float scaled = c * float(cells);
  int cell = min(int(scaled), cells - 1);
  float t = scaled - float(cell);
  float s = 1.0 - t;
  float h = float(cells);
  if (degree == 1) {
    value[0] = s, slope[0] = -h;
    value[1] = t, slope[1] = h;
  }
#if SUPPORT > 2
  if (degree == 2) {
    value[0] = 0.5 * s * s, slope[0] = -h * s;
    value[1] = 0.5 + t * s, slope[1] = h * (s - t);
    value[2] = 0.5 * t * t, slope[2] = h * t;
  }
#endif
#if SUPPORT > 3
  if (degree == 3) {
    value[0] = s * s * s / 6.0, slope[0] = -0.5 * h * s * s;
    value[1] = (4.0 + t * t * (3.0 * t - 6.0)) / 6.0, slope[1] = 0.5 * h * t * (3.0 * t - 4.0);
    value[2] = (4.0 + s * s * (3.0 * s - 6.0)) / 6.0, slope[2] = -0.5 * h * s * (3.0 * s - 4.0);
    value[3] = t * t * t / 6.0, slope[3] = 0.5 * h * t * t;
  }
#endif
  return cell;
}
#endif
)glsl";

constexpr const char* kDeform = R"glsl(
layout(location = 0) in vec3 rest;
layout(location = 1) in vec3 rest_normal;
layout(location = 2) in vec3 unit;         // the rest point in the lattice's box, 0..1
uniform samplerBuffer shape;               // see UploadShape
uniform samplerBuffer sinking;             // KernelSinking
uniform mat3 unit_from_world;              // d unit / d rest, 1/m
uniform float sinking_tail;
uniform int active_count;
uniform int indentation_count;
uniform vec4 indentation_centre[MAX_INDENTATIONS];       // w: radius
uniform vec4 indentation_normal[MAX_INDENTATIONS];       // w: resolved radius
uniform vec4 indentation_amplitude[MAX_INDENTATIONS];     // w: reach
out vec3 position;
out vec3 normal;

// KernelSinking and its derivative.
vec2 Sinking(float s) {
  if (s >= SINKING_END) {
    float tail = sinking_tail / (s * s);
    return vec2(1.0 + tail, -(1.0 + 3.0 * tail) / s) / (3.14159265 * s);
  }
  float at = s * float(SINKING_INTERVALS) / SINKING_END;
  int i = min(int(at), SINKING_INTERVALS - 1);
  float low = texelFetch(sinking, i).x, high = texelFetch(sinking, i + 1).x;
  return vec2(low + (at - float(i)) * (high - low),
              (high - low) * float(SINKING_INTERVALS) / SINKING_END);
}

void main() {
  vec3 u = vec3(0.0);
  mat3 by_unit = mat3(0.0);                // du / d unit
  float nx[SUPPORT], ny[SUPPORT], nz[SUPPORT], dx[SUPPORT], dy[SUPPORT], dz[SUPPORT];
  ivec3 first = ivec3(Evaluate(unit.x, DEGREES.x, CELLS.x, nx, dx),
                      Evaluate(unit.y, DEGREES.y, CELLS.y, ny, dy),
                      Evaluate(unit.z, DEGREES.z, CELLS.z, nz, dz));
  for (int i = 0; i <= DEGREES.x; ++i) {
    vec3 u_yz = vec3(0.0), u_y_z = vec3(0.0), u_yz_ = vec3(0.0);  // sum, d/dy, d/dz
    for (int j = 0; j <= DEGREES.y; ++j) {
      vec3 u_z = vec3(0.0), u_z_ = vec3(0.0);
      int row = ((first.x + i) * COUNTS.y + first.y + j) * COUNTS.z + first.z;
      for (int k = 0; k <= DEGREES.z; ++k) {
        vec3 U = texelFetch(shape, row + k).xyz;
        u_z += nz[k] * U;
        u_z_ += dz[k] * U;
      }
      u_yz += ny[j] * u_z;
      u_y_z += dy[j] * u_z;
      u_yz_ += ny[j] * u_z_;
    }
    u += nx[i] * u_yz;
    by_unit[0] += dx[i] * u_yz;
    by_unit[1] += nx[i] * u_y_z;
    by_unit[2] += nx[i] * u_yz_;
  }

  if (active_count > 0) {
    first = ivec3(Evaluate(unit.x, DEGREES.x, FINER_CELLS.x, nx, dx),
                  Evaluate(unit.y, DEGREES.y, FINER_CELLS.y, ny, dy),
                  Evaluate(unit.z, DEGREES.z, FINER_CELLS.z, nz, dz));
    for (int a = 0; a < active_count; ++a) {
      int entry = COUNTS.x * COUNTS.y * COUNTS.z + 2 * a;
      ivec3 at = ivec3(texelFetch(shape, entry).xyz) - first;
      if (any(lessThan(at, ivec3(0))) || any(greaterThan(at, DEGREES))) continue;
      vec3 U = texelFetch(shape, entry + 1).xyz;
      u += nx[at.x] * ny[at.y] * nz[at.z] * U;
      by_unit[0] += dx[at.x] * ny[at.y] * nz[at.z] * U;
      by_unit[1] += nx[at.x] * dy[at.y] * nz[at.z] * U;
      by_unit[2] += nx[at.x] * ny[at.y] * dz[at.z] * U;
    }
  }
  mat3 F = mat3(1.0) + by_unit * unit_from_world;

  for (int i = 0; i < indentation_count; ++i) {
    vec3 from_centre = rest - indentation_centre[i].xyz;
    float d = length(from_centre);
    if (d >= indentation_amplitude[i].w ||
        dot(rest_normal, indentation_normal[i].xyz) <= 0.0) continue;
    float radius = indentation_centre[i].w, resolved = indentation_normal[i].w;
    vec2 near = Sinking(d / radius) / radius, far = Sinking(d / resolved) / resolved;
    u += (near.x - far.x) * indentation_amplitude[i].xyz;
    float slope = near.y / radius - far.y / resolved;
    F += outerProduct(indentation_amplitude[i].xyz, slope / max(d, 1e-9) * from_centre);
  }

  position = rest + u;
  mat3 cofactors = mat3(cross(F[1], F[2]), cross(F[2], F[0]), cross(F[0], F[1]));
  vec3 n = cofactors * rest_normal;
  normal = n * inversesqrt(max(dot(n, n), 1e-30));
}
)glsl";

std::string Vector(const char* name, const std::array<int, 3>& v) {
  return std::string("#define ") + name + " ivec3(" + std::to_string(v[0]) + ", " +
         std::to_string(v[1]) + ", " + std::to_string(v[2]) + ")\n";
}

std::string Number(const char* name, int value) {
  return std::string("#define ") + name + " " + std::to_string(value) + "\n";
}

// Constants, so that the compiler unrolls the sums.
std::string Sizes(const OrganModel& model) {
  const TensorBasis& basis = model.lattice()->basis();
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
  if (!model.lattice() || path == FfdPath::kCpu) return false;
  if (path == FfdPath::kShader) return true;
  if (IsSoftwareRenderer(renderer)) return false;
  return model.control_points() <= kMaxControlPoints;
}

LatticeDeformation::LatticeDeformation(const OrganModel& model, const Points& rest,
                                       const Points& rest_normals)
    : model_(model),
      count_(static_cast<int>(rest.rows())),
      program_("deformation", {Sizes(model).c_str(), kUnivariate, kDeform}, {},
               {"position", "normal"}),
      active_count_(program_.Uniform("active_count")),
      indentation_count_(program_.Uniform("indentation_count")),
      indentation_centre_(program_.Uniform("indentation_centre")),
      indentation_normal_(program_.Uniform("indentation_normal")),
      indentation_amplitude_(program_.Uniform("indentation_amplitude")) {
  HPDM_CHECK(model.lattice().has_value() && rest_normals.rows() == rest.rows());
  const OrientedBox& box = model.lattice()->box();
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
  shape_.assign(static_cast<std::size_t>(model.lattice()->basis().count() + 2 * slots),
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
  // Of (1 + tail / s^2) / (pi s).
  const double s = 2 * kSinkingEnd;
  glUniform1f(program_.Uniform("sinking_tail"),
              static_cast<float>((std::numbers::pi * s * KernelSinking(s) - 1) * s * s));
}

void LatticeDeformation::UploadShape(const OrganSnapshot& shape) {
  // By the lattice's grid, in which the dropped control points stay zero; then of each active local
  // function its place in the finer grid and its displacement.
  const Lattice& lattice = *model_.lattice();
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
