#include "tools/chart/crack_table.h"

#include "scenes/generator/meshing/obj_writer.h"
#include "tools/shared/crack_bench.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

class CrackTable {
 public:
  explicit CrackTable(const std::function<void(const std::string&)>& say) : say_(say) {}

  /// Adds a row. `value`: over the closed form.
  void Add(const std::string& body, double cell, double poisson, int functions, double value,
           const std::string& target) {
    const std::string row = Format("| %s | %.4g | %.2f | %d | %.3f | %s |\n", body.c_str(),
                                   1000 * cell, poisson, functions, value, target.c_str());
    say_(row.substr(0, row.size() - 1));
    text_ += row;
  }
  const std::string& text() const { return text_; }

 private:
  const std::function<void(const std::string&)>& say_;
  std::string text_ =
      "| body | cell, mm | nu | functions | over the closed form | target |\n"
      "|---|---|---|---|---|---|\n";
};

constexpr double kCrack = 0.02;  // m: half of the strip's width

void AddEdgeCracks(bool quick, CrackTable* table) {
  for (const double poisson : {0.3, 0.45}) {
    const bool stiff = poisson > 0.4;
    for (const int cells : {1, 2, 4}) {
      if (quick && cells > 1) continue;
      CrackModelOptions options;
      options.cell = kCrack / cells;
      options.poisson = poisson;
      const char* target = cells == 1   ? (stiff ? ">= .70" : ">= .85")
                           : cells == 2 ? (stiff ? ">= .85" : ">= .90")
                                        : (stiff ? ">= .92" : ">= .95");
      for (const bool fronts : {true, false}) {
        options.fronts = fronts;
        const CrackOpening found = EdgeCrack(options, kCrack);
        table->Add(std::string("edge crack, opening of its mouth") +
                       (fronts ? "" : ", without front functions"),
                   options.cell, poisson, found.functions, found.opening, fronts ? target : "");
      }
    }
  }
  for (const double turn : {0.3, 0.7854}) {
    const CrackOpening found = EdgeCrack({}, kCrack, turn);
    table->Add(Format("the same, turned by %.0f degrees against the lattice", turn * 57.29578),
               0.02, 0.3, found.functions, found.opening, ">= .85");
  }
  for (int mm = 18; mm <= 22 && !quick; ++mm) {
    CrackModelOptions options;
    options.cell = 0.01;
    table->Add(Format("energy released from %d to %d mm", mm, mm + 1), options.cell,
               options.poisson, EdgeCrack(options, mm * 1e-3).functions,
               EdgeCrackRelease(options, mm * 1e-3, 1e-3), "within 8 %, steps of 3 %");
  }
}

}  // namespace

void MeasureCracks(const std::filesystem::path& folder, bool quick,
                   const std::function<void(const std::string&)>& say) {
  CrackTable table(say);
  AddEdgeCracks(quick, &table);
  for (const double poisson : {0.3, 0.45}) {
    if (quick) break;
    CrackModelOptions options;
    options.poisson = poisson;
    const CrackOpening found = PennyCrack(options);
    table.Add("penny crack in a cube of 5 radii, opening at its centre", options.cell, poisson,
              found.functions, found.opening, "1 to 1.15");
  }
  for (const double a_over_h : {5.0, 8.0}) {
    if (quick) break;
    CrackModelOptions options;
    options.cell = 0.01;
    const DoubleCantileverRatios found = DoubleCantilever(options, a_over_h);
    const std::string body = Format("double cantilever, a = %.0f h, ", a_over_h);
    table.Add(body + "compliance", options.cell, options.poisson, found.functions, found.compliance,
              "within 5 %");
    table.Add(body + "energy released", options.cell, options.poisson, found.functions,
              found.release, "within 8 %");
  }
  WriteTextFile(folder / "cracks.md", table.text());
}

}  // namespace hpdm
