#include "render/tissue/clip_renderer.h"

#include <epoxy/gl.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "render/camera/frame_uniforms.h"
#include "render/image/colour.h"
#include "render/shader_sources.h"

namespace hpdm {
namespace {

constexpr double kStripCrease = std::numbers::pi / 5;  // rad
constexpr double kStripThickness = 0.0004;             // m: half axis of the strip in the U's plane
constexpr double kStripWidth = 0.0006;                 // m: half axis along the tube
constexpr double kOverhang = 0.0008;  // m: longer than the tube is wide, at each end
constexpr int kStripSides = 12, kBendArcs = 8;
const Colour kTitanium(0.72f, 0.74f, 0.77f);

// A point of the strip's middle line and its direction, in the plane z = 0.
struct Station {
  Vector3d p, along;
  double size = 1;  // of the section
};

std::vector<Station> MiddleLine(double flat, double wide) {
  const double x = flat + 0.8 * kStripThickness, y = wide + kOverhang;
  std::vector<Station> line;
  const auto end = [&](double side) {
    const Vector3d along(0, side, 0);
    line.push_back({Vector3d(side * x, -y - 0.6 * kStripThickness, 0), along, 0.5});
    line.push_back({Vector3d(side * x, -y, 0), along});
    if (side < 0) std::swap(line[line.size() - 2], line.back());
  };
  end(1);
  for (int a = 0; a <= kBendArcs; ++a) {
    const double angle = std::numbers::pi * a / kBendArcs;
    line.push_back({Vector3d(x * std::cos(angle), wide + x * std::sin(angle), 0),
                    Vector3d(-std::sin(angle), std::cos(angle), 0)});
  }
  end(-1);
  return line;
}

}  // namespace

SurfaceMesh ClipMesh(double flat, double wide) {
  const std::vector<Station> line = MiddleLine(flat, wide);
  const auto rings = static_cast<int>(line.size());
  SurfaceMesh mesh;
  mesh.vertices.resize(rings * kStripSides + 2, 3);
  mesh.triangles.resize(2 * rings * kStripSides, 3);
  for (int r = 0; r < rings; ++r) {
    const Station& station = line[static_cast<std::size_t>(r)];
    const Vector3d across = station.along.cross(Vector3d::UnitZ());
    for (int s = 0; s < kStripSides; ++s) {
      const double angle = 2 * std::numbers::pi * s / kStripSides;
      mesh.vertices.row(r * kStripSides + s) =
          station.p + station.size * (kStripThickness * std::cos(angle) * across -
                                      kStripWidth * std::sin(angle) * Vector3d::UnitZ());
    }
  }
  const int first = rings * kStripSides, last = first + 1;
  mesh.vertices.row(first) = line.front().p;
  mesh.vertices.row(last) = line.back().p;
  int t = 0;
  for (int s = 0; s < kStripSides; ++s) {
    const int next = (s + 1) % kStripSides, end = (rings - 1) * kStripSides;
    mesh.triangles.row(t++) << first, next, s;
    mesh.triangles.row(t++) << last, end + s, end + next;
    for (int r = 0; r + 1 < rings; ++r) {
      const int here = r * kStripSides, there = here + kStripSides;
      mesh.triangles.row(t++) << here + s, here + next, there + next;
      mesh.triangles.row(t++) << here + s, there + next, there + s;
    }
  }
  return mesh;
}

ClipRenderer::ClipRenderer(const std::vector<SurfaceMesh>& meshes)
    : program_("clip", {glsl::kFrame, glsl::kInstrumentVertex},
               {glsl::kFrame, glsl::kLight, glsl::kInstrumentFragment}),
      world_from_mesh_(program_.Uniform("world_from_mesh")),
      base_colour_(program_.Uniform("base_colour")),
      insulation_(program_.Uniform("insulation")),
      insulated_from_(program_.Uniform("insulated_from")) {
  program_.BindBlock("Frame", FrameBlock::kBinding);
  meshes_.reserve(meshes.size());
  for (const SurfaceMesh& mesh : meshes) meshes_.emplace_back(CutCreases(mesh, kStripCrease));
}

void ClipRenderer::Draw(std::span<const std::vector<Isometry3d>> poses_W) const {
  program_.Use();
  const Eigen::Vector3f titanium = Linear(kTitanium);
  glUniform3fv(base_colour_, 1, titanium.data());
  glUniform3fv(insulation_, 1, titanium.data());
  glUniform1f(insulated_from_, 1e3f);  // m: a clip has none
  for (std::size_t d = 0; d < meshes_.size(); ++d) {
    for (const Isometry3d& X_WC : poses_W[d]) {
      const Eigen::Matrix4f world_from_mesh = X_WC.matrix().cast<float>();
      glUniformMatrix4fv(world_from_mesh_, 1, GL_FALSE, world_from_mesh.data());
      meshes_[d].Draw();
    }
  }
}

}  // namespace hpdm
