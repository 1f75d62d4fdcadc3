#pragma once

#include <set>
#include <string>
#include <vector>

#include "tools/spy/terminal/field_history.h"
#include "tools/spy/terminal/list_cursor.h"
#include "tools/spy/terminal/terminal_screen.h"

namespace hpdm {

/// The values of one channel's newest message: a row each, with its least and greatest and a
/// sparkline of the last FieldHistory::kSpanUs. Members with more than kFoldedFrom values are one
/// row until they are opened. Main thread.
class FieldListView {
 public:
  static constexpr std::size_t kFoldedFrom = 64;

  /// Another channel: nothing is selected, opened or filtered.
  void Reset();
  void SetFilter(const std::string& filter);

  /// Draws into the rows [top, top + height).
  void Draw(TerminalScreen* screen, const FieldHistory& history, int top, int height);
  /// False: the key is not for the list.
  bool Handle(int key, const FieldHistory& history);

 private:
  struct Row {
    std::size_t field = 0;   // of a group, its first
    std::size_t fields = 0;  // 0: a single field
  };

  void Arrange(const FieldHistory& history);

  std::vector<Row> rows_;
  std::vector<std::string> groups_;  // of rows_: the member that a row belongs to
  std::set<std::string> opened_;
  std::string filter_;
  ListCursor cursor_;
  int height_ = 1;
};

}  // namespace hpdm
