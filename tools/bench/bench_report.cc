#include <algorithm>
#include <cmath>

#include "engine/base/check.h"
#include "tools/bench/bench_results.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

std::string Rate(const Timing& step) { return WithCommas(std::llround(1e6 / step.median_us)); }

std::string Spread(const RatioSpread& ratio) {
  return Format("%.3g (%.3g-%.3g)", ratio.median, ratio.low, ratio.high);
}

// Puts the row with the second organ beside the row without it.
std::string ModelTable(const std::vector<ModelComparison>& rows) {
  std::string text =
      "| lattice | surface continuum | lattice, steps/s | continuum, steps/s | ratio | two organs: "
      "lattice | continuum | ratio | residuals |\n|---|---|---|---|---|---|---|---|---|\n";
  for (const ModelComparison& row : rows) {
    if (row.second_organ) continue;
    const auto both = std::find_if(rows.begin(), rows.end(), [&](const ModelComparison& other) {
      return other.second_organ && other.lattice == row.lattice && other.continuum == row.continuum;
    });
    text += Format("| %s | %s | %s | %s | %s |", row.lattice.c_str(), row.continuum.c_str(),
                   Rate(row.lattice_step).c_str(), Rate(row.continuum_step).c_str(),
                   Spread(row.ratio).c_str());
    text += both == rows.end()
                ? std::string(" - | - | - |")
                : Format(" %s | %s | %s |", Rate(both->lattice_step).c_str(),
                         Rate(both->continuum_step).c_str(), Spread(both->ratio).c_str());
    text += Format(" %.0e / %.0e |\n", row.lattice_residual, row.continuum_residual);
  }
  return text;
}

std::string MeshTable(const std::vector<MeshComparison>& rows) {
  if (rows.empty()) return "";
  std::string text = Format(
      "| lattice | instruments | %s triangles, steps/s | %s triangles, steps/s | ratio of the "
      "times |\n|---|---|---|---|---|\n",
      WithCommas(rows[0].coarse_triangles).c_str(), WithCommas(rows[0].fine_triangles).c_str());
  for (const MeshComparison& row : rows) {
    const std::string instruments = row.instruments == 0
                                        ? std::string("none")
                                        : Format("%d, of %s polygons together", row.instruments,
                                                 WithCommas(row.polygons).c_str());
    text += Format("| %s | %s | %s | %s | %s |\n", row.energy.c_str(), instruments.c_str(),
                   Rate(row.coarse).c_str(), Rate(row.fine).c_str(), Spread(row.ratio).c_str());
  }
  return text;
}

std::string SleepTable(const std::vector<SleepResults>& rows) {
  std::string text =
      "| scene | asleep | triangles in all | touched organ alone | among them | ratio | all asleep "
      "|\n|---|---|---|---|---|---|---|\n";
  for (const SleepResults& row : rows) {
    text +=
        Format("| %s | %d | %s | %.0f / %.0f | %.0f / %.0f | %s | %s |\n", row.scene.c_str(),
               row.sleeping, WithCommas(row.triangles).c_str(), row.alone.minimum_us,
               row.alone.median_us, row.among.minimum_us, row.among.median_us,
               Spread(row.ratio).c_str(), row.idle_us ? Format("%.2f", *row.idle_us).c_str() : "-");
  }
  return text;
}

std::string CostTable(const std::vector<CostCurve>& curves) {
  std::string text =
      "| cost | from | to | exponent | r^2 | fitted from |\n|---|---|---|---|---|---|\n";
  for (const CostCurve& curve : curves) {
    text += Format("| %s | %s %s: %s | %s: %s | %.2f | %.3f | %s |\n", curve.what.c_str(),
                   WithCommas(std::llround(curve.size.front())).c_str(), curve.of.c_str(),
                   Duration(curve.us.front()).c_str(),
                   WithCommas(std::llround(curve.size.back())).c_str(),
                   Duration(curve.us.back()).c_str(), curve.law.exponent, curve.law.r_squared,
                   WithCommas(std::llround(curve.fitted_from)).c_str());
  }
  return text;
}

std::string Microseconds(const Histogram& histogram) {
  const auto us = [](std::int64_t ns) { return static_cast<double>(ns) / 1000; };
  return Format("%.2f | %.2f | %.2f | %.2f", us(histogram.Percentile(0.5)),
                us(histogram.Percentile(0.99)), us(histogram.Percentile(0.999)),
                us(histogram.max()));
}

