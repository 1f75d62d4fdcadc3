#include "tools/spy/terminal/field_list_view.h"

#include <algorithm>
#include <cmath>

#include "tools/spy/terminal/spy_text.h"

namespace hpdm {
namespace {

constexpr int kValueWidth = 13;
constexpr int kUnitWidth = 6;
constexpr int kRangeWidth = 10;

/// Returns the member of the message that a field belongs to: "tools" for "tools[0].joints[2]".
std::string_view Group(std::string_view name) { return name.substr(0, name.find_first_of("[.")); }

std::string ValueText(const FieldHistory::Field& field, int width) {
  if (!field.present) return "-";
  if (const auto* text = std::get_if<std::string>(&field.value)) return Printable(*text);
  if (const auto* integer = std::get_if<std::int64_t>(&field.value)) {
    return NumberText(*integer, width);
  }
  return NumberText(std::get<double>(field.value), width);
}

std::string Sparkline(const FieldHistory& history, std::size_t field, int width,
                      const Glyphs& glyphs) {
  std::vector<double> columns(static_cast<std::size_t>(width));
  history.Curve(field, FieldHistory::kBins / columns.size(), columns);
  double low = INFINITY, high = -INFINITY;
  for (const double value : columns) {
    if (std::isnan(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  std::string line;
  for (const double value : columns) {
    if (std::isnan(value)) {
      line += ' ';
    } else if (high - low > 0) {
      const double share = (value - low) / (high - low);
      line += glyphs.bars[std::min(7, static_cast<int>(8 * share))];
    } else {
      line += glyphs.bars[0];
    }
  }
  return line;
}

struct Layout {
  int name, spark;
  bool unit, range;
};
Layout LayoutFor(int columns) {
  Layout layout{};
  layout.unit = columns >= 50;
  layout.range = columns >= 76;
  // The widths divide the number of bins, so that every column has equally many.
  static_assert(FieldHistory::kBins == 100);
  for (const int width : {5, 10, 20, 25, 50}) {
    if (width == 5 || width <= columns / 5) layout.spark = width;
  }
  layout.name = columns - (kValueWidth + 1) - (layout.unit ? kUnitWidth + 1 : 0) -
                (layout.spark + 1) - (layout.range ? 2 * (kRangeWidth + 1) : 0);
  return layout;
}

std::string HeaderText(const Layout& layout, const Glyphs& glyphs) {
  std::string header = FitLeft("FIELD", layout.name, glyphs) + ' ' + FitRight("VALUE", kValueWidth);
  if (layout.unit) header += ' ' + FitLeft("UNIT", kUnitWidth, glyphs);
  if (layout.range) {
    header += ' ' + FitRight("MIN", kRangeWidth) + ' ' + FitRight("MAX", kRangeWidth);
  }
  const auto span = static_cast<double>(FieldHistory::kSpanUs);
  return header + Format(" LAST %.0f s", 1e-6 * span);
}

/// Draws a single field: its name and value, and for a number its range and sparkline.
void DrawField(TerminalScreen* screen, const FieldHistory& history, std::size_t index,
               const Layout& layout, int line, TextStyle style) {
  const Glyphs& glyphs = screen->glyphs();
  const FieldHistory::Field& field = history.fields()[index];
  const auto style_or = [style](TextStyle plain) {
    return style == TextStyle::kPlain ? plain : style;
  };
  screen->Put(line, 0, FitLeftKeepingEnd(Printable(field.name), layout.name, glyphs), style);
  int column = layout.name + 1;
  if (std::holds_alternative<std::string>(field.value)) {
    screen->Put(line, column, ValueText(field, kValueWidth), style);
    return;
  }
  screen->Put(line, column, FitRight(ValueText(field, kValueWidth), kValueWidth), style);
  column += kValueWidth + 1;
  if (layout.unit) {
    screen->Put(line, column, FitLeft(Printable(field.unit), kUnitWidth, glyphs),
                style_or(TextStyle::kDim));
    column += kUnitWidth + 1;
  }
  if (field.max < field.min) return;
  if (layout.range) {
    const auto bound = [&](double value) {
      return FitRight(NumberText(value, kRangeWidth + 1), kRangeWidth);
    };
    screen->Put(line, column, bound(field.min) + ' ' + bound(field.max), style_or(TextStyle::kDim));
    column += 2 * (kRangeWidth + 1);
  }
  screen->Put(line, column, Sparkline(history, index, layout.spark, glyphs),
              style_or(TextStyle::kAccent));
}

}  // namespace

void FieldListView::Reset() { *this = {}; }

void FieldListView::SetFilter(const std::string& filter) { filter_ = filter; }

void FieldListView::Arrange(const FieldHistory& history) {
  rows_.clear();
  groups_.clear();
  const std::vector<FieldHistory::Field>& fields = history.fields();
  for (std::size_t begin = 0; begin < fields.size();) {
    const std::string group(Group(fields[begin].name));
    std::size_t end = begin;
    while (end < fields.size() && Group(fields[end].name) == group) ++end;
    const bool foldable = end - begin > kFoldedFrom && filter_.empty();
    if (foldable) {
      rows_.push_back({begin, end - begin});
      groups_.push_back(group);
    }
    for (std::size_t f = begin; f < end && (!foldable || opened_.contains(group)); ++f) {
      if (!HasInIt(fields[f].name, filter_)) continue;
      rows_.push_back({f, 0});
      groups_.push_back(group);
    }
    begin = end;
  }
}

void FieldListView::DrawGroup(TerminalScreen* screen, std::size_t row, int line,
                              TextStyle style) const {
  const bool open = opened_.contains(groups_[row]);
  const Glyphs& glyphs = screen->glyphs();
  screen->Put(line, 0,
              std::string(open ? glyphs.open : glyphs.closed) + ' ' + groups_[row] + ": " +
                  WithCommas(static_cast<long long>(rows_[row].fields)) + " values" +
                  (open ? "" : " (Enter shows them)"),
              style);
}

void FieldListView::Draw(TerminalScreen* screen, const FieldHistory& history, int top, int height) {
  Arrange(history);
  const Layout layout = LayoutFor(screen->columns());
  height_ = std::max(1, height - 1);
  cursor_.Fit(static_cast<int>(rows_.size()), height_);

  screen->Put(top, 0, HeaderText(layout, screen->glyphs()), TextStyle::kBold);

  for (int i = 0; i < height_; ++i) {
    const auto at = static_cast<std::size_t>(cursor_.top + i);
    if (at >= rows_.size()) break;
    const int line = top + 1 + i;
    const bool chosen = cursor_.top + i == cursor_.selected;
    const TextStyle style = chosen ? TextStyle::kSelected : TextStyle::kPlain;
    if (chosen) screen->Fill(line, style);
    if (rows_[at].fields > 0) {
      DrawGroup(screen, at, line, style);
    } else {
      DrawField(screen, history, rows_[at].field, layout, line, style);
    }
  }
  if (rows_.empty()) screen->Put(top + 2, 2, "No name matches the filter.", TextStyle::kDim);
  if (history.left_out() > 0 && static_cast<int>(rows_.size()) - cursor_.top < height_) {
    screen->Put(top + 1 + static_cast<int>(rows_.size()) - cursor_.top, 0,
                "and " + WithCommas(static_cast<long long>(history.left_out())) +
                    " more values: use hpdm log export",
                TextStyle::kDim);
  }
}

bool FieldListView::Handle(int key, const FieldHistory& history) {
  Arrange(history);  // several keys may come between two pictures
  const auto at = static_cast<std::size_t>(std::max(0, cursor_.selected));
  if (key == kTerminalKeyEnter && at < rows_.size()) {
    // Opens or closes the group, on its own row or on a row of its values.
    const std::string group = groups_[at];
    if (opened_.contains(group)) {
      opened_.erase(group);
      while (cursor_.selected > 0 &&
             groups_[static_cast<std::size_t>(cursor_.selected - 1)] == group) {
        --cursor_.selected;
      }
    } else if (rows_[at].fields > 0) {
      opened_.insert(group);
    }
    return true;
  }
  const bool moved = cursor_.Handle(key, height_);
  cursor_.Fit(static_cast<int>(rows_.size()), height_);
  return moved;
}

}  // namespace hpdm
