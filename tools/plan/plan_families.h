#pragma once

#include <string>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "engine/organ_options.h"

namespace hpdm {

/// Models of one kind from coarse to fine, and how a size becomes an organ's options: the table
/// that `hpdm plan` searches. A further kind is a further row.
struct PlanFamily {
  enum class Cells {
    kCubes,   ///< As near to cubes as whole numbers allow; the size is that of the longest side.
    kEqual,   ///< As many along each axis.
    kDegree,  ///< Bernstein: one cell, the size is its degree.
  };
  std::string name;  ///< For the chart's legend.
  Cells cells = Cells::kCubes;
  int degree = 2;
  LocalFunctionOptions local = {.functions = 0};
  bool tight = true;  ///< Margin of a hundredth of the organ's longest side; else the author's.
  EnergyType energy = EnergyType::kStrain;
  StrainMeasure strain = StrainMeasure::kSmall;
  SolverType solver = SolverType::kCholesky;
  std::vector<int> sizes = {};  ///< Ascending.

  /// Its stiffness is in pascals. What is not is shown in the chart, pressed as deep as makes its
  /// error least, and never chosen: no modulus of the scene would make it so.
  bool Choosable() const { return energy == EnergyType::kStrain; }
};

/// `finite`: the loads ask for finite strain too.
std::vector<PlanFamily> PlanFamilies(bool finite);

/// The organ's options with the model of a family's member.
OrganOptions MemberOf(const PlanFamily& family, int size, const OrganOptions& organ,
                      const SurfaceMesh& rest);

/// As a scene writes it.
const char* StrainName(StrainMeasure strain);

/// In words: "quadratic B-spline 6 x 5 x 4 + 27 local (1/2), margin 2 mm".
std::string DescribeModel(const OrganOptions& organ);

/// Roughly, of the set-up: operations, to search the quick ones first.
double SetupWork(const OrganOptions& organ);

}  // namespace hpdm
