#include "tools/spy/terminal/terminal_view.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <string>

#include "lcmtypes/analysis/channel_table.h"
#include "lcmtypes/live/wall_time.h"
#include "tools/spy/terminal/channel_list_view.h"
#include "tools/spy/terminal/field_history.h"
#include "tools/spy/terminal/field_list_view.h"
#include "tools/spy/terminal/log_controls.h"
#include "tools/spy/terminal/spy_text.h"
#include "tools/spy/terminal/terminal_screen.h"

namespace hpdm {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr auto kFrame = milliseconds(100);             // between two pictures
constexpr auto kStatisticsPeriod = milliseconds(250);  // between two updates of the rates
constexpr auto kReading = milliseconds(40);            // longest reading between two key checks
constexpr int kPoll = 50;                              // ms between two reads of the source

// Lines have at most 40 columns, for the narrowest terminals.
constexpr const char* kHelp[] = {
    "Up Down  j k    select",
    "PgUp PgDn g G   page, first, last",
    "Enter           open; show or fold many",
    "Esc Backspace   back",
    "q               quit",
    "/               filter names",
    "s S             sort by next; reverse",
    "",
    "A log:",
    "Space           pause or resume",
    "+ -             speed, 0.1 to 100, max",
    "Left Right      5 s back, forward",
    "< >             60 s back, forward",
    "0 ... 9         to 0 % ... 90 %",
    "Home End        to its start, its end",
    "",
    "Rate, jitter and bandwidth: over the",
    "last 5 s, at most 4,096 messages.",
    "Jitter: standard deviation of the",
    "interval between two messages.",
    "Lost: missing sequence numbers. UNREAD:",
    "another type or size than the channel's.",
};

class View {
 public:
  View(SpySource* source, const MessageSchemas& schemas)
      : source_(*source), schemas_(schemas), table_(schemas) {}

  void Run(const StopSignals& stop) {
    Clock::time_point next_picture = Clock::now(), next_statistics = next_picture;
    bool busy = false;
    while (!quit_ && !screen_.gone() && !stop.WaitFor(0)) {
      bool touched = false;
      if (screen_.Wait(busy ? 0 : kPoll)) {
        for (int key = screen_.NextKey(); key != kNoTerminalKey && !quit_;
             key = screen_.NextKey()) {
          Handle(key);
          touched = true;
        }
      }
      const bool ended = source_.messages().ended();
      busy = Read();
      jumped_ |= source_.messages().ended() != ended;
      const Clock::time_point now = Clock::now();
      if (now >= next_statistics || jumped_) {
        channels_.SetRows(table_.Rows(source_.player() != nullptr ? last_us_ : WallTimeUs()));
        next_statistics = now + kStatisticsPeriod;
        jumped_ = false;
      }
      if (touched || now >= next_picture) {
        Draw();
        next_picture = now + kFrame;
      }
    }
  }

 private:
  /// Reads the source for at most kReading; true if there is more to read.
  bool Read() {
    const Clock::time_point end = Clock::now() + kReading;
    MessageSource& messages = source_.messages();
    for (int n = 1; messages.Next(&event_, milliseconds(0)); ++n) {
      Take(event_);
      if (n % 64 == 0 && Clock::now() > end) return true;
    }
    return false;
  }

  void Take(const LogEvent& event) {
    last_us_ = event.time_us;
    const bool readable = table_.Add(event);
    if (readable && event.channel == open_) TakeValues(event);
  }

  void TakeValues(const LogEvent& event) {
    history_.Add(event.time_us, schemas_, *table_.Find(open_).type, event.data);
  }

  void Handle(int key) {
    if (help_) {
      help_ = key == kTerminalKeyDown || key == kTerminalKeyUp || key == kTerminalKeyResize;
      help_top_ += key == kTerminalKeyDown ? 1 : key == kTerminalKeyUp ? -1 : 0;
    } else if (typing_) {
      Type(key);
    } else if (key == '?') {
      help_ = true;
      help_top_ = 0;
    } else if (key == '/') {
      typing_ = true;
      filter_.clear();
      ApplyFilter();
    } else if (key == 'q') {
      quit_ = true;
    } else if (key == kTerminalKeyEscape || key == kTerminalKeyBackspace) {
      Back();
    } else if (source_.player() != nullptr && HandleLogKey(key, source_.player(), &sought_)) {
      if (sought_) Jump();
    } else if (!open_.empty()) {
      fields_.Handle(key, history_);
    } else if (key == kTerminalKeyEnter) {
      Open(channels_.selected());
    } else {
      channels_.Handle(key);
    }
  }

