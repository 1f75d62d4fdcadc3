#include "render/tissue/organ_renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <string>

#include "engine/base/check.h"
#include "render/camera/frame_uniforms.h"
#include "render/tissue/lighting.h"
#include "render/tissue/tissue_detail.h"

namespace hpdm {
namespace {

constexpr const char* kOrganVertex = R"glsl(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 offset;
layout(location = 3) in vec2 texture_coordinate;
out vec3 p_W;
out vec3 normal_W;
out vec2 uv;
void main() {
  p_W = position + offset;
  normal_W = normal;
  uv = texture_coordinate;
  gl_Position = clip_from_world * vec4(p_W, 1.0);
}
)glsl";

constexpr const char* kOrganFragment = R"glsl(
in vec3 p_W;
in vec3 normal_W;
in vec2 uv;
uniform vec3 base_colour;
uniform float metres_per_uv;
uniform sampler2D base_texture;
uniform sampler2D openness;   // by position in the picture
out vec4 colour;
void main() {
  vec3 to_lens = normalize(lens_W.xyz - p_W);
  vec3 n = normalize(normal_W);
  n = faceforward(n, -to_lens, n);
  vec2 m = metres_per_uv * uv;
  Detail detail = DetailAt(m);
  vec3 rough = Raised(p_W, n, m, detail.slope);
  vec3 albedo = base_colour * texture(base_texture, uv).rgb * (0.86 + 0.28 * detail.height);
  float open = Openness(p_W, n) * texture(openness, 0.5 * gl_FragCoord.xy / circle_px.xy).r;
  colour = Encode(ShadeTissue(p_W, to_lens, n, rough, detail.spread, albedo) * open);
}
)glsl";

constexpr const char* kOrganDepthFragment = "void main() {}\n";

constexpr int kBaseTextureUnit = 0;
constexpr int kDetailUnit = 1;
constexpr int kOcclusionUnit = 2;

const Image& White() {
  static const Image white{1, 1, {255, 255, 255}};
  return white;
}

// Of the mesh's vertices and those that seams repeat.
std::unique_ptr<LatticeDeformation> DeformationOf(const OrganModel& model,
                                                  const std::vector<int>& copies) {
  const Eigen::Index count = model.rest().vertices.rows();
  Points rest(count + static_cast<Eigen::Index>(copies.size()), 3), normals(rest.rows(), 3);
  for (Eigen::Index row = 0; row < rest.rows(); ++row) {
    const Eigen::Index vertex = row < count ? row : copies[static_cast<std::size_t>(row - count)];
    rest.row(row) = model.rest().vertices.row(vertex);
    normals.row(row) = model.rest_normals().row(vertex);
  }
  return std::make_unique<LatticeDeformation>(model, rest, normals);
}

}  // namespace

OrganRenderer::OrganRenderer(const std::vector<OrganVisual>& organs, bool levels)
    : program_("organ", {glsl::kFrame, kOrganVertex},
               {glsl::kFrame, glsl::kLight, glsl::kTissue, glsl::kTissueDetail, kOrganFragment}),
      depth_program_("organ depth", {glsl::kFrame, kOrganVertex}, {kOrganDepthFragment}),
      base_colour_(program_.Uniform("base_colour")),
      metres_per_uv_(program_.Uniform("metres_per_uv")),
      detail_(TissueDetail()),
      no_occlusion_(White()) {
  program_.BindBlock("Frame", FrameBlock::kBinding);
  program_.BindTexture("base_texture", kBaseTextureUnit);
  program_.BindTexture("tissue_detail", kDetailUnit);
  program_.BindTexture("openness", kOcclusionUnit);
  depth_program_.BindBlock("Frame", FrameBlock::kBinding);
  const std::string renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  organs_.reserve(organs.size());
  for (const OrganVisual& organ : organs) {
    const bool textured = organ.texture != nullptr;
    HPDM_CHECK(!textured || organ.rest->texture_coordinates.rows() > 0);
    const SurfaceMesh mesh = WithCoordinates(*organ.rest);
    organs_.push_back({.mesh = MeshRenderer(mesh),
                       .texture = Texture(textured ? *organ.texture : White()),
                       .colour = textured ? Eigen::Vector3f(1, 1, 1) : Linear(organ.colour),
                       .metres_per_uv = static_cast<float>(MetresPerCoordinate(mesh))});
    if (levels) organs_.back().SetLevels(mesh);
    if (organ.model != nullptr && UsesShader(organ.ffd, renderer, *organ.model)) {
      organs_.back().deformation = DeformationOf(*organ.model, organs_.back().mesh.copies());
    }
  }
}

void OrganRenderer::Organ::Move(const OrganSnapshot& shape) {
  mesh.SetOffset(shape.offset_W.cast<float>());
  if (version == shape.version) return;
  version = shape.version;
  std::fill(errors.begin(), errors.end(), -1.0);
  if (shape.vertices.rows() > 0) {
    low_W = shape.vertices.colwise().minCoeff().transpose().cast<double>();
    high_W = shape.vertices.colwise().maxCoeff().transpose().cast<double>();
  }
  if (deformation) {
    deformation->Deform(shape, mesh.positions(), mesh.normals());
  } else {
    mesh.SetVertices(shape.vertices);
  }
}

void OrganRenderer::Organ::SetLevels(const SurfaceMesh& rest) {
  levels = MakeLevels(CutSeams(rest), rest.vertices, metres_per_uv);
  mesh.SetLevels(levels);
  errors.resize(levels.size());
}

void OrganRenderer::Organ::Look(const OrganSnapshot& shape, const Laparoscope& scope) {
  if (shape.vertices.rows() == 0) return;  // where it is, only the card knows
  const Vector3d low = low_W + shape.offset_W, high = high_W + shape.offset_W;
  may_be_seen = scope.MaySee(low, high);
  if (levels.size() < 2 || !may_be_seen) return;
  const double scale = scope.MostPixelsPerMetre(low, high);
  const auto error_of = [&](int level) {
    double& error = errors[static_cast<std::size_t>(level)];
    if (error < 0) {
      error = DeformedError(levels[static_cast<std::size_t>(level)], mesh.copies(), shape.vertices);
    }
    return error;
  };
  mesh.SelectLevel(LevelChoice::After(mesh.level(), levels, scale, error_of));
}

void OrganRenderer::Move(const SceneSnapshot& snapshot, const Laparoscope& scope) {
  HPDM_CHECK(snapshot.organs.size() >= organs_.size());
  for (std::size_t o = 0; o < organs_.size(); ++o) {
    organs_[o].Move(snapshot.organs[o]);
    organs_[o].Look(snapshot.organs[o], scope);
  }
}

void OrganRenderer::DrawDepth() const {
  depth_program_.Use();
  for (const Organ& organ : organs_) {
    if (organ.may_be_seen) organ.mesh.Draw();
  }
}

void OrganRenderer::Draw(const Occlusion* occlusion) const {
  program_.Use();
  detail_.Bind(kDetailUnit);
  if (occlusion != nullptr) {
    occlusion->Bind(kOcclusionUnit);
  } else {
    no_occlusion_.Bind(kOcclusionUnit);
  }
  for (const Organ& organ : organs_) {
    if (!organ.may_be_seen) continue;
    organ.texture.Bind(kBaseTextureUnit);
    glUniform3fv(base_colour_, 1, organ.colour.data());
    glUniform1f(metres_per_uv_, organ.metres_per_uv);
    organ.mesh.Draw();
  }
}

}  // namespace hpdm
