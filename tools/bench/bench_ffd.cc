#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <span>

#include "engine/organ.h"
#include "engine/step/tool_geometry.h"
#include "render/camera/picture_target.h"
#include "render/gl/egl_context.h"
#include "render/tissue/lattice_deformation.h"
#include "render/tissue/mesh_renderer.h"
#include "tools/bench/bench_model.h"
#include "tools/bench/bench_results.h"
#include "tools/shared/flat_subdivision.h"

namespace hpdm {
namespace {

// The shape of an organ that one tip presses: arbitrary displacements, plus the local functions and
// an indentation around one point.
class PressedShape {
 public:
  explicit PressedShape(const OrganModel& model)
      : model_(model),
        active_(model.refinement_basis() != nullptr ? model.refinement_basis()->size() : 0,
                model.RefinementSlots(1)),
        U_(1e-3 * Points::Random(model.control_points() + active_.slots(), 3)),
        moved_(model.rest().vertices) {
    const SurfacePoint front = FrontPoint(model.rest(), 0);
    const Vector3d p = front.Position(model.rest().vertices, model.rest().triangles);
    shape_.control_displacements = U_.topRows(model.control_points());
    shape_.local_displacements = U_.bottomRows(active_.slots());
    if (model.refinement_basis() != nullptr) {
      active_.ChooseNearest(model.refinement_basis()->centres(), std::span(&p, 1),
                            LocalFunctionsOf(model.options()));
      for (int s = 0; s < active_.slots(); ++s) {
        const int function = active_.Function(s);
        shape_.local_functions.push_back(
            function < 0 ? -1 : model.refinement_basis()->finer().kept()[function]);
      }
    }
    shape_.indentations[shape_.indentation_count++] =
        AppliedIndentation(model.Indentation(front, kDefaultToolRadius), p, Vector3d(0, 0, -1));
    shape_.vertices = model.rest().vertices.cast<float>();
  }

  // Moves the vertices as a deformation step does.
  void Relocate() {
    model_.relocation().Relocate(U_, &moved_);
    model_.AddLocalDisplacements(active_, U_, &moved_);
    shape_.vertices = moved_.cast<float>();
    model_.AddIndentation(shape_.indentations[0], &shape_.vertices);
  }
  const OrganSnapshot& shape() const { return shape_; }

 private:
  const OrganModel& model_;
  ActiveRefinement active_;
  Points U_, moved_;
  OrganSnapshot shape_;
};

struct FfdLattice {
  const char* words;
  LatticeOptions options;
};

std::vector<FfdLattice> Lattices(bool quick) {
  std::vector<FfdLattice> lattices(4);
  for (FfdLattice& lattice : lattices) lattice.options.local.functions = 0;
  lattices[0].words = "B-spline 4^3";
  lattices[1].words = "B-spline 4^3, 20 local functions";
  lattices[1].options.local.functions = 20;
  lattices[2].words = "B-spline 6^3";
  lattices[2].options.cells = {6, 6, 6};
  lattices[3].words = "Bernstein of degree 4";
  lattices[3].options.basis = BasisType::kBernstein;
  lattices[3].options.degree = {4, 4, 4};
  lattices[3].options.cells = {1, 1, 1};
  if (quick) lattices.resize(2);
  return lattices;
}

FfdResults TimeFfdOf(const FfdLattice& lattice, BenchOrgan organ, bool quick) {
  organ.options.lattice = lattice.options;
  const OrganModel model(organ.options, organ.rest);
  PressedShape pressed(model);
  MeshRenderer uploaded(model.rest()), deformed(model.rest());
  LatticeDeformation deformation(model, model.rest().vertices, model.rest_normals());
  const auto times =
      TimeInTurn({[&] { pressed.Relocate(); },
                  [&] {
                    uploaded.SetVertices(pressed.shape().vertices);
                    glFinish();
                  },
                  [&] {
                    deformation.Deform(pressed.shape(), deformed.positions(), deformed.normals());
                    glFinish();
                  }},
                 quick ? RepeatOptions{5, 100, 60} : RepeatOptions{20, 500, 500});
  FfdResults results{.lattice = lattice.words,
                     .control_points = model.control_points(),
                     .triangles = static_cast<int>(organ.rest.triangles.rows()),
                     .step = Summary(times[0]),
                     .upload = Summary(times[1]),
                     .shader = Summary(times[2]),
                     .ratio = {}};
  results.ratio = results.shader.median_us / (results.step.median_us + results.upload.median_us);
  return results;
}

}  // namespace

FfdTable TimeFfd(bool quick) {
  const EglContext context;
  PictureTarget target(16, 16, 1);
  target.Bind();
  FfdTable table{.renderer = context.renderer(), .rows = {}};
  for (const FfdLattice& lattice : Lattices(quick)) {
    BenchOrgan organ = MakeBenchOrgan("liver_1332");
    for (int size = 0; size < (quick ? 2 : 3); ++size) {
      table.rows.push_back(TimeFfdOf(lattice, organ, quick));
      organ.rest = FlatSubdivided(organ.rest);
    }
  }
  return table;
}

}  // namespace hpdm