  /// Goes back one step: clears the filter, or closes the channel. Never ends the program: over a
  /// slow connection Escape, the first byte of a key, may come alone.
  void Back() {
    if (!filter_.empty()) {
      filter_.clear();
      ApplyFilter();
    } else if (!open_.empty()) {
      open_.clear();
      filter_ = channel_filter_;
    }
  }

  void Type(int key) {
    if (key == kTerminalKeyEnter) {
      typing_ = false;
    } else if (key == kTerminalKeyEscape) {
      typing_ = false;
      filter_.clear();
    } else if (key == kTerminalKeyBackspace) {
      if (filter_.empty()) typing_ = false;
      if (!filter_.empty()) filter_.pop_back();
    } else if (key >= 0x20 && key < 0x7f && filter_.size() < 60) {
      filter_ += static_cast<char>(key);
    }
    ApplyFilter();
  }

  void ApplyFilter() {
    if (open_.empty()) {
      channels_.SetFilter(filter_);
    } else {
      fields_.SetFilter(filter_);
    }
  }

  void Open(const std::string& channel) {
    if (channel.empty()) return;
    open_ = channel;
    channel_filter_ = filter_;
    filter_.clear();
    history_.Clear();
    fields_.Reset();
    TakeNewest();
  }

  void TakeNewest() {
    const ChannelTable::Last last = table_.Find(open_);
    if (last.type != nullptr && last.event != nullptr) TakeValues(*last.event);
  }

  /// Updates the view after a seek.
  void Jump() {
    table_.Interrupt();
    history_.Clear();
    source_.player()->ForNewestBefore([this](const LogEvent& event) { table_.Recall(event); });
    if (!open_.empty()) TakeNewest();
    sought_ = false;
    jumped_ = true;
  }

  void Draw() {
    screen_.Clear();
    const int rows = screen_.rows();
    LogPlayer* player = source_.player();
    const int foot = player != nullptr && rows > 4 ? 2 : 1;
    if (help_) {
      DrawHelp();
    } else {
      DrawTitle();
      if (open_.empty()) {
        DrawChannels(1, rows - 1 - foot);
      } else {
        DrawFields(1, rows - 1 - foot);
      }
      if (foot == 2) DrawTimeLine(&screen_, rows - 2, *player);
    }
    DrawFoot(rows - 1);
    screen_.Show();
  }

  void DrawTitle() {
    screen_.Fill(0, TextStyle::kBar);
    double rate = 0, bytes = 0;
    for (const ChannelRow& row : channels_.rows()) {
      rate += row.flow.rate_hz;
      bytes += row.flow.bytes_per_s;
    }
    const bool narrow = screen_.columns() < 60;
    std::string right = Format(narrow ? "%.4g/s " : "%.4g messages/s  ", rate);
    if (!narrow) right += BandwidthText(bytes) + ' ';
    const auto warn = [&right](std::uint64_t count, const char* what) {
      if (count > 0) right = WithCommas(static_cast<long long>(count)) + what + "  " + right;
    };
    warn(table_.other_messages(), " of further channels");
    warn(source_.dropped(), " DROPPED here");
    if (source_.player() != nullptr) warn(source_.player()->damaged_bytes(), " B damaged");
    const std::string left = narrow ? " " : " hpdm spy  ";
    const int room = screen_.columns() - WidthOf(left) - WidthOf(right) - 1;
    screen_.Put(0, screen_.columns() - WidthOf(right), right, TextStyle::kBar);
    screen_.Put(0, 0, left, TextStyle::kBar);
    if (room < 4) return;
    screen_.Put(0, WidthOf(left),
                FitLeftKeepingEnd(Printable(source_.name()), room, screen_.glyphs()),
                TextStyle::kBar);
  }

  void DrawChannels(int top, int height) {
    channels_.Draw(&screen_, top, height);
    if (table_.messages() > 0) return;
    const bool live = source_.player() == nullptr;
    const char* lines[] = {
        live ? "No messages yet. Start a session with" : "This log has no event before this time.",
        live ? "  hpdm run SCENE --live" : "", live ? "and the same LCM_DEFAULT_URL." : ""};
    for (int i = 0; i < 3; ++i) screen_.Put(top + 2 + i, 2, lines[i], TextStyle::kDim);
  }

