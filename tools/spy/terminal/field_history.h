#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// The values of one channel's newest message, and the history of each number over the last kSpanUs
/// as means over bins of kBinUs. Memory is bounded by kMaxFields. One thread.
class FieldHistory {
 public:
  static constexpr std::int64_t kBinUs = 100'000;
  static constexpr std::size_t kBins = 100;
  static constexpr std::int64_t kSpanUs = kBinUs * static_cast<std::int64_t>(kBins);
  static constexpr std::size_t kMaxFields = 4096;

  struct Field {
    std::string name;  ///< "tools[0].joints[2]".
    std::variant<std::int64_t, double, std::string> value;
    bool present = false;  ///< False if the newest message lacks it (a shorter array).
    double min = 0;        ///< Since Clear; greater than max before the first finite number.
    double max = -1;
    std::string unit = {};  ///< Empty: none.
  };

  void Clear();

  /// Takes a message of `type`; returns false if the bytes are not exactly one.
  bool Add(std::int64_t time_us, const MessageSchemas& schemas, const LcmStruct& type,
           std::span<const std::uint8_t> bytes);

  /// Returns the fields in the order of the message.
  const std::vector<Field>& fields() const { return fields_; }
  /// Returns the number of values of the newest message beyond kMaxFields.
  std::size_t left_out() const { return left_out_; }

  /// Computes the means of a field, `bins_each` bins per column, the newest last. A column without
  /// a message takes its predecessor's mean, or NaN before the first. Columns begin at multiples of
  /// their length, so that a mean does not change while it moves to the left.
  void Curve(std::size_t field, std::size_t bins_each, std::span<double> columns) const;

 private:
  struct Bin {
    double sum = 0;
    std::uint32_t count = 0;
  };

  void MoveTo(std::int64_t bin);
  bool FindField(std::string_view name, std::size_t* at);

  std::vector<Field> fields_;
  std::vector<std::vector<Bin>> bins_;  // by field; a ring
  std::size_t left_out_ = 0;
  bool started_ = false;
  std::int64_t newest_ = 0;  // the newest bin
};

}  // namespace hpdm
