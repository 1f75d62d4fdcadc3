#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "engine/threads/histogram.h"
#include "tools/bench/power_law.h"
#include "tools/shared/timing.h"

namespace hpdm {

/// Ratio of the times of two functions that were timed in turn, round by round.
struct RatioSpread {
  double median = 0;
  double low = 0;   ///< 10 % of the rounds are below this.
  double high = 0;  ///< 10 % of the rounds are above this.
};
RatioSpread RatioOf(const std::vector<double>& slow_us, const std::vector<double>& fast_us);

/// Table 1 of the paper: the surface continuum against a lattice, each pressed by one tip. The
/// second case adds a second organ and tip.
struct ModelComparison {
  std::string lattice;    ///< Description.
  std::string continuum;  ///< How it is stepped.
  bool second_organ = false;
  Timing lattice_step, continuum_step;
  double lattice_residual = 0, continuum_residual = 0;  ///< |K U - B^T f| / |B^T f|.
  RatioSpread ratio;                                    ///< Lattice steps per continuum step.
};
std::vector<ModelComparison> CompareModels(bool quick);

/// Table 2 of the paper: whole deformation steps (collision to publishing) on livers of two sizes.
struct MeshComparison {
  std::string energy;  ///< Energy of the lattice, described.
  int instruments = 0;
  int polygons = 0;  ///< Sum over the instruments, which are posed in every step.
  Timing coarse, fine;
  int coarse_triangles = 0, fine_triangles = 0;
  RatioSpread ratio;  ///< Fine over coarse.
};
std::vector<MeshComparison> CompareMeshes(bool quick);

/// Whole deformation steps of one organ under two instruments, alone and beside others that sleep.
struct SleepResults {
  std::string scene;
  int sleeping = 0;   ///< Number of sleeping organs.
  int triangles = 0;  ///< Sum over the organs.
  Timing among, alone;
  RatioSpread ratio;              ///< Time among the others over time alone.
  std::optional<double> idle_us;  ///< Median time of a step in which all organs sleep.
};
/// Times sleeping organs, and the working folder's scenes/stress.toml if it exists.
std::vector<SleepResults> TimeSleep(bool quick);

/// Cost against size.
struct CostCurve {
  std::string what;
  std::string of;  ///< "vertices" or "control points".
  std::vector<double> size;
  std::vector<double> us;  ///< Minimum time at each size.
  PowerLaw law;            ///< Fitted to the sizes from `fitted_from` up.
  double fitted_from = 0;
};
std::vector<CostCurve> CostOfVertices(bool quick);
std::vector<CostCurve> CostOfControlPoints(bool quick);

/// Wall time of one haptic tick while two tools press and slide with friction, each on one organ or on
/// two. Ticks run at 1 kHz, under the real-time scheduler where it is granted. The steps run in a
/// thread of their own, as in a session.
///
/// Each period runs three things in turn: the tick on a liver of few triangles, the tick on one of
/// many, and a bare loop of arithmetic as long as a tick. Delays that the host adds to the bare
/// loop it also adds to the ticks.
struct TickResults {
  int organs = 1;  ///< That each tool presses. The tools share one.
  int coarse_triangles = 0, fine_triangles = 0;
  Histogram coarse, fine, bare;
  Histogram with_new_patch;  ///< Ticks of both livers that take a new patch.
  RatioSpread ratio;         ///< Fine over coarse, from the medians of blocks of ticks.
};
std::vector<TickResults> TimeTicks(bool quick);

/// Duration of the two sides of a snapshot's hand-over, ns, including the clock readings.
struct HandOverResults {
  std::string snapshot;
  std::size_t bytes = 0;  ///< Size of the snapshot itself, without its arrays.
  Histogram publish, update;
};
std::vector<HandOverResults> TimeHandOvers(bool quick);
/// Returns the median cost of the clock readings included in HandOverResults.
double ClockReadingNanoseconds();

/// Time of a frame, drawn and read back, without the session's other loops. The frames are those of
/// a session's first three seconds.
struct FrameResults {
  std::string scene;
  int triangles = 0;  ///< Sum over the scene's organs.
  int width = 0, height = 0;
  std::string way;  ///< Description of the switched options.
  Histogram frame;  ///< Wall time, ns.
  Histogram cores;  ///< CPU time of all threads of the process, ns: the cost of a software
                    ///< renderer, whatever else runs.
};
/// Times the scenes in the working folder's scenes/; returns no rows if there are none. Throws
/// MachineError if nothing can be drawn.
std::vector<FrameResults> TimeFrames(bool quick);

/// Times of Eq. 4 for the picture, on the CPU and in the vertex shader
/// (render/tissue/lattice_deformation.h).
struct FfdResults {
  std::string lattice;  ///< Description.
  int control_points = 0, triangles = 0;
  Timing step;       ///< CPU, deformation step, single precision: relocation, local functions,
                     ///< indentation.
  Timing upload;     ///< CPU, in the render thread: normals, upload.
  Timing shader;     ///< Render thread: from the upload of the shape to finished vertices and
                     ///< normals.
  double ratio = 0;  ///< Shader over the sum of the CPU times.
};
struct FfdTable {
  std::string renderer;
  std::vector<FfdResults> rows;
};
/// Times FfdResults for lattices and meshes of several sizes. Throws MachineError if the machine
/// has no OpenGL context.
FfdTable TimeFfd(bool quick);

/// The search for what two organs have near each other: the own descent of both trees
/// (SurfaceTree::VisitNear) beside FCL's queries on trees of the same kind.
struct PairSearchResults {
  std::string pair;  ///< The organs, and how they lie.
  int first_triangles = 0, second_triangles = 0;
  int found = 0;                ///< Triangles of the first within the margin of contact, by boxes.
  int fcl_found = 0;            ///< Pairs of triangles that cross each other.
  Timing own;                   ///< Finds `found`.
  Timing fcl_collide;           ///< Finds `fcl_found`; two organs that are apart cross nowhere.
  Timing fcl_distance;          ///< Finds the least distance only.
  Timing own_refit, fcl_refit;  ///< Of the first organ's tree.
};
/// CPU times of whole deformation steps in a session of the scene's own hands.
struct StepTimes {
  std::string scene;        ///< File name.
  Histogram all, touching;  ///< ns; touching: with contacts between organs.
  int most_contacts = 0;    ///< Of one organ with others, in one step.
};
struct OrganResults {
  std::vector<PairSearchResults> searches;
  std::vector<StepTimes> steps;  ///< A scene each.
};
/// Times the organs of abdomen_on_springs.toml and liver_on_stomach.toml, if the working folder has scenes.
std::optional<OrganResults> TimeOrgans(bool quick);

/// The selected measurements of `hpdm bench`; all by default.
struct BenchResults {
  std::vector<ModelComparison> models;
  std::vector<MeshComparison> meshes;
  std::vector<SleepResults> sleep;
  std::vector<CostCurve> costs;
  std::vector<TickResults> ticks;
  double clock_reading_ns = 0;
  std::vector<HandOverResults> hand_overs;
  std::vector<FrameResults> frames;
  std::optional<FfdTable> ffd;
  std::optional<OrganResults> organs;
};

/// Returns one section for each measurement but the organs'.
std::string BenchMarkdown(const BenchResults& results, const std::string& machine);
/// Returns the section of the organs.
std::string OrganMarkdown(const OrganResults& organs, const std::string& machine);

}  // namespace hpdm
