#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <type_traits>

#include "lcmtypes/wire/sample_fields.h"

namespace hpdm {

/// Random values for the logged fields of a sample. Equal seeds give equal values.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}

  double Real() { return std::normal_distribution<double>(0, 1)(engine_); }
  Vector3d Vector() { return {Real(), Real(), Real()}; }

  /// Returns a tick with random values in all its logged fields.
  HapticSample Tick(int tool_count) {
    HapticSample sample;
    sample.tool_count = tool_count;
    const auto fill = [this](int, const FieldInfo& field, auto& value) { Fill(field, value); };
    VisitInput(fill, sample);
    VisitOutput(fill, sample);
    return sample;
  }
  /// Returns a step with random values in all its logged fields, with two attachments and three
  /// ducts where it has organs.
  StepSample Step(int organ_count, int tool_count) {
    StepSample sample;
    sample.organ_count = organ_count;
    sample.attachment_count = organ_count > 0 ? 2 : 0;
    sample.duct_count = organ_count > 0 ? 3 : 0;
    sample.tool_count = tool_count;
    VisitStep([this](int, const FieldInfo& field, auto& value) { Fill(field, value); }, sample);
    return sample;
  }

 private:
  template <typename Value>
  void Fill(const FieldInfo& field, Value& value) {
    if constexpr (std::is_same_v<Value, Isometry3d>) {
      value = Eigen::Translation3d(Vector()) * Eigen::AngleAxisd(Real(), Vector().normalized());
    } else if constexpr (std::is_class_v<Value>) {  // a vector or a matrix
      for (double& x : value.reshaped()) x = Real();
    } else if constexpr (std::is_same_v<Value, double>) {
      value = field.range ? std::uniform_real_distribution<double>(field.range->min,
                                                                   field.range->max)(engine_)
                          : Real();
    } else if constexpr (std::is_same_v<Value, bool>) {
      value = engine_() % 2 == 0;
    } else if (field.range) {
      value = static_cast<Value>(std::uniform_int_distribution<std::int64_t>(
          static_cast<std::int64_t>(field.range->min),
          static_cast<std::int64_t>(field.range->max))(engine_));
    } else {
      value = static_cast<Value>(engine_());
    }
  }

  std::mt19937_64 engine_;
};

/// Expects equal logged values. An orientation that crossed as a quaternion is exact to a rounding.
struct ExpectSameField {
  template <typename Value>
  void operator()(int tool, const FieldInfo& field, const Value& a, const Value& b) const {
    if constexpr (std::is_same_v<Value, Isometry3d>) {
      EXPECT_EQ(a.translation(), b.translation()) << field.name << " of tool " << tool;
      EXPECT_LT((a.linear() - b.linear()).norm(), 1e-14) << field.name << " of tool " << tool;
    } else {
      EXPECT_EQ(a, b) << field.name << " of tool " << tool;
    }
  }
};

inline void ExpectSame(const HapticSample& a, const HapticSample& b) {
  ASSERT_EQ(a.tool_count, b.tool_count);
  VisitInput(ExpectSameField(), a, b);
  VisitOutput(ExpectSameField(), a, b);
}

inline void ExpectSame(const StepSample& a, const StepSample& b) {
  ASSERT_EQ(a.organ_count, b.organ_count);
  ASSERT_EQ(a.attachment_count, b.attachment_count);
  ASSERT_EQ(a.duct_count, b.duct_count);
  ASSERT_EQ(a.tool_count, b.tool_count);
  VisitStep(ExpectSameField(), a, b);
}

}  // namespace hpdm
