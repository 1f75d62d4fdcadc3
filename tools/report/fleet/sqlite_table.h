#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/report/fleet/session_table.h"

struct sqlite3;
struct sqlite3_stmt;

namespace hpdm {

/// A column of a table and the place of its value.
struct TableColumn {
  std::string_view name;
  std::string_view type;   ///< INTEGER, REAL or TEXT.
  std::string_view place;  ///< JSON pointer in the line, or in its part that the table lists.
};

/// A table as an SQLite file, which DuckDB reads too. It has the tables sessions, hands, contacts
/// (of a hand with an organ), attachments, latencies, exercises and goals; tools/report/fleet.md lists the columns. Each Add is
/// one transaction.
class SqliteTable : public SessionTable {
 public:
  explicit SqliteTable(const std::filesystem::path& path);
  ~SqliteTable() override;

  std::unordered_map<std::string, KnownSession> Known() override;
  void Add(std::span<const nlohmann::ordered_json> lines) override;

 private:
  using Statement = std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)>;
  struct Insert {
    std::span<const TableColumn> columns;
    std::vector<std::string_view> keys;
    Statement statement;
  };

  void Execute(const std::string& sql);
  Statement Prepare(const std::string& sql);
  void CreateTables();
  void PrepareInserts();
  void AddRow(const Insert& insert, const std::vector<nlohmann::ordered_json>& keys,
              const nlohmann::ordered_json& values);
  void AddRows(const nlohmann::ordered_json& line);
  [[noreturn]] void Refuse() const;

  std::string path_;
  std::unique_ptr<sqlite3, int (*)(sqlite3*)> database_;
  std::vector<Statement> deletes_;
  std::vector<Insert> inserts_;  // in the order of kTables
};

}  // namespace hpdm
