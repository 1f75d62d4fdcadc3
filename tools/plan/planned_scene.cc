#include "engine/base/error.h"
#include "scenes/loader/scene_edit.h"
#include "tools/plan/plan_families.h"
#include "tools/plan/scene_plan.h"

namespace hpdm {
namespace {

bool SameLattice(const LatticeOptions& a, const LatticeOptions& b) {
  return a.basis == b.basis && a.degree == b.degree && a.cells == b.cells && a.margin == b.margin &&
         a.local.functions == b.local.functions &&
         (a.local.functions == 0 || a.local.refinement == b.local.refinement);
}

bool SameEnergy(const EnergyOptions& a, const EnergyOptions& b) {
  return a.type == b.type && a.strain == b.strain && a.solver == b.solver;
}

// Returns the edits from an author's organ to the chosen model. They include the energy's type and
// the number of local functions in any case, so that no default replaces them. Keys that the model
// does not take are named too: they become comments in the author's scene.
OrganEdit EditsOf(std::size_t organ, const OrganOptions& author, const OrganOptions& chosen) {
  OrganEdit edit{.organ = organ, .keys = {}, .removed_tables = {}};
  const auto set = [&edit](const char* table, const char* key, bool changed, SceneValue value) {
    if (changed) edit.keys.push_back({table, key, std::move(value)});
  };
  const LatticeOptions &was = author.lattice, &is = chosen.lattice;
  const bool spline = is.basis == BasisType::kBSpline;
  set("", "model", author.model != chosen.model, "hpdm");
  set("lattice", "basis", was.basis != is.basis, spline ? "bspline" : "bernstein");
  set("lattice", "degree", was.degree != is.degree, is.degree[0]);
  if (spline) {
    set("lattice", "cells", was.cells != is.cells, is.cells);
  } else {
    for (const char* key : {"cells", "split", "notch_functions"}) {
      set("lattice", key, true, std::monostate());
    }
  }
  set("lattice", "margin", was.margin != is.margin, is.margin);
  set("lattice", "local_functions", true, LocalFunctionsOf(chosen));
  if (LocalFunctionsOf(chosen) > 0) {
    set("lattice", "local_refinement", was.local.refinement != is.local.refinement,
        is.local.refinement);
  }
  if (was.adaptive.functions != 0) {  // the compared lattices are uniform
    set("lattice", "adaptive_functions", true, std::monostate());
    set("lattice", "adaptive_levels", true, std::monostate());
  }
  const EnergyOptions &had = author.energy, &has = chosen.energy;
  set("energy", "type", true, "strain");
  set("energy", "strain", had.strain != has.strain, StrainName(has.strain));
  set("energy", "solver", had.solver != has.solver,
      has.solver == SolverType::kCholesky ? "cholesky" : "gauss_seidel");
  for (const char* key : {"domain", "alpha", "beta"}) set("energy", key, true, std::monostate());
  if (has.strain == StrainMeasure::kSmall) {
    for (const char* key : {"newton_iterations", "newton_budget"}) {
      set("energy", key, true, std::monostate());
    }
  }
  if (has.strain != StrainMeasure::kAdaptive) set("energy", "finite_from", true, std::monostate());
  return edit;
}

}  // namespace

std::string PlannedScene(const Scene& scene, const ScenePlan& plan,
                         const std::filesystem::path& folder) {
  std::vector<OrganEdit> edits;
  for (std::size_t o = 0; o < plan.organs.size(); ++o) {
    const OrganPlan& organ = plan.organs[o];
    if (organ.fate == OrganFate::kRigid) {
      edits.push_back({.organ = o,
                       .keys = {{"", "model", "rigid"}},
                       .removed_tables = {"lattice", "energy", "material", "region", "lumen",
                                          "layer", "support"}});
    } else if (organ.fate == OrganFate::kSearched) {
      edits.push_back(EditsOf(o, scene.organs[o], organ.points[*plan.of_error->points[o]].model));
    }
  }
  return MovedScene(scene, EditedScene(scene, edits), folder);
}

void CheckPlannedScene(const std::string& text, const std::filesystem::path& path,
                       const ScenePlan& plan) {
  const Scene scene = ParseScene(text, path);
  for (std::size_t o = 0; o < plan.organs.size(); ++o) {
    const OrganPlan& organ = plan.organs[o];
    bool same = organ.fate != OrganFate::kRigid || scene.organs[o].model == OrganModelType::kRigid;
    if (organ.fate == OrganFate::kSearched) {
      const OrganOptions& chosen = organ.points[*plan.of_error->points[o]].model;
      same = scene.organs[o].model == chosen.model &&
             SameLattice(scene.organs[o].lattice, chosen.lattice) &&
             SameEnergy(scene.organs[o].energy, chosen.energy);
    }
    if (same) continue;
    throw InputError(path.string() + ": organ \"" + organ.name +
                     "\" is written in a form that cannot be changed in place; write its tables "
                     "as [organ.lattice] and [organ.energy]");
  }
}

}  // namespace hpdm
