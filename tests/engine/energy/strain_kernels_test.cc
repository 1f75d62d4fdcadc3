#include "engine/energy/strain_kernels.h"

#include <gtest/gtest.h>

#include <vector>

#include "engine/energy/hyperelastic.h"

namespace hpdm {
namespace {

constexpr int kBlocks = 3, kFunctions = 5;

// Reproducible numbers of both signs, about 1.
std::vector<Lanes> Numbers(std::size_t count, unsigned seed) {
  std::vector<Lanes> numbers(count);
  std::srand(seed);
  for (Lanes& lanes : numbers) {
    for (double& number : lanes.lane) number = 2.0 * std::rand() / RAND_MAX - 1;
  }
  return numbers;
}

// All results of the kernels, one after the other.
std::vector<double> Results(const StrainKernels& kernels, MaterialLaw material) {
  const StrainLaw law{material, 1700, 3400};
  const std::vector<Lanes> gradients = Numbers(3 * kBlocks * kFunctions, 1);
  const std::vector<Lanes> weights = Numbers(kBlocks, 2), pressure = Numbers(kBlocks, 3);
  std::vector<Lanes> F = Numbers(9 * kBlocks, 4), slope(F), stress(F), theta(kBlocks);
  double U[3 * kFunctions], forces[3 * kFunctions] = {}, stiffness[9 * kFunctions] = {};
  for (int i = 0; i < 3 * kFunctions; ++i) U[i] = 0.1 * (i % 7) - 0.3;
  kernels.add_gradients(gradients.data(), kBlocks, kFunctions, U, F.data());
  kernels.dilate(law, F.data(), kBlocks, theta.data(), slope.data());
  std::vector<double> results = {kernels.stress(law, F.data(), weights.data(), pressure.data(),
                                                theta.data(), slope.data(), kBlocks,
                                                stress.data())};
  kernels.add_forces(gradients.data(), kBlocks, kFunctions, stress.data(), forces);
  const std::vector<Lanes> tangent = Numbers(27 * kBlocks, 5);
  kernels.add_tangents(gradients.data(), tangent.data(), kBlocks, kFunctions, kFunctions - 1,
                       stiffness);
  for (const std::vector<Lanes>* part : {&F, &slope, &theta, &stress}) {
    for (const Lanes& lanes : *part) results.insert(results.end(), lanes.lane, lanes.lane + kLanes);
  }
  results.insert(results.end(), forces, forces + 3 * kFunctions);
  results.insert(results.end(), stiffness, stiffness + 9 * kFunctions);
  return results;
}

constexpr MaterialLaw kLaws[] = {MaterialLaw::kNeoHookean, MaterialLaw::kStVenantKirchhoff};

TEST(StrainKernels, WiderVectorsGiveTheSameBits) {
  for (const MaterialLaw law : kLaws) {
    const std::vector<double> narrow = Results(StrainKernelsFor(VectorWidth::k16Bytes), law);
    for (const VectorWidth width : {VectorWidth::k32Bytes, VectorWidth::k64Bytes}) {
      if (!HasVectors(width)) continue;
      EXPECT_EQ(Results(StrainKernelsFor(width), law), narrow);
    }
  }
}

TEST(StrainKernels, StressAndEnergyAreThoseOfTheLaw) {
  for (const MaterialLaw material : kLaws) {
    const StrainLaw law{material, 1700, 3400};
    const HyperelasticLaw reference(material, {law.mu, law.lambda});
    const StrainKernels& kernels = StrainKernelsFor(WidestVectors());
    const std::vector<Lanes> F = Numbers(9, 6);
    std::vector<Lanes> weights(1), pressure(1), theta(1), slope(9), stress(9);
    for (int lane = 0; lane < kLanes; ++lane) {
      weights[0][lane] = 0.5 + lane;
      pressure[0][lane] = 100 * lane;
    }
    kernels.dilate(law, F.data(), 1, theta.data(), slope.data());
    const double energy = kernels.stress(law, F.data(), weights.data(), pressure.data(),
                                         theta.data(), slope.data(), 1, stress.data());
    double expected_energy = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      Matrix3d at, P;
      for (int k = 0; k < 9; ++k) at.data()[k] = F[k][lane], P.data()[k] = stress[k][lane];
      const Matrix3d expected = weights[0][lane] * reference.Stress(at) +
                                pressure[0][lane] * reference.DilatationGradient(at);
      EXPECT_LT((P - expected).norm(), 1e-13 * expected.norm());  // rounding
      expected_energy += weights[0][lane] * reference.Energy(at);
    }
    EXPECT_NEAR(energy / expected_energy, 1, 1e-13);  // rounding
  }
}

}  // namespace
}  // namespace hpdm
