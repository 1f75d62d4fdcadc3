#include "tools/shared/crack_bench.h"

#include <gtest/gtest.h>

#include <utility>

/// Openings of cracks against closed forms, on few functions; `hpdm chart --cracks` has the rest.

namespace hpdm {
namespace {

constexpr double kCrack = 0.02;  // m: one cell

TEST(CrackBench, ACrackOfOneCellOpensAsTheClosedFormSays) {
  // The least that a crack of one cell must give, and the most: the lattice is too stiff, never soft.
  for (const auto& [poisson, least] : {std::pair{0.3, 0.85}, std::pair{0.45, 0.70}}) {
    CrackModelOptions options;
    options.poisson = poisson;
    const CrackOpening crack = EdgeCrack(options, kCrack);
    EXPECT_GT(crack.opening, least) << poisson;
    EXPECT_LT(crack.opening, 1.05) << poisson;
    EXPECT_GT(crack.front_functions, 0);
  }
}

TEST(CrackBench, OpensAcrossTheLatticesCellsAsAlongThem) {
  EXPECT_NEAR(EdgeCrack({}, kCrack, 0.3).opening, EdgeCrack({}, kCrack).opening, 0.05);
}

TEST(CrackBench, HardlyOpensWithoutFrontFunctions) {
  CrackModelOptions options;
  options.fronts = false;
  const CrackOpening crack = EdgeCrack(options, kCrack);
  EXPECT_LT(crack.opening, 0.3);
  EXPECT_EQ(crack.front_functions, 0);
}

}  // namespace
}  // namespace hpdm
