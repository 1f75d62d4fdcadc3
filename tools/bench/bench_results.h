#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "engine/threads/histogram.h"
#include "tools/bench/power_law.h"
#include "tools/shared/timing.h"

namespace hpdm {

/// How many times as long one thing takes as another that was timed in turn with it: the ratios of
/// the rounds.
struct RatioSpread {
  double median = 0;
  double low = 0;   ///< 10 % of the rounds are below,
  double high = 0;  ///< 10 % above.
};
RatioSpread RatioOf(const std::vector<double>& slow_us, const std::vector<double>& fast_us);

/// Table 1 of the paper: the surface continuum against a lattice, each pressed by a tip, without
/// and with a second organ (and tip).
struct ModelComparison {
  std::string lattice;    ///< In words.
  std::string continuum;  ///< How it is stepped.
  bool second_organ = false;
  Timing lattice_step, continuum_step;
  double lattice_residual = 0, continuum_residual = 0;  ///< |K U - B^T f| / |B^T f|.
  RatioSpread ratio;                                    ///< Lattice steps a continuum step.
};
std::vector<ModelComparison> CompareModels(bool quick);

/// Table 2: whole deformation steps (collision to publishing) on livers of two sizes.
struct MeshComparison {
  std::string energy;  ///< Of the lattice, in words.
  int instruments = 0;
  int polygons = 0;  ///< Of all instruments, posed in every step.
  Timing coarse, fine;
  int coarse_triangles = 0, fine_triangles = 0;
  RatioSpread ratio;  ///< Fine over coarse.
};
std::vector<MeshComparison> CompareMeshes(bool quick);

/// Whole deformation steps of one organ under two instruments, alone and beside others that sleep.
struct SleepResults {
  std::string scene;
  int sleeping = 0;   ///< Organs.
  int triangles = 0;  ///< Of all organs.
  Timing among, alone;
  RatioSpread ratio;              ///< Among over alone.
  std::optional<double> idle_us;  ///< A step in which all organs sleep, median.
};
/// With the working folder's scenes/stress.toml, where it is.
std::vector<SleepResults> TimeSleep(bool quick);

/// Cost against size.
struct CostCurve {
  std::string what;
  std::string of;  ///< "vertices" or "control points".
  std::vector<double> size;
  std::vector<double> us;  ///< Minima.
  PowerLaw law;            ///< Of the sizes from `fitted_from` on.
  double fitted_from = 0;
};
std::vector<CostCurve> CostOfVertices(bool quick);
std::vector<CostCurve> CostOfControlPoints(bool quick);

/// Wall time of one haptic tick, two tools pressing and sliding on one liver, at 1 kHz under the
/// real-time scheduler where it is granted; the same tick on a liver of few and of many triangles
/// and a bare loop of arithmetic as long as a tick, in turn in the same periods: what the host adds
/// to the bare loop it adds to the ticks.
struct TickResults {
  int coarse_triangles = 0, fine_triangles = 0;
  Histogram coarse, fine, bare;
  Histogram with_new_patch;  ///< Ticks of both that take the patch of a step.
  RatioSpread ratio;         ///< Fine over coarse: of the medians of blocks of ticks.
};
TickResults TimeTicks(bool quick);

/// Duration of the two sides of a snapshot's hand-over, ns, readings of the clock included.
struct HandOverResults {
  std::string snapshot;
  std::size_t bytes = 0;  ///< Of the snapshot itself, without its arrays.
  Histogram publish, update;
};
std::vector<HandOverResults> TimeHandOvers(bool quick);
/// What the clock's own readings take of it, median.
double ClockReadingNanoseconds();

/// Time of a frame, drawn and read back, without the session's other loops; the pictures of a
/// session's first three seconds.
struct FrameResults {
  std::string scene;
  int triangles = 0;  ///< Of its organs.
  int width = 0, height = 0;
  std::string way;  ///< What was switched off or on.
  Histogram frame;  ///< Wall time, ns.
  Histogram cores;  ///< Of all the process's threads, ns: what a software renderer takes from the
                    ///< cores, whoever else uses them.
};
/// Of the scenes in the working folder's scenes/ (none there: no rows). Throws MachineError where
/// nothing can be drawn.
std::vector<FrameResults> TimeFrames(bool quick);

/// Eq. 4 for the picture, on the CPU and in the vertex shader
/// (render/tissue/lattice_deformation.h).
struct FfdResults {
  std::string lattice;  ///< In words.
  int control_points = 0, triangles = 0;
  Timing step;       ///< CPU, in the step: relocation, local functions, indentation, single
                     ///< precision.
  Timing upload;     ///< CPU, in the render thread: normals, upload.
  Timing shader;     ///< Render thread, upload of the shape to finished vertices and normals.
  double ratio = 0;  ///< Shader over both of the CPU's.
};
struct FfdTable {
  std::string renderer;
  std::vector<FfdResults> rows;
};
/// Throws MachineError where nothing can be drawn.
FfdTable TimeFfd(bool quick);

/// What `hpdm bench` measures: everything, or what was asked for.
struct BenchResults {
  std::vector<ModelComparison> models;
  std::vector<MeshComparison> meshes;
  std::vector<SleepResults> sleep;
  std::vector<CostCurve> costs;
  std::optional<TickResults> ticks;
  double clock_reading_ns = 0;
  std::vector<HandOverResults> hand_overs;
  std::vector<FrameResults> frames;
  std::optional<FfdTable> ffd;
};

/// A section for each that was measured.
std::string BenchMarkdown(const BenchResults& results, const std::string& machine);

}  // namespace hpdm
