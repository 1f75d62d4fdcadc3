#include "tools/chart/level_table.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/baselines/surface_error.h"
#include "scenes/generator/meshing/obj_writer.h"
#include "tools/chart/static_case_model.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

// Functions over those of the lattice that the levels are added to.
constexpr std::array<double, 3> kMoreFunctions = {1.4, 2, 3};
constexpr int kMostFunctions = 1100;  // finer lattices are left out

std::array<int, 3> Scaled(const std::array<int, 3>& cells, double factor) {
  std::array<int, 3> scaled;
  for (std::size_t d = 0; d < 3; ++d) {
    scaled[d] = std::max(1, static_cast<int>(std::lround(factor * cells[d])));
  }
  return scaled;
}

class LevelTable {
 public:
  explicit LevelTable(const std::function<void(const std::string&)>& say) : say_(say) {}

  void Measure(const LevelCase& of, bool quick) {
    uniform_.clear();
    const std::array<int, 3> own = of.load_case.organ.lattice.cells;
    const bool coarse = own[0] * own[1] * own[2] <= 100;  // there is room for finer uniform ones
    const double first = coarse ? 1 : 0.5, last = coarse ? 2.5 : 1.5;
    for (double factor = first; factor <= last; factor += quick ? 0.5 : 0.25) {
      if (!MeasureOne(of, Scaled(own, factor), 0)) break;
    }
    for (const double factor : {first, 1.5 * first}) {
      const std::array<int, 3> cells = Scaled(own, factor);
      for (const double more : kMoreFunctions) {
        if (quick && more != 2) continue;
        MeasureOne(of, cells, more);
      }
    }
  }
  const std::string& text() const { return text_; }

 private:
  // `more`: functions over those of the uniform lattice; 0: that lattice. False if it is too fine.
  bool MeasureOne(const LevelCase& of, const std::array<int, 3>& cells, double more) {
    OrganOptions options = of.load_case.organ;
    options.lattice.cells = cells;
    options.lattice.local.functions = 0;
    if (more > 0) options.lattice.adaptive = {static_cast<int>(more * Functions(cells)), 2};
    StaticCaseModel body(of.load_case, options);
    if (!body.Balance()) return false;
    const StaticCaseModel::StepTimes times = body.TimeSteps();
    const double error = RelativeSurfaceError(of.load_case.rest, body.VertexDisplacements(),
                                              of.reference.displacements);
    std::string levels, functions, estimate;
    if (more == 0) {
      uniform_.emplace_back(body.unknowns(), error);
      functions_.push_back({cells, body.unknowns()});
    } else {
      const LatticeOrgan& organ = *body.lattice_organ()->lattice_organ();
      for (const Lattice& level : organ.lattice().levels()) {
        levels += Format(" + %d", level.size());
      }
      const double needed = UniformFunctions(uniform_, error);
      functions = needed > 0 ? Format("%.0f (%.2f)", needed, body.unknowns() / needed)
                             : Format("above %.0f", uniform_.back().first);
      estimate = Format("%.1f %%", 100 * organ.error_of_levels().value());
    }
    const std::string row =
        Format("| `%s` | %d x %d x %d | %d%s | %.1f %% | %s | %s | %.2f s | %.2f ms |\n",
               CaseName(of.load_case).c_str(), cells[0], cells[1], cells[2], body.unknowns(),
               levels.empty() ? "" : (" (" + levels.substr(3) + " finer)").c_str(), 100 * error,
               functions.c_str(), estimate.c_str(), body.setup_ms() / 1000,
               times.response.median_us / 1000);
    say_(row.substr(0, row.size() - 1));
    text_ += row;
    return body.unknowns() < kMostFunctions;
  }

  // Returns the functions of the uniform lattice with these cells, which has been measured or is
  // measured now.
  int Functions(const std::array<int, 3>& cells) const {
    for (const auto& [measured, functions] : functions_) {
      if (measured == cells) return functions;
    }
    return 0;
  }

  const std::function<void(const std::string&)>& say_;
  std::vector<std::pair<double, double>> uniform_;  // functions, error
  std::vector<std::pair<std::array<int, 3>, int>> functions_;
  std::string text_ =
      "| case | cells | functions | error | a uniform lattice needs (ratio) | estimate | set-up | "
      "step |\n|---|---|---|---|---|---|---|---|\n";
};

}  // namespace

double UniformFunctions(const std::vector<std::pair<double, double>>& uniform, double error) {
  for (std::size_t i = 0; i < uniform.size(); ++i) {
    if (uniform[i].second > error) continue;
    if (i == 0) return uniform[0].first;
    const auto& [n0, e0] = uniform[i - 1];
    const auto& [n1, e1] = uniform[i];
    const double share = std::log(e0 / error) / std::log(e0 / e1);
    return n0 * std::pow(n1 / n0, share);
  }
  return 0;
}

void MeasureLevels(const std::vector<LevelCase>& cases, const std::filesystem::path& folder,
                   bool quick, const std::function<void(const std::string&)>& say) {
  LevelTable table(say);
  for (const LevelCase& each : cases) table.Measure(each, quick);
  WriteTextFile(folder / "levels.md", table.text());
}

}  // namespace hpdm
