#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "tools/report/fleet/session_table.h"

namespace hpdm {

/// A table as lines of JSON in a file. Each line is appended whole; a torn last line is ended and
/// ignored. A file that begins with anything but a session's line is refused and not changed.
class LinesTable : public SessionTable {
 public:
  explicit LinesTable(std::filesystem::path path);
  ~LinesTable() override;

  std::unordered_map<std::string, KnownSession> Known() override;
  void Add(std::span<const nlohmann::ordered_json> lines) override;

 private:
  bool IsTable() const;
  void Append(const std::string& text);

  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace hpdm
