#pragma once

#include <set>
#include <string>
#include <vector>

#include "tools/spy/terminal/field_history.h"
#include "tools/spy/terminal/list_cursor.h"
#include "tools/spy/terminal/terminal_screen.h"

namespace hpdm {

/// The values of one channel's newest message: a row per value, with its minimum and maximum and a
/// sparkline of the last FieldHistory::kSpanUs. A member with more than kFoldedFrom values is one
/// row until it is opened. Main thread.
class FieldListView {
 public:
  static constexpr std::size_t kFoldedFrom = 64;

  /// Clears the selection, the opened members and the filter, for another channel.
  void Reset();
  void SetFilter(const std::string& filter);

  /// Draws into the rows [top, top + height).
  void Draw(TerminalScreen* screen, const FieldHistory& history, int top, int height);
  /// Returns false if the key is not for the list.
  bool Handle(int key, const FieldHistory& history);

 private:
  struct Row {
    std::size_t field = 0;   // the field, or the first of a group
    std::size_t fields = 0;  // number of fields of a group; 0: a single field
  };

  void Arrange(const FieldHistory& history);
  void DrawGroup(TerminalScreen* screen, std::size_t row, int line, TextStyle style) const;

  std::vector<Row> rows_;
  std::vector<std::string> groups_;  // by row: the member that it belongs to
  std::set<std::string> opened_;
  std::string filter_;
  ListCursor cursor_;
  int height_ = 1;
};

}  // namespace hpdm
