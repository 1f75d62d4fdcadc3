#include "tools/spy/terminal/field_history.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hpdm {
namespace {

std::size_t InRing(std::int64_t bin) {
  constexpr auto kCount = static_cast<std::int64_t>(FieldHistory::kBins);
  return static_cast<std::size_t>((bin % kCount + kCount) % kCount);
}

}  // namespace

void FieldHistory::Clear() { *this = {}; }

/// Empties the bins between the last message and `bin`.
void FieldHistory::MoveTo(std::int64_t bin) {
  constexpr auto kCount = static_cast<std::int64_t>(kBins);
  // A jump back or forward by more than the span restarts the history.
  const bool restart = !started_ || bin < newest_ - kCount || bin > newest_ + kCount;
  const std::int64_t from = restart ? bin - kCount : newest_;
  for (std::int64_t b = from + 1; b <= bin; ++b) {
    for (std::vector<Bin>& bins : bins_) bins[InRing(b)] = {};
  }
  newest_ = restart ? bin : std::max(newest_, bin);
  started_ = true;
}

/// Finds the field `name` from `at` on, or inserts it there. Returns false if there is no room.
bool FieldHistory::FindField(std::string_view name, std::size_t* at) {
  if (*at < fields_.size() && fields_[*at].name == name) return true;
  const auto begin = fields_.begin() + static_cast<std::ptrdiff_t>(*at);
  const auto found =
      std::find_if(begin, fields_.end(), [name](const Field& field) { return field.name == name; });
  if (found != fields_.end()) {
    *at = static_cast<std::size_t>(found - fields_.begin());
    return true;
  }
  if (fields_.size() >= kMaxFields) return false;
  fields_.insert(begin, Field{std::string(name), {}, false});
  bins_.insert(bins_.begin() + static_cast<std::ptrdiff_t>(*at), std::vector<Bin>(kBins));
  return true;
}

bool FieldHistory::Add(std::int64_t time_us, const MessageSchemas& schemas, const LcmStruct& type,
                       std::span<const std::uint8_t> bytes) {
  MoveTo(time_us / kBinUs);
  for (Field& field : fields_) field.present = false;
  left_out_ = 0;
  std::size_t at = 0;
  return schemas.Decode(type, bytes, [&](const MessageValue& value) {
    if (!FindField(value.name, &at)) {
      ++left_out_;
      return;
    }
    Field& field = fields_[at];
    field.present = true;
    if (field.unit.empty()) field.unit = value.unit;
    std::vector<Bin>& bins = bins_[at++];
    if (const auto* text = std::get_if<std::string_view>(&value.value)) {
      constexpr std::size_t kMaxText = 512;
      field.value = std::string(text->substr(0, kMaxText));
      return;
    }
    double number = 0;
    if (const auto* integer = std::get_if<std::int64_t>(&value.value)) {
      field.value = *integer;
      number = static_cast<double>(*integer);
    } else {
      number = std::get<double>(value.value);
      field.value = number;
    }
    if (!std::isfinite(number)) return;
    if (field.min > field.max) field.min = field.max = number;
    field.min = std::min(field.min, number);
    field.max = std::max(field.max, number);
    Bin& bin = bins[InRing(newest_)];
    bin.sum += number;
    ++bin.count;
  });
}

void FieldHistory::Curve(std::size_t field, std::size_t bins_each,
                         std::span<double> columns) const {
  const std::vector<Bin>& bins = bins_[field];
  const auto each = static_cast<std::int64_t>(bins_each);
  const std::int64_t oldest = newest_ - static_cast<std::int64_t>(kBins) + 1;
  const std::int64_t newest_column = (newest_ >= 0 ? newest_ : newest_ - each + 1) / each;
  std::int64_t column = newest_column - static_cast<std::int64_t>(columns.size()) + 1;
  double held = std::numeric_limits<double>::quiet_NaN();
  for (double& mean : columns) {
    Bin all;
    const std::int64_t end = std::min((column + 1) * each - 1, newest_);
    for (std::int64_t b = std::max(column * each, oldest); b <= end; ++b) {
      all.sum += bins[InRing(b)].sum;
      all.count += bins[InRing(b)].count;
    }
    if (all.count > 0) held = all.sum / all.count;
    mean = held;
    ++column;
  }
}

}  // namespace hpdm
