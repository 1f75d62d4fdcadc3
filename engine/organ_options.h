#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "engine/base/types.h"
#include "engine/organ_motion.h"

/// A scene's organs, validated by the loader (scenes/loader/scene.h), SI units.
namespace hpdm {

enum class BasisType { kBSpline, kBernstein };

/// Finer splines that are added where a load or a tip is. They are the functions nearest to the
/// contact of a B-spline basis with `refinement` times as many cells. Their energy is small strain.
struct LocalFunctionOptions {
  std::optional<int> functions;  ///< Maximum per contact; 0: none; absent: see LocalFunctionsOf.
  int refinement = 2;            ///< Finer cells per lattice cell along each axis, 2..6.
};

/// Functions of finer levels that are added at set-up where the loads of an organ, or presses all
/// over its surface, need them (engine/organ/level_placement.h).
struct AdaptiveOptions {
  int functions = 0;  ///< Number of all functions, with those of `cells`; 0: no finer levels.
  int levels = 2;     ///< Finer levels, 1..2, each with twice the cells of the one before.
};

struct LatticeOptions {
  BasisType basis = BasisType::kBSpline;
  std::array<int, 3> degree = {2, 2, 2};  ///< B-spline: 1..3; Bernstein: 1 or more.
  std::array<int, 3> cells = {4, 4, 4};   ///< B-spline; Bernstein is one cell, {1, 1, 1}.
  double margin = 0.02;                   ///< m, added on every side of the organ's box.
  bool split = true;  ///< Functions of their own for each connected piece of tissue in a function's
                      ///< support (Lattice::SplitByTissue); see SplitsFunctions.
  bool notch_functions =
      true;  ///< Functions of a crack's front at narrow notches; see TakesNotches.
  LocalFunctionOptions local;
  AdaptiveOptions adaptive;
};

enum class EnergyType { kMetric, kStrain };
enum class StrainMeasure { kSmall, kFinite, kAdaptive };
enum class MaterialLaw { kNeoHookean, kStVenantKirchhoff };
enum class SolverType { kCholesky, kGaussSeidel };
enum class EnergyDomain { kBox, kOrgan };

struct EnergyOptions {
  EnergyType type = EnergyType::kStrain;
  StrainMeasure strain = StrainMeasure::kSmall;
  MaterialLaw law = MaterialLaw::kNeoHookean;
  SolverType solver = SolverType::kCholesky;
  EnergyDomain domain = EnergyDomain::kOrgan;  ///< Metric only.
  double alpha = 2000;                         ///< Pa; metric only (finite strain: eta).
  double beta = 0.05;                          ///< N; metric only.
  int newton_iterations = 24;                  ///< Maximum per step; unused in small strain.
  double newton_budget = 0.02;  ///< s per step in the real clock; unused in small strain.
  double finite_from = 0.3;     ///< |grad u| above which adaptive strain uses finite strain; it
                                ///< returns to small strain below 0.8 times that.
};

/// Relaxation of a viscoelastic material by a generalised Maxwell law (maxwell_law.h). Each term is
/// a share g_k of the instantaneous modulus and the time tau_k in which it relaxes.
struct PronySeries {
  static constexpr int kMaxTerms = 3;
  static constexpr double kMaxShare = 0.9;  ///< Largest sum of the shares.
  struct Term {
    double share = 0;  ///< g, above 0.
    double time = 0;   ///< tau, s, 0.001 to 1000.
  };
  int count = 0;  ///< 0: elastic.
  std::array<Term, kMaxTerms> terms{};