std::string TickTable(const std::vector<TickResults>& rows) {
  const auto row = [](const std::string& name, const Histogram& histogram) {
    return "| " + name + " | " + Microseconds(histogram) + " |\n";
  };
  std::string text = "| us | median | p99 | p99.9 | max |\n|---|---|---|---|---|\n", ratios;
  for (const TickResults& ticks : rows) {
    const std::string each = ticks.organs == 1 ? "one organ each" : "two organs each";
    const auto of = [&](int triangles) {
      return "tick, " + each + ", " + WithCommas(triangles) + " triangles";
    };
    text += row(of(ticks.coarse_triangles), ticks.coarse) +
            row(of(ticks.fine_triangles), ticks.fine) +
            row("ticks of both that take a new patch", ticks.with_new_patch) +
            row("bare loop of arithmetic", ticks.bare);
    ratios +=
        Format("\nMany triangles over few, %s: %s.\n", each.c_str(), Spread(ticks.ratio).c_str());
  }
  return text + ratios;
}

std::string HandOverTable(const std::vector<HandOverResults>& rows) {
  std::string text =
      "| snapshot | bytes | publish, us: median | p99 | p99.9 | max | update, us: median | p99 | "
      "p99.9 | max |\n|---|---|---|---|---|---|---|---|---|---|\n";
  for (const HandOverResults& row : rows) {
    text += Format("| %s | %s | %s | %s |\n", row.snapshot.c_str(),
                   WithCommas(static_cast<long>(row.bytes)).c_str(),
                   Microseconds(row.publish).c_str(), Microseconds(row.update).c_str());
  }
  return text;
}

std::string FrameTable(const std::vector<FrameResults>& rows) {
  std::string text =
      "| scene | triangles | pixels | drawn | ms: median | p90 | p99 | frames/s | core time, ms |\n"
      "|---|---|---|---|---|---|---|---|---|\n";
  for (const FrameResults& row : rows) {
    const auto ms = [&](double share) {
      return static_cast<double>(row.frame.Percentile(share)) / 1e6;
    };
    text += Format("| %s | %s | %d x %d | %s | %.1f | %.1f | %.1f | %.0f | %.1f |\n",
                   row.scene.c_str(), WithCommas(row.triangles).c_str(), row.width, row.height,
                   row.way.c_str(), ms(0.5), ms(0.9), ms(0.99), 1000 / ms(0.5),
                   static_cast<double>(row.cores.Percentile(0.5)) / 1e6);
  }
  return text;
}

std::string FfdText(const FfdTable& table) {
  std::string text =
      "Free-form deformation of one organ for the picture, one tip pressing, medians in us. The "
      "CPU relocates with local functions and indentation, which a step's collisions need anyway. "
      "The render thread then computes normals and uploads. The shader does everything, from the "
      "upload of the control points to finished vertices and normals. " +
      table.renderer +
      ".\n\n| lattice | control points | triangles | CPU: relocate | CPU: normals, upload | shader "
      "| shader over CPU |\n|---|---|---|---|---|---|---|\n";
  for (const FfdResults& row : table.rows) {
    text += Format("| %s | %d | %s | %.0f | %.0f | %.0f | %.2f |\n", row.lattice.c_str(),
                   row.control_points, WithCommas(row.triangles).c_str(), row.step.median_us,
                   row.upload.median_us, row.shader.median_us, row.ratio);
  }
  return text;
}

}  // namespace

RatioSpread RatioOf(const std::vector<double>& slow_us, const std::vector<double>& fast_us) {
  HPDM_CHECK(!slow_us.empty() && slow_us.size() == fast_us.size());
  std::vector<double> ratios(slow_us.size());
  for (std::size_t i = 0; i < ratios.size(); ++i) ratios[i] = slow_us[i] / fast_us[i];
  std::sort(ratios.begin(), ratios.end());
  const auto at = [&](double share) {
    return ratios[static_cast<std::size_t>(std::lround(share * double(ratios.size() - 1)))];
  };
  return {at(0.5), at(0.1), at(0.9)};
}

