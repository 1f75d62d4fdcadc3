#include "tools/log/log_export.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <system_error>
#include <unordered_map>

#include "engine/base/error.h"
#include "lcmtypes/log/log.h"
#include "tools/log/file_names.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

/// The columns of one channel, in the order of the values in its messages.
class Columns {
 public:
  void Add(const MessageSchemas& schemas, const LcmStruct& type, const LogEvent& event) {
    std::size_t after = 0;  // place of a new column: after its predecessor in the message
    schemas.Decode(type, event.data, [&](const MessageValue& value) {
      const auto known = index_.find(std::string(value.name));
      if (known != index_.end()) {
        after = known->second + 1;
        return;
      }
      names_.insert(names_.begin() + static_cast<std::ptrdiff_t>(after), std::string(value.name));
      Renumber(after++);
    });
  }

  const std::vector<std::string>& names() const { return names_; }
  std::optional<std::size_t> Of(std::string_view name) const {
    const auto found = index_.find(std::string(name));
    if (found == index_.end()) return std::nullopt;
    return found->second;
  }

 private:
  void Renumber(std::size_t from) {
    for (std::size_t i = from; i < names_.size(); ++i) index_[names_[i]] = i;
  }

  std::vector<std::string> names_;
  std::unordered_map<std::string, std::size_t> index_;
};

constexpr std::size_t kMaxOpenTables = 64;

struct Table {
  const LcmStruct* type = nullptr;
  Columns columns;
  std::optional<StagedFile> out;
  bool open = false;
  ExportedChannel exported;
};

/// Bounds the number of tables whose files are open at a time.
class OpenTables {
 public:
  /// Call before writing to `table`.
  void Use(Table* table) {
    if (table->open) return;
    if (tables_.size() == kMaxOpenTables) {
      tables_.front()->out->Rest();
      tables_.front()->open = false;
      tables_.pop_front();
    }
    table->open = true;
    tables_.push_back(table);
  }

 private:
  std::deque<Table*> tables_;  // in the order of opening
};

std::string Cell(const MessageValue& value) {
  std::array<char, 32> digits;
  const auto text = [&digits](auto number) {
    return std::string(digits.data(),
                       std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr);
  };
  if (const auto* integer = std::get_if<std::int64_t>(&value.value)) return text(*integer);
  if (const auto* real = std::get_if<double>(&value.value)) return text(*real);
  std::string quoted = "\"";
  for (const char c : std::get<std::string_view>(value.value))
    quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

void WriteRow(const std::string& first, const std::vector<std::string>& cells, StagedFile* out) {
  out->Write(first);
  for (const std::string& cell : cells) {
    out->Write(",");
    out->Write(cell);
  }
  out->Write("\n");
}

using Tables = std::map<std::string, Table>;

/// True if the message is complete. The values of a message that breaks off must not enter a table.
bool Readable(const Table& table, const LogEvent& event, const MessageSchemas& schemas) {
  return table.type != nullptr && schemas.Find(event.data) == table.type &&
         schemas.Decode(*table.type, event.data, [](const MessageValue&) {});
}

/// First pass: finds the columns.
Tables FindColumns(const std::string& log, const std::vector<std::string>& channels,
                   const MessageSchemas& schemas, const std::function<void()>& at_event) {
  Tables tables;
  LogReader reader(log);
  LogEvent event;
  while (reader.Next(&event)) {
    at_event();
    if (!channels.empty() &&
        std::find(channels.begin(), channels.end(), event.channel) == channels.end()) {
      continue;
    }
    Table& table = tables[event.channel];
    if (table.type == nullptr) {
      table.type = schemas.Find(event.data);
      if (table.type != nullptr || table.exported.type.empty()) {
        table.exported.type = schemas.TypeOf(event.data);
      }
    }
    if (Readable(table, event, schemas)) table.columns.Add(schemas, *table.type, event);
  }
  for (const std::string& channel : channels) {
    if (!tables.contains(channel)) RefuseMissingChannel(log, channel);
  }
  return tables;
}

}  // namespace

std::vector<ExportedChannel> ExportCsv(const std::string& log, const std::filesystem::path& folder,
                                       const std::vector<std::string>& channels,
                                       const MessageSchemas& schemas,
                                       const std::function<void()>& at_event) {
  Tables tables = FindColumns(log, channels, schemas, at_event);
  MakeOutFolder(folder);
  FileNames names;
  OpenTables open;
  for (auto& [channel, table] : tables) {
    table.exported.channel = channel;
    if (table.type == nullptr) continue;
    table.exported.file = folder / (names.Of(channel) + ".csv");
    open.Use(&table);
    table.out.emplace(table.exported.file, StagedFile::Name::kOfOthers);
    WriteRow("time_us", table.columns.names(), &*table.out);
  }
  LogReader reader(log);
  LogEvent event;
  std::vector<std::string> cells;
  while (reader.Next(&event)) {
    at_event();
    const auto found = tables.find(event.channel);
    if (found == tables.end()) continue;
    Table& table = found->second;
    cells.assign(table.columns.names().size(), "");
    const bool readable = table.type != nullptr && schemas.Find(event.data) == table.type &&
                          schemas.Decode(*table.type, event.data, [&](const MessageValue& value) {
                            // A message that breaks off may have values without a column.
                            if (const auto column = table.columns.Of(value.name))
                              cells[*column] = Cell(value);
                          });
    if (!readable) {
      ++table.exported.skipped;
      continue;
    }
    open.Use(&table);
    WriteRow(std::to_string(event.time_us), cells, &*table.out);
    ++table.exported.messages;
  }
  std::vector<ExportedChannel> exported;
  for (auto& [channel, table] : tables) {
    if (table.out) table.out->Close();
  }
  for (auto& [channel, table] : tables) {
    if (table.out) table.out->Commit();
    exported.push_back(table.exported);
  }
  return exported;
}

void RefuseMissingChannel(const std::string& log, const std::string& channel) {
  throw InputError(log + ": contains no channel " + channel + "; hpdm log check lists them");
}

}  // namespace hpdm
