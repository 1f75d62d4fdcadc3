#include <array>

#include "engine/check.h"
#include "tools/bench_figures.h"
#include "tools/pressed_scene.h"

namespace hpdm {

std::vector<SleepFigures> TimeSleep(bool quick) {
  BenchOrgan liver = MakeBenchOrgan(quick ? "liver_1332" : "liver_5000");
  liver.options.lattice.cells = {6, 6, 6};
  liver.options.lattice.local.functions = 27;
  BenchOrgan other = MakeBenchOrgan(quick ? "liver_274" : "liver_5000");
  PressedScene alone({liver}, 2);
  std::vector<SleepFigures> rows;
  for (const int sleeping : quick ? std::vector{3} : std::vector{1, 3, 11}) {
    std::vector<BenchOrgan> organs = {liver};
    organs.insert(organs.end(), static_cast<std::size_t>(sleeping), other);
    PressedScene among(organs, 2);
    const auto cycle = [](PressedScene* scene) {
      return [scene] {
        scene->Step();
        scene->Step();
      };
    };
    auto times = TimeInTurn({cycle(&among), cycle(&alone)},
                            quick ? RepeatOptions{5, 200, 50} : RepeatOptions{5, 2000, 2000});
    for (std::vector<double>& of_one : times) {
      for (double& time : of_one) time /= 2;
    }
    HPDM_CHECK(among.AllPress() && alone.AllPress());
    // A step of microseconds is below what the clock of a thread resolves: many together.
    constexpr int kMany = 100;
    auto idle = TimeInTurn({[&] {
                             for (int i = 0; i < kMany; ++i) among.StepAway();
                           }},
                           quick ? RepeatOptions{5, 50, 20} : RepeatOptions{5, 500, 300});
    for (double& time : idle[0]) time /= kMany;
    rows.push_back({.sleeping = sleeping,
                    .triangles = among.triangles(),
                    .among = Summary(times[0]),
                    .alone = Summary(times[1]),
                    .ratio = RatioOf(times[0], times[1]),
                    .idle = Summary(idle[0])});
  }
  return rows;
}

}  // namespace hpdm
