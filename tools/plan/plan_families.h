#pragma once

#include <string>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "engine/organ_options.h"

namespace hpdm {

/// Models of one kind from coarse to fine, and how a size becomes an organ's options. `hpdm plan`
/// searches a table of these; a further kind is a further row.
struct PlanFamily {
  enum class Cells {
    kCubes,   ///< Cells as near to cubes as whole numbers allow; the size counts the longest side.
    kEqual,   ///< As many cells along each axis.
    kDegree,  ///< Bernstein: one cell, and the size is its degree.
  };
  std::string name;  ///< Name in the chart's legend.
  Cells cells = Cells::kCubes;
  int degree = 2;
  LocalFunctionOptions local = {.functions = 0};
  bool tight = true;  ///< Margin of 1 % of the organ's longest side; otherwise the author's margin.
  EnergyType energy = EnergyType::kStrain;
  StrainMeasure strain = StrainMeasure::kSmall;
  SolverType solver = SolverType::kCholesky;
  std::vector<int> sizes = {};  ///< Ascending.

  /// True if the stiffness is in pascals. Other models are never chosen, since no modulus of the
  /// scene fits them. The chart shows them pressed to the depth of least error.
  bool Choosable() const { return energy == EnergyType::kStrain; }
};

/// Returns the families; `finite`: the loads need finite strain too.
std::vector<PlanFamily> PlanFamilies(bool finite);

/// Returns the organ's options with the model of a family's member.
OrganOptions MemberOf(const PlanFamily& family, int size, const OrganOptions& organ,
                      const SurfaceMesh& rest);

/// Returns the name that a scene uses.
const char* StrainName(StrainMeasure strain);

/// Describes the model: "quadratic B-spline 6 x 5 x 4 + 27 local (1/2), margin 2 mm".
std::string DescribeModel(const OrganOptions& organ);

/// Estimates the operations of the set-up, so that quick models are searched first.
double SetupWork(const OrganOptions& organ);

}  // namespace hpdm
