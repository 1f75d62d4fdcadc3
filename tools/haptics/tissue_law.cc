#include "tools/haptics/tissue_law.h"

#include <Eigen/QR>
#include <cmath>
#include <numbers>

#include "engine/base/check.h"

namespace hpdm {

std::vector<double> RelaxedForce(const PronySeries& prony, const std::vector<double>& elastic,
                                 double period) {
  // kernel[n]: mean of the decaying part of the kernel over the n-th period back.
  std::vector<double> kernel(elastic.size(), 0);
  for (int k = 0; k < prony.count; ++k) {
    const auto& term = prony.terms[static_cast<std::size_t>(k)];
    const double ratio = term.share / (1 - prony.Share());
    for (std::size_t n = 0; n < kernel.size(); ++n) {
      const auto decayed = [&](double periods) { return std::exp(-periods * period / term.time); };
      const double near = static_cast<double>(n);
      kernel[n] += ratio * (decayed(near) + 4 * decayed(near + 0.5) + decayed(near + 1)) / 6;
    }
  }
  std::vector<double> force = elastic;
  for (std::size_t i = 0; i < force.size(); ++i) {
    for (std::size_t j = 1; j <= i; ++j) {
      force[i] += kernel[i - j] * (elastic[j] - elastic[j - 1]);
    }
  }
  return force;
}

Fundamental FundamentalOf(const std::vector<double>& signal, std::size_t count, double frequency,
                          double period) {
  HPDM_CHECK(count >= 5 && count <= signal.size());
  Eigen::MatrixXd basis(count, 5);
  Eigen::VectorXd values(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t sample = signal.size() - count + i;
    const double angle = 2 * std::numbers::pi * frequency * static_cast<double>(sample) * period;
    const double along = static_cast<double>(i) / static_cast<double>(count);
    const auto row = static_cast<Eigen::Index>(i);
    basis.row(row) << std::sin(angle), std::cos(angle), 1, along, along * along;
    values[row] = signal[sample];
  }
  const Eigen::VectorXd fit = basis.colPivHouseholderQr().solve(values);
  return {std::hypot(fit[0], fit[1]), std::atan2(fit[1], fit[0])};
}

}  // namespace hpdm
