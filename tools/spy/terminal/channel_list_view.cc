#include "tools/spy/terminal/channel_list_view.h"

#include <algorithm>
#include <numeric>

#include "tools/spy/terminal/spy_text.h"

namespace hpdm {
namespace {

struct ColumnLook {
  const char* title;
  int width;      // the first two also take the remaining width
  int rank;       // order in which columns get their width
  bool from_top;  // sorted with the largest first
};
constexpr ColumnLook kLooks[ChannelListView::kColumns] = {
    {"CHANNEL", 14, 0, false}, {"TYPE", 15, 5, false}, {"MESSAGES", 9, 1, true},
    {"RATE Hz", 7, 2, true},   {"JITTER", 7, 4, true}, {"BANDWIDTH", 9, 6, true},
    {"LOST", 5, 3, true},      {"UNREAD", 6, 7, true},
};

std::string Cell(const ChannelRow& row, int column) {
  switch (column) {
    case ChannelListView::kChannel:
      return Printable(row.facts.channel);
    case ChannelListView::kType:
      return Printable(row.facts.type);
    case ChannelListView::kMessages:
      return CountText(row.facts.messages, kLooks[column].width);
    case ChannelListView::kRate:
      return RateText(row);
    case ChannelListView::kJitter:
      return JitterText(row.flow.jitter_s, row);
    case ChannelListView::kBandwidth:
      return BandwidthText(row.flow.bytes_per_s);
    case ChannelListView::kLost:
      return CountText(row.facts.lost, kLooks[column].width);
    default:
      return CountText(row.facts.unreadable, kLooks[column].width);
  }
}

double Number(const ChannelRow& row, int column) {
  switch (column) {
    case ChannelListView::kMessages:
      return static_cast<double>(row.facts.messages);
    case ChannelListView::kRate:
      return row.flow.rate_hz;
    case ChannelListView::kJitter:
      return row.flow.jitter_s;
    case ChannelListView::kBandwidth:
      return row.flow.bytes_per_s;
    case ChannelListView::kLost:
      return static_cast<double>(row.facts.lost);
    case ChannelListView::kUnreadable:
      return static_cast<double>(row.facts.unreadable);
    default:
      return 0;
  }
}

/// Returns the width of each column on a screen of `columns` characters; 0: left out.
std::vector<int> Widths(int columns) {
  std::vector<int> widths(ChannelListView::kColumns, 0);
  int room = columns + 1;  // no space before the first
  for (int rank = 0; rank < ChannelListView::kColumns; ++rank) {
    const auto* look = std::find_if(std::begin(kLooks), std::end(kLooks),
                                    [rank](const ColumnLook& l) { return l.rank == rank; });
    if (look->width + 1 > room) break;
    room -= look->width + 1;
    widths[static_cast<std::size_t>(look - std::begin(kLooks))] = look->width;
  }
  // The names get the remaining width, up to the usual lengths.
  const int more_channel = std::min(room, widths[ChannelListView::kType] > 0 ? 18 : room);
  widths[ChannelListView::kChannel] += more_channel;
  if (widths[ChannelListView::kType] > 0) {
    widths[ChannelListView::kType] += std::min(room - more_channel, 20);
  }
  return widths;
}

}  // namespace

void ChannelListView::SetRows(std::vector<ChannelRow> rows) {
  const std::string chosen = selected();
  rows_ = std::move(rows);
  Arrange();
  Select(chosen);
}

void ChannelListView::SetFilter(const std::string& filter) {
  filter_ = filter;
  Arrange();
}

void ChannelListView::Arrange() {
  shown_.clear();
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (HasInIt(rows_[i].facts.channel, filter_)) shown_.push_back(i);
  }
  // Rows come sorted by name; a stable sort keeps that order among equals.
  std::stable_sort(shown_.begin(), shown_.end(), [this](std::size_t a, std::size_t b) {
    if (reversed_) std::swap(a, b);
    if (order_ == kChannel) return rows_[a].facts.channel < rows_[b].facts.channel;
    if (order_ == kType) return rows_[a].facts.type < rows_[b].facts.type;
    return Number(rows_[a], order_) > Number(rows_[b], order_);
  });
}

void ChannelListView::Select(const std::string& channel) {
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    if (rows_[shown_[i]].facts.channel == channel) cursor_.selected = static_cast<int>(i);
  }
}

std::string ChannelListView::selected() const {
  const auto at = static_cast<std::size_t>(std::max(0, cursor_.selected));
  return at < shown_.size() ? rows_[shown_[at]].facts.channel : std::string();
}

void ChannelListView::Draw(TerminalScreen* screen, int top, int height) {
  const std::vector<int> widths = Widths(screen->columns());
  height_ = std::max(1, height - 1);
  cursor_.Fit(static_cast<int>(shown_.size()), height_);
  const auto draw_row = [&](int at, TextStyle style, const auto& cell, const auto& style_of) {
    if (style != TextStyle::kPlain) screen->Fill(at, style);
    int column = 0;
    for (int c = 0; c < kColumns; ++c) {
      const int width = widths[static_cast<std::size_t>(c)];
      if (width == 0) continue;
      const bool text = c <= kType;
      const std::string words =
          text ? FitLeft(cell(c), width, screen->glyphs()) : FitRight(cell(c), width);
      screen->Put(at, column, words, style == TextStyle::kPlain ? style_of(c) : style);
      column += width + 1;
    }
  };
  draw_row(
      top, TextStyle::kBold,
      [&](int c) {
        const std::string_view mark =
            reversed_ == kLooks[c].from_top ? screen->glyphs().rising : screen->glyphs().falling;
        return std::string(kLooks[c].title) + (c == order_ ? std::string(mark) : std::string());
      },
      [](int) { return TextStyle::kBold; });
  if (shown_.empty() && !rows_.empty()) {
    screen->Put(top + 2, 2, "No name matches the filter.", TextStyle::kDim);
  }
  for (int i = 0; i < height_; ++i) {
    const auto at = static_cast<std::size_t>(cursor_.top + i);
    if (at >= shown_.size()) break;
    const ChannelRow& row = rows_[shown_[at]];
    const bool chosen = cursor_.top + i == cursor_.selected;
    draw_row(
        top + 1 + i, chosen ? TextStyle::kSelected : TextStyle::kPlain,
        [&](int c) { return Cell(row, c); },
        [&](int c) {
          const bool wrong =
              (c == kLost && row.facts.lost > 0) || (c == kUnreadable && row.facts.unreadable > 0);
          if (wrong) return TextStyle::kAlarm;
          return c == kType && !row.facts.known ? TextStyle::kDim : TextStyle::kPlain;
        });
  }
}

bool ChannelListView::Handle(int key) {
  if (key == 's') {
    order_ = static_cast<Column>((order_ + 1) % kColumns);
    reversed_ = false;
  } else if (key == 'S') {
    reversed_ = !reversed_;
  } else {
    const bool moved = cursor_.Handle(key, height_);
    cursor_.Fit(static_cast<int>(shown_.size()), height_);
    return moved;
  }
  const std::string chosen = selected();
  Arrange();
  Select(chosen);
  return true;
}

}  // namespace hpdm