  void DrawFields(int top, int height) {
    const ChannelRow* row = nullptr;
    for (const ChannelRow& r : channels_.rows()) {
      if (r.facts.channel == open_) row = &r;
    }
    std::string line = Printable(open_);
    if (row != nullptr) {
      line += "  " + Printable(row->facts.type);
      if (const std::string age = AgeText(row->facts.last_us); !age.empty()) {
        line += "  " + age;
      } else {
        line += "  " + RateText(*row) + " Hz";
      }
      line += "  " + WithCommas(static_cast<long long>(row->facts.messages)) + " messages";
      if (row->facts.lost > 0) {
        line += "  lost " + WithCommas(static_cast<long long>(row->facts.lost));
      }
      if (row->facts.unreadable > 0) {
        line += "  unreadable " + WithCommas(static_cast<long long>(row->facts.unreadable));
      }
      line += "  jitter " + JitterText(row->flow.jitter_s, *row) + "  " +
              BandwidthText(row->flow.bytes_per_s);
    }
    screen_.Put(top, 0, line, TextStyle::kBold);
    if (history_.fields().empty()) {
      const ChannelTable::Last last = table_.Find(open_);
      const bool had = row != nullptr && row->facts.messages > row->facts.unreadable;
      screen_.Put(top + 2, 2,
                  last.type == nullptr                 ? "Unknown message type;"
                  : had && source_.player() != nullptr ? "Its next message comes later in the log."
                                                       : "No readable message yet.",
                  TextStyle::kDim);
      if (last.type == nullptr) {
        screen_.Put(top + 3, 2, "give its file with --types FILE.lcm", TextStyle::kDim);
      }
      return;
    }
    fields_.Draw(&screen_, history_, top + 1, height - 1);
  }

  /// Returns how long a live channel has been silent if that is more than 3 s, else empty text.
  std::string AgeText(std::int64_t last_us) const {
    if (source_.player() != nullptr) return {};
    const double age = 1e-6 * static_cast<double>(WallTimeUs() - last_us);
    return age > 3 ? Format("last one %.0f s ago", age) : std::string();
  }

  void DrawFoot(int row) {
    if (typing_) {
      screen_.Put(row, 0, "/" + filter_ + "_   Enter keeps, Esc clears", TextStyle::kBold);
      return;
    }
    std::string keys;
    const auto add = [&](const char* text) {
      const int width = WidthOf(keys) + 2 + WidthOf(text);
      if (width <= screen_.columns()) keys += (keys.empty() ? " " : "  ") + std::string(text);
    };
    if (help_) {
      add("up down scroll");
      add("any other key: back");
    } else {
      if (!filter_.empty()) add(("[/" + filter_ + "]").c_str());
      add("? help");
      add(open_.empty() ? "q quit" : "Esc back");
      if (open_.empty()) add("Enter open");
      add("/ filter");
      if (open_.empty()) add("s sort");
      if (source_.player() != nullptr) {
        add("Space pause");
        add("+ - speed");
        add("left right seek");
      }
    }
    screen_.Put(row, 0, keys, TextStyle::kDim);
  }

  void DrawHelp() {
    const int height = screen_.rows() - 1;
    help_top_ = std::clamp(help_top_, 0, std::max(0, static_cast<int>(std::size(kHelp)) - height));
    for (int row = 0; row < height; ++row) {
      const auto line = static_cast<std::size_t>(help_top_ + row);
      if (line < std::size(kHelp)) screen_.Put(row, 0, kHelp[line]);
    }
  }

  SpySource& source_;
  const MessageSchemas& schemas_;
  ChannelTable table_;
  ChannelListView channels_;
  FieldListView fields_;
  FieldHistory history_;
  std::string open_;  // channel; empty: the list
  std::string filter_, channel_filter_;
  bool typing_ = false, help_ = false, quit_ = false;
  bool sought_ = false;
  bool jumped_ = false;  // the figures are out of date
  int help_top_ = 0;
  LogEvent event_;
  std::int64_t last_us_ = 0;  // time stamp of the newest message
  TerminalScreen screen_;     // the last member, so that it is restored first
};

}  // namespace

void RunTerminalView(SpySource* source, const MessageSchemas& schemas, const StopSignals& stop) {
  View(source, schemas).Run(stop);
}

}  // namespace hpdm
