#include "render/tissue/organ_renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <string>

#include "engine/base/check.h"
#include "render/camera/frame_uniforms.h"
#include "render/shader_sources.h"
#include "render/tissue/tissue_detail.h"

namespace hpdm {
namespace {

constexpr const char* kOrganDepthFragment = "void main() {}\n";

constexpr int kBaseTextureUnit = 0;
constexpr int kDetailUnit = 1;
constexpr int kOcclusionUnit = 2;

const Image& White() {
  static const Image white{1, 1, {255, 255, 255}};
  return white;
}

// Returns a deformation of the mesh's vertices and of the copies that seams need.
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

std::string ShadeConstants(const ToolShade& shade) {
  HPDM_CHECK(shade.tools <= kMaxInstruments);
  return "const int kTools = " + std::to_string(shade.tools) +
         ";\nconst bool kShadows = " + (shade.shadows ? "true" : "false") + ";\n";
}

}  // namespace

OrganRenderer::OrganRenderer(const std::vector<OrganVisual>& organs, const ToolShade& shade,
                             bool levels)
    : program_("organ", {glsl::kFrame, glsl::kOrganVertex},
               {glsl::kFrame, glsl::kLight, ShadeConstants(shade).c_str(), glsl::kToolShade,
                glsl::kTissue, glsl::kTissueDetail, glsl::kOrganFragment}),
      depth_program_("organ depth", {glsl::kFrame, glsl::kOrganVertex}, {kOrganDepthFragment}),
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
  if (shape.vertices.rows() == 0) return;  // the shape exists only on the card
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

void OrganRenderer::DrawDepthOf(std::size_t organ) const {
  depth_program_.Use();
  if (organs_[organ].may_be_seen) organs_[organ].mesh.Draw();
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
