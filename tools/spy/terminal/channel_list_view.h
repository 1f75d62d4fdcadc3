#pragma once

#include <string>
#include <vector>

#include "lcmtypes/analysis/channel_table.h"
#include "tools/spy/terminal/list_cursor.h"
#include "tools/spy/terminal/terminal_screen.h"

namespace hpdm {

/// The table of channels: sorted, filtered, with a selected row. Columns that do not fit are left
/// out, the least important first. Main thread.
class ChannelListView {
 public:
  enum Column {
    kChannel,
    kType,
    kMessages,
    kRate,
    kJitter,
    kBandwidth,
    kLost,
    kUnreadable,
    kColumns
  };

  /// Sets the rows of a ChannelTable. The selection stays with its channel.
  void SetRows(std::vector<ChannelRow> rows);
  /// Shows only channels whose name contains the filter, ignoring case.
  void SetFilter(const std::string& filter);

  /// Draws into the rows [top, top + height).
  void Draw(TerminalScreen* screen, int top, int height);
  /// Returns false if the key is not for the table.
  bool Handle(int key);

  const std::vector<ChannelRow>& rows() const { return rows_; }
  std::string selected() const;  ///< Selected channel; empty without any.

 private:
  void Arrange();
  void Select(const std::string& channel);

  std::vector<ChannelRow> rows_;
  std::vector<std::size_t> shown_;  // indices into rows_, in order
  std::string filter_;
  Column order_ = kChannel;
  bool reversed_ = false;
  ListCursor cursor_;
  int height_ = 1;
};

}  // namespace hpdm
