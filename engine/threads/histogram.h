#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace hpdm {

/// Log-linear histogram of durations, 1 ns to 2^63 ns, in 15 kB. It has 32 linear bins in each
/// power of two, so percentiles are exact within 3.2 %. Add is wait-free and allocates nothing. One
/// thread writes; others read only after it has ended.
class Histogram {
 public:
  /// Negative values count as 0.
  void Add(std::int64_t value_ns) {
    const std::uint64_t v = value_ns > 0 ? static_cast<std::uint64_t>(value_ns) : 0;
    ++bins_[Bin(v)];
    ++count_;
    if (v > max_) max_ = v;
    sum_ += static_cast<double>(v);
  }

  /// Adds another's values.
  void Merge(const Histogram& other) {
    for (std::size_t b = 0; b < bins_.size(); ++b) bins_[b] += other.bins_[b];
    count_ += other.count_;
    if (other.max_ > max_) max_ = other.max_;
    sum_ += other.sum_;
  }

  std::uint64_t count() const { return count_; }
  /// Exact, ns.
  std::int64_t max() const { return static_cast<std::int64_t>(max_); }
  /// Exact, ns; 0 without values.
  double mean() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }

  /// Smallest bin bound (ns) that at least `fraction` (0..1) of the values do not exceed, at most
  /// max(); 0 without values.
  std::int64_t Percentile(double fraction) const {
    // The last factor cancels rounding: 0.07 * 100 is above 7 in double.
    const double wanted = fraction * static_cast<double>(count_) * (1 - 1e-12);
    std::uint64_t seen = 0;
    for (std::uint32_t b = 0; b < bins_.size(); ++b) {
      seen += bins_[b];
      if (seen > 0 && static_cast<double>(seen) >= wanted) {
        return static_cast<std::int64_t>(UpperBound(b) < max_ ? UpperBound(b) : max_);
      }
    }
    return max();
  }

  /// Calls visit(largest value of the bin in ns, number of values in it) for each non-empty bin, in
  /// rising order. All histograms have the same bins, so counts of equal bins add up.
  template <typename Visit>
  void ForEachBin(Visit&& visit) const {
    for (std::uint32_t b = 0; b < bins_.size(); ++b) {
      if (bins_[b] > 0) visit(static_cast<std::int64_t>(UpperBound(b)), bins_[b]);
    }
  }

 private:
  static constexpr std::uint32_t kSubBits = 5;
  static constexpr std::uint32_t kSub = 1u << kSubBits;

  static std::uint32_t Bin(std::uint64_t v) {
    if (v < kSub) return static_cast<std::uint32_t>(v);
    const std::uint32_t shift = static_cast<std::uint32_t>(std::bit_width(v)) - 1 - kSubBits;
    return (shift + 1) * kSub + static_cast<std::uint32_t>((v >> shift) - kSub);
  }
  static std::uint64_t UpperBound(std::uint32_t bin) {
    if (bin < kSub) return bin;
    const std::uint32_t shift = bin / kSub - 1;
    const std::uint64_t first = static_cast<std::uint64_t>(kSub + bin % kSub) << shift;
    return first + (std::uint64_t{1} << shift) - 1;
  }

  std::array<std::uint64_t, (64 - kSubBits) * kSub> bins_{};
  std::uint64_t count_ = 0;
  std::uint64_t max_ = 0;
  double sum_ = 0;
};

}  // namespace hpdm
