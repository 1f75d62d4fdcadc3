#include <algorithm>
#include <string_view>

#include "scenes/loader/scene_keys.h"
#include "scenes/loader/scene_parts.h"

namespace hpdm {
namespace {

// Binomial coefficients of this degree are exact in double. (30 + 1)^3 control points are far more
// than a step can solve.
constexpr int kMaxBernsteinDegree = 30;
constexpr int kMaxCells = 64;
constexpr int kMaxSubdivisions = 5;
constexpr int kMaxLocalFunctions = 250;
constexpr int kMaxLocalRefinement = 6;
constexpr int kMaxAdaptiveFunctions = 2000;
constexpr int kMaxAdaptiveLevels = 2;
constexpr double kMaxAdaptiveCells = 64.0 * 64 * 64;

void ReadUnit(const TableReader& table, double* unit_m) {
  constexpr double kMaxUnit = 1000;
  if (!table.HasString("unit")) {
    table.ReadNumber("unit", Interval::Positive(kMaxUnit, "metres per unit"), unit_m);
    return;
  }
  constexpr std::pair<std::string_view, double> kUnits[] = {{"m", 1.0}, {"mm", 1e-3}};
  table.ReadChoice("unit", kUnits, unit_m, "give \"m\", \"mm\" or metres per unit as a number");
}

Isometry3d ReadPose(const TableReader& table) {
  Vector3d position = Vector3d::Zero();
  Matrix3d rotation = Matrix3d::Identity();
  table.ReadVector("position", kCoordinate, &position);
  ReadRotation(table, "rotation_deg", &rotation);
  Isometry3d X_WO = Isometry3d::Identity();
  X_WO.linear() = rotation;
  X_WO.translation() = position;
  return X_WO;
}

LatticeOptions ReadLattice(const TableReader& table) {
  LatticeOptions lattice;
  table.ReadChoice("basis",
                   {{"bspline", BasisType::kBSpline}, {"bernstein", BasisType::kBernstein}},
                   &lattice.basis);
  const bool bspline = lattice.basis == BasisType::kBSpline;
  table.ReadIntegers("degree", 1, bspline ? 3 : kMaxBernsteinDegree, &lattice.degree);
  if (!bspline) {
    if (table.Has("cells")) {
      table.Fail("cells", "needs basis = \"bspline\"",
                 "remove it: a Bernstein lattice is one cell");
    }
    lattice.cells = {1, 1, 1};
  }
  table.ReadIntegers("cells", 1, kMaxCells, &lattice.cells);
  table.ReadNumber("margin", Interval::NotNegative(1, "m"), &lattice.margin);
  for (const char* key : {"split", "notch_functions"}) {
    if (!bspline && table.Has(key)) table.Fail(key, "needs basis = \"bspline\"", "remove it");
  }
  table.ReadBoolean("split", &lattice.split);
  table.ReadBoolean("notch_functions", &lattice.notch_functions);
  int functions = 0;
  if (table.ReadInteger("local_functions", 0, kMaxLocalFunctions, &functions)) {
    lattice.local.functions = functions;
  }
  table.ReadInteger("local_refinement", 2, kMaxLocalRefinement, &lattice.local.refinement);
  table.ReadInteger("adaptive_functions", 0, kMaxAdaptiveFunctions, &lattice.adaptive.functions);
  table.ReadInteger("adaptive_levels", 1, kMaxAdaptiveLevels, &lattice.adaptive.levels);
  return lattice;
}

// Finer levels need splines with a constant, factorised stiffness, as local functions do.
void CheckAdaptiveKeys(const TableReader& lattice, const OrganOptions& organ) {
  const AdaptiveOptions& adaptive = organ.lattice.adaptive;
  if (adaptive.functions == 0) return;
  const auto refuse = [&lattice](const char* needs) {
    lattice.Fail("adaptive_functions", std::string("needs ") + needs, "change that or give 0");
  };
  if (organ.model != OrganModelType::kHpdm) refuse("model = \"hpdm\"");
  if (organ.lattice.basis != BasisType::kBSpline) refuse("basis = \"bspline\"");
  if (organ.energy.type != EnergyType::kStrain) refuse("energy.type = \"strain\"");
  if (organ.energy.solver != SolverType::kCholesky) refuse("energy.solver = \"cholesky\"");
  double cells = 1;
  for (const int along : organ.lattice.cells) cells *= along << adaptive.levels;
  if (cells > kMaxAdaptiveCells) {
    lattice.Fail("adaptive_levels", "makes more than 262,144 cells on the finest level",
                 "give fewer cells or levels");
  }
}

// Local functions need splines with a constant, factorised stiffness.
void CheckLocalFunctionKeys(const TableReader& lattice, const OrganOptions& organ) {
  const bool too_fine = FineCells(organ) > kMaxFineCells;
  if (too_fine && !organ.lattice.local.functions && lattice.Has("local_refinement") &&
      TakesLocalFunctions(organ)) {
    lattice.Fail("local_refinement", "makes more than a million cells",
                 "give fewer cells, a lower local_refinement or local_functions = 0");
  }
  if (organ.lattice.local.functions.value_or(0) == 0) return;
  if (too_fine) {
    lattice.Fail("local_functions", "refines more than a million cells",
                 "give fewer cells or a lower local_refinement");
  }
  const auto refuse = [&lattice](const char* needs) {
    lattice.Fail("local_functions", std::string("needs ") + needs, "change that or give 0");
  };
  if (organ.lattice.basis != BasisType::kBSpline) refuse("basis = \"bspline\"");
  if (organ.energy.type != EnergyType::kStrain) refuse("energy.type = \"strain\"");
  if (organ.energy.solver != SolverType::kCholesky) refuse("energy.solver = \"cholesky\"");
}

EnergyOptions ReadEnergy(const TableReader& table) {
  EnergyOptions energy;
  table.ReadChoice("type", {{"metric", EnergyType::kMetric}, {"strain", EnergyType::kStrain}},
                   &energy.type);
  const bool metric = energy.type == EnergyType::kMetric;
  for (const std::string_view key : {"domain", "alpha", "beta"}) {
    if (!metric && table.Has(key)) {
      table.Fail(key, "needs type = \"metric\"", "remove it or give that type");
    }
  }
  if (metric && table.Has("law")) {
    table.Fail("law", "needs type = \"strain\"", "remove it or change the type");
  }
  table.ReadChoice("strain",
                   {{"small", StrainMeasure::kSmall},
                    {"finite", StrainMeasure::kFinite},
                    {"adaptive", StrainMeasure::kAdaptive}},
                   &energy.strain);
  table.ReadChoice(
      "law", {{"neo_hookean", MaterialLaw::kNeoHookean}, {"stvk", MaterialLaw::kStVenantKirchhoff}},
      &energy.law);
  table.ReadChoice(
      "solver", {{"cholesky", SolverType::kCholesky}, {"gauss_seidel", SolverType::kGaussSeidel}},
      &energy.solver);
  table.ReadChoice("domain", {{"box", EnergyDomain::kBox}, {"organ", EnergyDomain::kOrgan}},
                   &energy.domain);
  for (const std::string_view key : {"newton_iterations", "newton_budget"}) {
    if (energy.strain == StrainMeasure::kSmall && table.Has(key)) {
      table.Fail(key, "needs strain = \"finite\" or \"adaptive\"",
                 "remove it or change the strain");
    }
  }
  if (energy.strain != StrainMeasure::kAdaptive && table.Has("finite_from")) {
    table.Fail("finite_from", "needs strain = \"adaptive\"", "remove it or change the strain");
  }
  table.ReadInteger("newton_iterations", 1, 1000, &energy.newton_iterations);
  table.ReadNumber("newton_budget", Interval::NotNegative(10, "s"), &energy.newton_budget);
  table.ReadNumber("finite_from", {.min = 0, .max = 10, .above_min = true}, &energy.finite_from);
  // alpha is above zero because beta alone gives linear maps no energy. Fixed supports scale with
  // alpha.
  table.ReadNumber("alpha", Interval::Positive(1e12, "Pa"), &energy.alpha);
  table.ReadNumber("beta", Interval::NotNegative(1e12, "N"), &energy.beta);
  return energy;
}

void ReadProny(const TableReader& table, PronySeries* prony) {
  for (const TableReader& read : table.Tables("prony", kPronyKeys, PronySeries::kMaxTerms)) {
    PronySeries::Term& term = prony->terms[static_cast<std::size_t>(prony->count++)];
    read.Require("share", "give the share of the instantaneous modulus that relaxes");
    read.Require("time", "give the time in which it relaxes, in s");
    read.ReadNumber("share", {.min = 0.001, .max = PronySeries::kMaxShare}, &term.share);
    read.ReadNumber("time", {.min = 0.001, .max = 1000, .unit = "s"}, &term.time);
    constexpr double kRoundOff = 1e-9;
    if (prony->Share() > PronySeries::kMaxShare + kRoundOff) {
      read.Fail("share", "makes the sum of the shares exceed 0.9",
                "give smaller shares: young, the modulus that remains, is at least a tenth of the "
                "instantaneous one");
    }
  }
}

MaterialOptions ReadMaterial(const TableReader& table) {
  MaterialOptions material;
  table.ReadNumber("young", Interval::Positive(1e12, "Pa"), &material.young);
  table.ReadNumber("poisson", {.min = 0, .max = 0.5, .below_max = true}, &material.poisson);
  table.ReadNumber("density", Interval::Positive(30000, "kg/m^3"), &material.density);
  ReadProny(table, &material.prony);
  double relaxation_time = 0;
  table.ReadNumber("relaxation_time", Interval::NotNegative(1000, "s"), &relaxation_time);
  table.RefuseOthers(
      "relaxation_time", {0}, "was replaced by Prony terms",
      "remove the key; [[organ.material.prony]] share = 0.5, time = 0.3 relaxes half "
      "of the force in 0.3 s");
  return material;
}

void ReadCorners(const TableReader& table, const Interval& range, Vector3d* min, Vector3d* max) {
  for (const std::string_view key : {"min", "max"}) table.Require(key, "give both corners");
  table.ReadVector("min", range, min);
  table.ReadVector("max", range, max);
  if (!(min->array() < max->array()).all()) {
    table.Fail("max", "is not above min in every coordinate", "give a box with a volume");
  }
}

StiffnessRegion ReadStiffnessRegion(const TableReader& table) {
  StiffnessRegion stiffer;
  const std::optional<Region> region = ReadRegion(table);
  if (!region) table.Fail("has no region", "give box, box_fraction or sphere");
  stiffer.region = *region;
  table.Require("young", "give the tissue's Young's modulus there in Pa");
  table.ReadNumber("young", Interval::Positive(1e12, "Pa"), &stiffer.young);
  return stiffer;
}

OrganMotion ReadMotion(const TableReader& table) {
  OrganMotion motion;
  table.Require("displacement", "give the stroke as [x, y, z] in m");
  table.ReadVector("displacement", Interval::Within(0.1, "m"), &motion.displacement_W);
  table.Require("frequency", "give it in Hz; 0.25 is a breath in four seconds");
  table.ReadNumber("frequency", Interval::NotNegative(10, "Hz"), &motion.frequency);
  return motion;
}

FreeOptions ReadFree(const TableReader& table) {
  FreeOptions free;
  table.Require("drag", "give it in 1/s; a fall under 9.81 m/s^2 ends at 9.81 / drag m/s");
  table.ReadNumber("drag", Interval::NotNegative(1000, "1/s"), &free.drag);
  return free;
}

SupportOptions ReadSupport(const TableReader& table) {
  SupportOptions support;
  const std::optional<Region> region = ReadRegion(table);
  if (!region) table.Fail("has no region", "give box, box_fraction or sphere");
  support.region = *region;

  table.RefuseBoth("fixed", "stiffness");
  bool fixed = false;
  table.ReadBoolean("fixed", &fixed);
  table.RefuseOthers("fixed", {1}, "gives a support without effect",
                     "give fixed = true, or stiffness instead of it");
  double stiffness = 0;
  if (table.ReadNumber("stiffness", Interval::Positive(1e15, "Pa/m^2"), &stiffness)) {
    support.stiffness = stiffness;
  } else if (!fixed) {
    table.Fail("has neither fixed nor stiffness", "give fixed = true or stiffness");
  }
  table.RefuseBoth("fixed", "viscoelastic");
  table.ReadBoolean("viscoelastic", &support.viscoelastic);
  return support;
}

/// Fails at the first key that the organ's model does not take.
void RefuseKeysOfOtherModels(const TableReader& table, OrganModelType model) {
  const bool rigid = model == OrganModelType::kRigid;
  if (model != OrganModelType::kHpdm) {
    for (const std::string_view key : {"lattice", "energy", "region", "lumen", "layer"}) {
      if (!table.Has(key)) continue;
      table.Fail(key, "needs model = \"hpdm\"", "remove the table or change the model");
    }
  }
  for (const std::string_view key : {"material", "support"}) {
    if (!rigid || !table.Has(key)) continue;
    table.Fail(key, "does not apply to model = \"rigid\"", "remove the table or change the model");
  }
  if (!rigid && table.Has("wall_stiffness")) {
    table.Fail("wall_stiffness", "needs model = \"rigid\"", "remove it or change the model");
  }
}

}  // namespace

std::optional<Region> ReadRegion(const TableReader& table) {
  table.RefuseBoth("box", "box_fraction");
  table.RefuseBoth("box", "sphere");
  table.RefuseBoth("box_fraction", "sphere");
  if (const auto box = table.Table("box", kBoxKeys)) {
    Box region;
    ReadCorners(*box, kCoordinate, &region.min, &region.max);
    return region;
  }
  if (const auto fraction = table.Table("box_fraction", kBoxKeys)) {
    BoxFraction region;
    ReadCorners(*fraction, {.min = 0, .max = 1}, &region.min, &region.max);
    return region;
  }
  if (const auto sphere = table.Table("sphere", kSphereKeys)) {
    Sphere region;
    sphere->Require("centre", "give it as [x, y, z] in m");
    sphere->Require("radius", "give it in m");
    sphere->ReadVector("centre", kCoordinate, &region.centre);
    sphere->ReadNumber("radius", Interval::Positive(kMaxCoordinate, "m"), &region.radius);
    return region;
  }
  return std::nullopt;
}

OrganOptions ReadOrgan(const TableReader& table) {
  OrganOptions organ;
  table.Require("name", "name the organ");
  table.ReadName("name", &organ.name);
  table.Require("mesh", "name a mesh file (OBJ, STL or PLY)");
  table.ReadFile("mesh", &organ.mesh);
  ReadUnit(table, &organ.unit_m);
  table.ReadInteger("subdivisions", 0, kMaxSubdivisions, &organ.subdivisions);
  table.ReadChoice("model",
                   {{"hpdm", OrganModelType::kHpdm},
                    {"continuum", OrganModelType::kContinuum},
                    {"mass_spring", OrganModelType::kMassSpring},
                    {"rigid", OrganModelType::kRigid}},
                   &organ.model);
  RefuseKeysOfOtherModels(table, organ.model);
  double wall_stiffness = 0;
  if (table.ReadNumber("wall_stiffness", Interval::Positive(1e6, "N/m"), &wall_stiffness)) {
    organ.wall_stiffness = wall_stiffness;
  }
  table.ReadFile("texture", &organ.texture);
  if (const auto pose = table.Table("pose", kPoseKeys)) organ.X_WO = ReadPose(*pose);
  if (const auto motion = table.Table("motion", kMotionKeys)) organ.motion = ReadMotion(*motion);
  if (const auto lattice = table.Table("lattice", kLatticeKeys)) {
    organ.lattice = ReadLattice(*lattice);
  }
  if (const auto energy = table.Table("energy", kEnergyKeys)) organ.energy = ReadEnergy(*energy);
  if (const auto lattice = table.Table("lattice", kLatticeKeys)) {
    CheckLocalFunctionKeys(*lattice, organ);
    CheckAdaptiveKeys(*lattice, organ);
  }
  if (const auto material = table.Table("material", kMaterialKeys)) {
    organ.material = ReadMaterial(*material);
    if (organ.model != OrganModelType::kHpdm && material->Has("prony")) {
      material->Fail("prony", "needs model = \"hpdm\"",
                     "remove it: the model has a damping of its own");
    }
    if (organ.energy.solver == SolverType::kGaussSeidel && material->Has("prony")) {
      material->Fail("prony", "needs energy.solver = \"cholesky\"",
                     "remove it or change the solver");
    }
  }
  for (const TableReader& region : table.Tables("region", kRegionKeys)) {
    organ.regions.push_back(ReadStiffnessRegion(region));
  }
  for (const TableReader& support : table.Tables("support", kSupportKeys)) {
    organ.supports.push_back(ReadSupport(support));
  }
  organ.lumens = ReadLumens(table);
  organ.layers = ReadLayers(table);
  for (const std::string_view key : {"lumen", "layer"}) {
    if (!table.Has(key) || TakesFillingsAndLayers(organ)) continue;
    table.Fail(key, "does not apply to this organ", kFillingsAndLayersRemedy);
  }
  if (const auto free = table.Table("free", kFreeKeys)) {
    organ.free = ReadFree(*free);
    if (!TakesFree(organ)) table.Fail("free", "does not apply to this organ", kFreeRemedy);
  }
  for (const LumenOptions& lumen : organ.lumens) {
    if (!lumen.perforated_at || HasLeakingLumens(organ)) continue;
    table.Fail("lumen", "has perforated_at, but lumens of viscoelastic tissue stay closed",
               "remove perforated_at or material.prony");
  }
  return organ;
}

void ReadContact(const TableReader& table, std::vector<OrganOptions>* organs) {
  OrganOptions* pair[2] = {};
  for (const int k : {0, 1}) {
    const std::string_view key = k == 0 ? "a" : "b";
    std::string name;
    table.Require(key, "name the two organs that touch as a and b");
    table.ReadString(key, &name);
    RequireOrgan(table, key, name, *organs);
    const auto named = std::find_if(organs->begin(), organs->end(),
                                    [&](const OrganOptions& organ) { return organ.name == name; });
    pair[k] = &*named;
    if (TakesOrganContacts(*named)) continue;
    table.Fail(key, "touches no other organ with its model or solver",
               "use model = \"hpdm\" with solver = \"cholesky\", or model = \"rigid\"");
  }
  if (pair[0] == pair[1]) table.Fail("b", "is the same organ as a", "name another organ");
  const auto is_rigid = [](const OrganOptions* organ) {
    return organ->model == OrganModelType::kRigid;
  };
  if (is_rigid(pair[0]) && is_rigid(pair[1])) {
    table.Fail("b", "is rigid, as a is", "name at least one organ that deforms");
  }
  for (const int k : {0, 1}) {
    for (const OrganContactOptions& other : pair[k]->contacts) {
      if (other.with == pair[1 - k]->name)
        table.Fail("b", "is in a contact with a already", "give each pair one [[contact]]");
    }
  }
  OrganContactOptions contact{pair[1]->name, 0};
  table.ReadNumber("friction", {.min = 0, .max = 2}, &contact.friction);
  pair[0]->contacts.push_back(contact);
}

void ReadCut(const TableReader& table, int number, std::vector<OrganOptions>* organs) {
  CutOptions cut;
  cut.number = number;
  table.Require("organ", "name the organ that is cut");
  table.ReadString("organ", &cut.organ);
  RequireOrgan(table, "organ", cut.organ, *organs);
  OrganOptions& organ =
      *std::find_if(organs->begin(), organs->end(),
                    [&](const OrganOptions& each) { return each.name == cut.organ; });
  if (!TakesCuts(organ)) table.Fail("organ", "cannot be cut", kCutRemedy);
  if (organ.lattice.adaptive.functions > 0) {
    table.Fail("organ", "has adaptive functions", "remove them or the cut");
  }
  if (!organ.lumens.empty() || !organ.layers.empty()) {
    table.Fail("organ", "has a lumen or a layer", "remove them or the cut");
  }
  table.Require("strip", "give the blade's edges as [[[x, y, z], [x, y, z]], ...] in m");
  std::vector<std::array<Vector3d, 2>> edges;
  table.ReadEdges("strip", kCoordinate, kMaxBladeEdges, &edges);
  for (const auto& [a, b] : edges) cut.strip.push_back({a, b});
  organ.cuts.push_back(std::move(cut));
}

LoadOptions ReadLoad(const TableReader& table, const std::vector<OrganOptions>& organs) {
  LoadOptions load;
  table.Require("organ", "name the organ that the load acts on");
  table.ReadString("organ", &load.organ);
  RequireOrgan(table, "organ", load.organ, organs);
  for (const std::string_view other : {"force", "displacement", "point", "radius"}) {
    table.RefuseBoth(other, "pressure");
  }
  double pressure = 0;
  if (table.ReadNumber("pressure", Interval::Within(1e9, "Pa"), &pressure)) {
    load.pressure = pressure;
    load.region = ReadRegion(table);
    return load;
  }
  for (const std::string_view key : {"box", "box_fraction", "sphere"}) {
    if (table.Has(key)) {
      table.Fail(key, "needs pressure", "remove it or give pressure");
    }
  }
  table.Require("point", "give the load's centre as [x, y, z] in m");
  table.ReadVector("point", kCoordinate, &load.p_centre_W);
  table.Require("radius", "give the radius of the loaded surface in m");
  table.ReadNumber("radius", Interval::Positive(kMaxCoordinate, "m"), &load.radius);
  table.RefuseBoth("force", "displacement");
  Vector3d value = Vector3d::Zero();
  if (table.ReadVector("force", Interval::Within(1e6, "N"), &value)) {
    load.force_W = value;
  } else if (table.ReadVector("displacement", kCoordinate, &value)) {
    load.displacement_W = value;
  } else {
    table.Fail("has no load", "give force or displacement as [x, y, z], or pressure");
  }
  return load;
}

}  // namespace hpdm