  /// Returns the sum of the shares.
  double Share() const {
    double sum = 0;
    for (int k = 0; k < count; ++k) sum += terms[static_cast<std::size_t>(k)].share;
    return sum;
  }
  /// Returns the instantaneous modulus over the long-term one.
  double InstantaneousFactor() const { return 1 / (1 - Share()); }
};

struct MaterialOptions {
  double young = 5000;    ///< Pa, long-term modulus.
  double poisson = 0.45;  ///< 0 <= nu < 0.5.
  double density = 1060;  ///< kg/m^3.
  PronySeries prony = {};
};

struct Box {
  Vector3d min = Vector3d::Zero();
  Vector3d max = Vector3d::Zero();
};
struct Sphere {
  Vector3d centre = Vector3d::Zero();
  double radius = 0;
};
/// A box in fractions (0..1) of the posed organ's axis-aligned bounding box.
struct BoxFraction {
  Vector3d min = Vector3d::Zero();
  Vector3d max = Vector3d::Ones();
};

/// A part of space around an organ, on its posed rest shape.
using Region = std::variant<Box, BoxFraction, Sphere>;

/// Tissue inside the region is held: rigidly, or by a spring per volume. Regions are in the world
/// frame (m), applied to the posed rest shape.
struct SupportOptions {
  Region region;
  std::optional<double> stiffness;  ///< Pa/m^2; absent: fixed.
  bool viscoelastic = false;        ///< The spring relaxes as the organ's tissue does.
};

/// An organ without supports that moves as a whole (free_body.h).
struct FreeOptions {
  double drag = 0;  ///< 1/s: its momentum decays as exp(-drag t).
};

/// A fluid that fills closed lumens of an organ and keeps their volume (tissue/lumen.h).
struct LumenOptions {
  std::optional<Region> region;         ///< The lumens whose walls lie in it; absent: all.
  bool filled = true;                   ///< false: empty, as without these options.
  double bulk_modulus = 2.2e9;          ///< Pa, of the filling: water's.
  double pressure = 0;                  ///< Pa, of the filling at rest over the surroundings.
  double leak_resistance = 4e8;         ///< Pa s/m^3, once it is perforated.
  std::optional<double> perforated_at;  ///< s: then it begins to leak; absent: not by itself.
};

/// A thin membrane on an organ's outer surface, such as a capsule or the peritoneum
/// (energy/fillings_and_layers.h).
struct LayerOptions {
  std::optional<Region> region;    ///< The part of the surface in it; absent: all.
  double stiffness = 0;            ///< N/m: Young's modulus times thickness.
  double poisson = 0.45;           ///< 0 <= nu < 0.5.
  std::optional<double> strength;  ///< N/m: the tension at which it fails; absent: not known.
};

/// Stiffness of the tissue inside the region, at any depth: a tumour, a capsule. If regions
/// overlap, the last one counts.
struct StiffnessRegion {
  Region region;
  double young = 0;  ///< Pa. Energy "metric" scales alpha and beta by young / material.young.
};

/// A blade's edge, from `a` to `b`, at one moment of a cut: world, m, on the posed rest shape.
struct BladeEdge {
  Vector3d a = Vector3d::Zero();
  Vector3d b = Vector3d::Zero();
};

/// A cut that removes no tissue: the surface between consecutive edges of a blade.
struct CutOptions {
  std::string organ;             ///< Name of the organ.
  int number = 0;                ///< Among the scene's cuts, for messages.
  std::vector<BladeEdge> strip;  ///< At least two, none without length.
};

/// A static load: exactly one of force, displacement and pressure is given.
///
/// A force or a displacement acts on a round patch of an organ's surface. Its weight is the kernel
/// cos(pi d / 2R) of the distance d < R to the centre, normalised to one over the surface's area.
/// A pressure acts against the outward rest normal of the whole surface, or of its part in a
/// region.
struct LoadOptions {
  std::string organ;                       ///< Name of the organ.
  Vector3d p_centre_W = Vector3d::Zero();  ///< m, on the posed rest shape; not for a pressure.
  double radius = 0;                       ///< R, m; not for a pressure.
  std::optional<Vector3d> force_W;         ///< N, sum over the patch.
  std::optional<Vector3d> displacement_W;  ///< m, kernel-weighted mean over the patch.
  std::optional<double> pressure;          ///< Pa; negative: a pull.
  std::optional<Region> region;            ///< Pressure only; absent: the whole surface.
};

enum class OrganModelType { kHpdm, kContinuum, kMassSpring, kRigid };

/// Another organ that an organ touches. All others pass through it.
struct OrganContactOptions {
  std::string with;     ///< Name of the other organ.
  double friction = 0;  ///< Coulomb coefficient.
};

struct OrganOptions {
  std::string name;
  std::string mesh;      ///< Path of the mesh file, absolute or relative to the working folder.
  double unit_m = 1;     ///< Metres per unit of the mesh file.
  int subdivisions = 0;  ///< Times that the file's triangles are subdivided (mesh_subdivision.h).
  Isometry3d X_WO = Isometry3d::Identity();  ///< Pose, applied after the unit.
  OrganModelType model = OrganModelType::kHpdm;
  double time_step = 1. / 30;  ///< s, between deformation steps; only kContinuum, kMassSpring and
                               ///< free organs use it, which integrate over time.
  std::optional<double> wall_stiffness;  ///< N/m, kRigid only: the virtual wall's stiffness for
                                         ///< every hand; absent: chosen for each device.
  std::string texture;                   ///< Path, or empty.
  OrganMotion motion;
  Vector3d gravity_W = Vector3d::Zero();  ///< m/s^2, the scene's.
  LatticeOptions lattice;
  EnergyOptions energy;
  MaterialOptions material;
  std::vector<StiffnessRegion> regions;  ///< kHpdm only.
  std::vector<SupportOptions> supports;
  std::vector<LumenOptions> lumens;           ///< See TakesFillingsAndLayers().
  std::vector<LayerOptions> layers;           ///< See TakesFillingsAndLayers().
  std::optional<FreeOptions> free;            ///< Absent: held by its supports; see TakesFree().
  std::vector<OrganContactOptions> contacts;  ///< Each pair stands in one of its two organs.
  std::vector<CutOptions> cuts;               ///< See TakesCuts().
  std::vector<LoadOptions> loads;             ///< The scene's: they place the adaptive functions.
};

inline constexpr int kDefaultLocalFunctions = 27;
inline constexpr double kMaxFineCells = 1e6;  ///< Limit of FineCells(): 100 along each axis.

/// True if the contact problem can hold the organ together with others (Relaxation::body()).
inline bool TakesOrganContacts(const OrganOptions& organ) {
  return organ.model == OrganModelType::kRigid ||
         (organ.model == OrganModelType::kHpdm && organ.energy.solver == SolverType::kCholesky);
}

/// True if the organ can be free: a lattice with the energy "strain" in small strain, elastic, at
/// one place and without supports.
inline bool TakesFree(const OrganOptions& organ) {
  return organ.model == OrganModelType::kHpdm && organ.energy.type == EnergyType::kStrain &&
         organ.energy.strain == StrainMeasure::kSmall &&
         organ.energy.solver == SolverType::kCholesky && organ.supports.empty() &&
         organ.material.prony.count == 0 && organ.motion.displacement_W.isZero(0);
}

/// The remedy for a free organ that TakesFree() refuses.
inline constexpr const char* kFreeRemedy =
    "use model = \"hpdm\", type = \"strain\", strain = \"small\" and solver = \"cholesky\" without "
    "support, motion or prony";

/// True if an organ can have filled lumens and layers: their stiffness is that at rest, a part of the
/// lattice's constant one.
inline bool TakesFillingsAndLayers(const OrganOptions& organ) {
  return organ.model == OrganModelType::kHpdm && organ.energy.type == EnergyType::kStrain &&
         organ.energy.strain == StrainMeasure::kSmall &&
         organ.energy.solver == SolverType::kCholesky && organ.cuts.empty() &&
         organ.lattice.adaptive.functions == 0;
}

/// The remedy for a lumen or a layer that TakesFillingsAndLayers() refuses.
inline constexpr const char* kFillingsAndLayersRemedy =
    "use model = \"hpdm\", type = \"strain\", strain = \"small\" and solver = \"cholesky\" without "
    "cut or adaptive_functions";

/// True if an organ's lumens leak once they are perforated: its tissue does not relax.
inline bool HasLeakingLumens(const OrganOptions& organ) { return organ.material.prony.count == 0; }

/// Returns the number of cells of the finer splines (LocalFunctionOptions).
inline double FineCells(const OrganOptions& organ) {
  double fine_cells = 1;
  for (const int cells : organ.lattice.cells) fine_cells *= cells * organ.lattice.local.refinement;
  return fine_cells;
}

/// True if the model can be cut: B-splines with the energy "strain" in small strain.
inline bool TakesCuts(const OrganOptions& organ) {
  return organ.model == OrganModelType::kHpdm && organ.lattice.basis == BasisType::kBSpline &&
         organ.energy.type == EnergyType::kStrain && organ.energy.strain == StrainMeasure::kSmall;
}

/// The remedy for an organ with a cut that TakesCuts() refuses.
inline constexpr const char* kCutRemedy =
    "use model = \"hpdm\", B-splines, type = \"strain\" and strain = \"small\"";

/// True if the lattice's functions are split by connected tissue: B-splines with an energy over the
/// organ. A Bernstein polynomial spans the whole organ, and the box has no gaps. Cuts need it.
inline bool SplitsFunctions(const OrganOptions& organ) {
  return (organ.lattice.split || !organ.cuts.empty()) && organ.model == OrganModelType::kHpdm &&
         organ.lattice.basis == BasisType::kBSpline &&
         !(organ.energy.type == EnergyType::kMetric && organ.energy.domain == EnergyDomain::kBox);
}

/// True if narrow notches get functions of their own (engine/tissue/notch_finder.h), which are those
/// of a cut's front.
inline bool TakesNotches(const OrganOptions& organ) {
  return organ.lattice.notch_functions && organ.lattice.split && TakesCuts(organ) &&
         organ.lattice.adaptive.functions == 0 && !organ.free && organ.lumens.empty() &&
         organ.layers.empty();
}

/// True if the model can have local functions: they refine B-splines whose stiffness is constant
/// and factorised.
inline bool TakesLocalFunctions(const OrganOptions& organ) {
  return organ.model == OrganModelType::kHpdm && organ.lattice.basis == BasisType::kBSpline &&
         organ.energy.type == EnergyType::kStrain && organ.energy.solver == SolverType::kCholesky;
}

/// True if finer levels can be added (AdaptiveOptions): as for local functions.
inline bool TakesAdaptiveFunctions(const OrganOptions& organ) { return TakesLocalFunctions(organ); }

/// Returns the local functions per contact: the given number, else 27 if the model supports them,
/// else 0.
inline int LocalFunctionsOf(const OrganOptions& organ) {
  const bool taken = TakesLocalFunctions(organ) && FineCells(organ) <= kMaxFineCells;
  return organ.lattice.local.functions.value_or(taken ? kDefaultLocalFunctions : 0);
}

}  // namespace hpdm
