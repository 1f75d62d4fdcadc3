#pragma once

#include <string>
#include <vector>

#include "lcmtypes/analysis/channel_table.h"
#include "tools/spy/terminal/list_cursor.h"
#include "tools/spy/terminal/terminal_screen.h"

namespace hpdm {

/// The table of channels: sorted, filtered, with a selected row. Columns that find no room are left
/// out, the least telling first. Main thread.
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

  /// Rows as ChannelTable gives them. The selection stays with its channel.
  void SetRows(std::vector<ChannelRow> rows);
  /// Channels whose name has this in it, whatever the case.
  void SetFilter(const std::string& filter);

  /// Draws into the rows [top, top + height).
  void Draw(TerminalScreen* screen, int top, int height);
  /// False: the key is not for the table.
  bool Handle(int key);

  const std::vector<ChannelRow>& rows() const { return rows_; }
  std::string selected() const;  ///< Channel; empty without any.

 private:
  void Arrange();

  std::vector<ChannelRow> rows_;
  std::vector<std::size_t> shown_;  // places in rows_, in order
  std::string filter_;
  Column order_ = kChannel;
  bool reversed_ = false;
  ListCursor cursor_;
  int height_ = 1;
};

}  // namespace hpdm