std::string BenchMarkdown(const BenchResults& results, const std::string& machine) {
  std::string text;
  if (!results.models.empty()) {
    text +=
        "The paper's Table 1: deformation steps per second under a tip's press, without and with a "
        "second organ under a second tip. A step is reposition, relax, relocate; figures are "
        "medians. Ratios are of steps timed in turn, with 10 and 90 % in brackets. The residual is "
        "|K U - B^T f| / |B^T f|.\n\n" +
        ModelTable(results.models) + "\n";
  }
  if (!results.meshes.empty()) {
    text +=
        "The paper's Table 2: whole deformation steps per second (collide to publish) under "
        "pressing instruments. Without an instrument the organ sleeps.\n\n" +
        MeshTable(results.meshes) + "\n";
  }
  if (!results.sleep.empty()) {
    text +=
        "Whole deformation steps of a liver under two instruments, beside organs that nothing "
        "touches, us: minimum and median. Ratios are of steps timed in turn, with 10 and 90 % in "
        "brackets.\n\n" +
        SleepTable(results.sleep) + "\n";
  }
  if (!results.costs.empty()) {
    text +=
        "Cost against size: minima. Exponents are fitted by least squares in log-log to the sizes "
        "from \"fitted from\" up.\n\n" +
        CostTable(results.costs) + "\n";
  }
  if (!results.ticks.empty()) {
    text +=
        "One haptic tick at 1 kHz, two tools pressing and sliding with friction on one organ or on "
        "two "
        "each, wall time. The "
        "bare loop is as long as a tick and runs in the same periods: it shows what the host adds. "
        "Ratios are of the medians of blocks of 100 ticks, with 10 and 90 % in brackets.\n\n" +
        TickTable(results.ticks) + "\n";
  }
  if (!results.hand_overs.empty()) {
    text += Format(
                "A snapshot's hand-over between two threads: one publishes every 2 us, the other "
                "polls. Times include reading the clock, %.0f ns.\n\n",
                results.clock_reading_ns) +
            HandOverTable(results.hand_overs) + "\n";
  }
  if (!results.frames.empty()) {
    text +=
        "A frame of the laparoscope's picture, drawn and read back, without the other loops, wall "
        "time. The ways of drawing take turns on the same snapshots.\n\n" +
        FrameTable(results.frames) + "\n";
  }
  if (results.ffd.has_value()) text += FfdText(*results.ffd) + "\n";
  return text + "Times: " + machine + ".\n";
}

std::string OrganMarkdown(const OrganResults& organs, const std::string& machine) {
  std::string text =
      "Search of two organs of abdomen_on_springs.toml for each other, us: minimum and median. The "
      "own "
      "descent finds the triangles within 2 mm of the other organ. FCL finds crossing triangles, "
      "or the least distance.\n\n| organs | triangles | found | own | FCL: collide | its pairs | "
      "FCL: distance | own refit | FCL: refit |\n|---|---|---|---|---|---|---|---|---|\n";
  const auto time = [](const Timing& timing) {
    return Format("%.1f, %.1f", timing.minimum_us, timing.median_us);
  };
  for (const PairSearchResults& row : organs.searches) {
    text += Format("| %s | %s, %s | %d | %s | %s | %d | %s | %s | %s |\n", row.pair.c_str(),
                   WithCommas(row.first_triangles).c_str(),
                   WithCommas(row.second_triangles).c_str(), row.found, time(row.own).c_str(),
                   time(row.fcl_collide).c_str(), row.fcl_found, time(row.fcl_distance).c_str(),
                   time(row.own_refit).c_str(), time(row.fcl_refit).c_str());
  }
  text +=
      "\nDeformation steps in lockstep under the scene's own hands, CPU time, ms. Contacts: most "
      "of one organ with others in a step. Target: p99 at most 10 ms.\n\n"
      "| scene | steps | number | contacts | median | p99 | largest |\n"
      "|---|---|---|---|---|---|---|\n";
  const auto ms = [](std::int64_t ns) { return 1e-6 * static_cast<double>(ns); };
  for (const StepTimes& row : organs.steps) {
    for (const auto& [name, steps] :
         {std::pair("all", &row.all), std::pair("organs touch", &row.touching)}) {
      if (steps->count() == 0) continue;
      text += Format("| %s | %s | %d | %d | %.2f | %.2f | %.2f |\n", row.scene.c_str(), name,
                     static_cast<int>(steps->count()), row.most_contacts,
                     ms(steps->Percentile(0.5)), ms(steps->Percentile(0.99)), ms(steps->max()));
    }
  }
  return text + "\nTimes: " + machine + ".\n";
}

}  // namespace hpdm
