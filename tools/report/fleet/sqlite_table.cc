#include "tools/report/fleet/sqlite_table.h"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/text_list.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

/// Identify the file: "HPDM" in its header, and the version of its tables.
constexpr int kApplication = 0x4850444D;
constexpr int kVersion = 6;
/// Longest wait for another program that writes, ms.
constexpr int kLockPatience = 60'000;

constexpr TableColumn kSessionColumns[] = {
    {"exit_code", "INTEGER", "/exit_code"},
    {"error", "TEXT", "/error"},
    {"report_version", "INTEGER", "/report_version"},
    {"log_bytes", "INTEGER", "/log_bytes"},
    {"log_mtime_ns", "INTEGER", "/log_mtime_ns"},
    {"summary_mtime_ns", "INTEGER", "/summary_mtime_ns"},
    {"scene", "TEXT", "/report/scene"},
    {"left_handed", "INTEGER", "/report/left_handed"},
    {"start", "TEXT", "/report/start"},
    {"measured", "INTEGER", "/report/measured"},
    {"duration_s", "REAL", "/report/duration_s"},
    {"active_s", "REAL", "/report/active_s"},
    {"paused_s", "REAL", "/report/paused_s"},
    {"force_limit_N", "REAL", "/report/force_limit_N"},
    {"depth_limit_m", "REAL", "/report/depth_limit_m"},
    {"both_moving_s", "REAL", "/report/both_moving_s"},
    {"any_moving_s", "REAL", "/report/any_moving_s"},
    {"working_together_s", "REAL", "/report/working_together_s"},
    {"ticks", "INTEGER", "/report/ticks"},
    {"ticks_skipped", "INTEGER", "/report/skipped/total"},
    {"skipped_late_wake_up", "INTEGER", "/report/skipped/late_wake_up"},
    {"skipped_long_compute", "INTEGER", "/report/skipped/long_compute"},
    {"skipped_stalled", "INTEGER", "/report/skipped/stalled"},
    {"stolen_s", "REAL", "/report/stolen_s"},
    {"steps_shed", "INTEGER", "/report/steps_shed"},
    {"log_sound", "INTEGER", "/report/log_health/sound"},
    {"log_closed", "INTEGER", "/report/log_health/closed"},
    {"log_events", "INTEGER", "/report/log_health/events"},
    {"damaged_bytes", "INTEGER", "/report/log_health/damaged_bytes"},
    {"torn_bytes", "INTEGER", "/report/log_health/torn_bytes"},
    {"unreadable", "INTEGER", "/report/log_health/unreadable"},
    {"ticks_lost", "INTEGER", "/report/log_health/ticks_lost"},
    {"outputs_lost", "INTEGER", "/report/log_health/outputs_lost"},
    {"messages_lost", "INTEGER", "/report/log_health/messages_lost"}};

constexpr TableColumn kForceColumns[] = {{"contact_time_s", "REAL", "/contact_time_s"},
                                         {"contacts", "INTEGER", "/contacts"},
                                         {"forces_off_s", "REAL", "/forces_off_s"},
                                         {"forces_clamped_s", "REAL", "/forces_clamped_s"},
                                         {"peak_force_N", "REAL", "/peak_force_N"},
                                         {"mean_force_N", "REAL", "/mean_force_N"},
                                         {"force_impulse_Ns", "REAL", "/force_impulse_Ns"},
                                         {"over_limit_s", "REAL", "/over_limit_s"},
                                         {"over_limit_count", "INTEGER", "/over_limit_count"},
                                         {"deepest_press_m", "REAL", "/deepest_press_m"},
                                         {"over_depth_s", "REAL", "/over_depth_s"},
                                         {"over_depth_count", "INTEGER", "/over_depth_count"},
                                         {"slips", "INTEGER", "/slips"}};

constexpr TableColumn kMotionColumns[] = {{"name", "TEXT", "/name"},
                                          {"instruments", "TEXT", "/instruments"},
                                          {"time_s", "REAL", "/time_s"},
                                          {"path_length_m", "REAL", "/path_length_m"},
                                          {"angular_path_rad", "REAL", "/angular_path_rad"},
                                          {"roll_path_rad", "REAL", "/roll_path_rad"},
                                          {"insertion_path_m", "REAL", "/insertion_path_m"},
                                          {"economy_of_motion", "REAL", "/economy_of_motion"},
                                          {"movements", "INTEGER", "/movements"},
                                          {"mean_speed_m_per_s", "REAL", "/mean_speed_m_per_s"},
                                          {"peak_speed_m_per_s", "REAL", "/peak_speed_m_per_s"},
                                          {"smoothness_sparc", "REAL", "/smoothness_sparc"},
                                          {"idle_s", "REAL", "/idle_s"},
                                          {"advances", "INTEGER", "/advances"},
                                          {"overshoots", "INTEGER", "/overshoots"}};

constexpr TableColumn kDeviceColumns[] = {
    {"mean_force_rate_N_per_s", "REAL", "/mean_force_rate_N_per_s"},
    {"peak_force_rate_N_per_s", "REAL", "/peak_force_rate_N_per_s"},
    {"device_lost_s", "REAL", "/device_lost_s"},
    {"depth_unknown_s", "REAL", "/depth_unknown_s"}};

constexpr TableColumn kOrganColumn[] = {{"organ_name", "TEXT", "/organ"}};

constexpr TableColumn kLatencyColumns[] = {
    {"count", "INTEGER", "/count"},    {"p50_us", "REAL", "/p50_us"},
    {"p90_us", "REAL", "/p90_us"},     {"p99_us", "REAL", "/p99_us"},
    {"p99_9_us", "REAL", "/p99_9_us"}, {"max_us", "REAL", "/max_us"}};

constexpr TableColumn kAttachmentColumns[] = {{"name", "TEXT", "/name"},
                                              {"peak_load_N", "REAL", "/peak_load_N"},
                                              {"largest_damage", "REAL", "/largest_damage"},
                                              {"freed_area_m2", "REAL", "/freed_area_m2"},
                                              {"burnt_area_m2", "REAL", "/burnt_area_m2"},
                                              {"cut_area_m2", "REAL", "/cut_area_m2"},
                                              {"dissipated_J", "REAL", "/dissipated_J"}};

constexpr TableColumn kExerciseColumns[] = {{"name", "TEXT", "/name"},
                                            {"score", "REAL", "/score"},
                                            {"passed", "INTEGER", "/passed"},
                                            {"ended", "INTEGER", "/ended"},
                                            {"time_s", "REAL", "/time_s"},
                                            {"error_count", "INTEGER", "/error_count"},
                                            {"restart_count", "INTEGER", "/restart_count"}};

constexpr TableColumn kGoalsColumns[] = {
    {"depth_perception", "REAL", "/depth_perception/rating"},
    {"bimanual_dexterity", "REAL", "/bimanual_dexterity/rating"},
    {"efficiency", "REAL", "/efficiency/rating"},
    {"tissue_handling", "REAL", "/tissue_handling/rating"}};

template <std::size_t... kSizes>
constexpr auto Joined(const TableColumn (&... parts)[kSizes]) {
  std::array<TableColumn, (kSizes + ...)> joined;
  auto at = joined.begin();
  ((at = std::copy(std::begin(parts), std::end(parts), at)), ...);
  return joined;
}
constexpr auto kHandColumns = Joined(kMotionColumns, kForceColumns, kDeviceColumns);
constexpr auto kContactColumns = Joined(kOrganColumn, kForceColumns);

struct Table {
  std::string_view name;
  std::vector<std::string_view> keys;
  std::span<const TableColumn> columns;
};
enum { kSessions, kHands, kContacts, kLatencies, kAttachments, kExercises, kGoals };
const Table kTables[] = {{"sessions", {"session"}, kSessionColumns},
                         {"hands", {"session", "hand"}, kHandColumns},
                         {"contacts", {"session", "hand", "organ"}, kContactColumns},
                         {"latencies", {"session", "latency"}, kLatencyColumns},
                         {"attachments", {"session", "attachment"}, kAttachmentColumns},
                         {"exercises", {"session"}, kExerciseColumns},
                         {"goals", {"session"}, kGoalsColumns}};

int Bind(sqlite3_stmt* statement, int at, const Json& value) {
  if (value.is_boolean()) return sqlite3_bind_int(statement, at, value.get<bool>());
  if (value.is_number_unsigned() &&
      value.get<std::uint64_t>() > std::numeric_limits<std::int64_t>::max()) {
    return sqlite3_bind_double(statement, at, value.get<double>());
  }
  if (value.is_number_integer()) {
    return sqlite3_bind_int64(statement, at, value.get<std::int64_t>());
  }
  if (value.is_number()) return sqlite3_bind_double(statement, at, value.get<double>());
  if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    return sqlite3_bind_text64(statement, at, text.data(), text.size(), SQLITE_TRANSIENT,
                               SQLITE_UTF8);
  }
  return sqlite3_bind_null(statement, at);
}

const Json& At(const Json& values, std::string_view place) {
  static const Json null;
  const Json::json_pointer pointer{std::string(place)};
  return values.contains(pointer) ? values.at(pointer) : null;
}

const Json& ListOf(const Json& values, const char* place) {
  static const Json none = Json::array();
  const Json& list = At(values, place);
  return list.is_array() ? list : none;
}

}  // namespace

SqliteTable::SqliteTable(const std::filesystem::path& path)
    : path_(path.string()), database_(nullptr, sqlite3_close) {
  sqlite3* opened = nullptr;
  // The path must be absolute: SQLite does not take ":memory:" for a file.
  const int result = sqlite3_open_v2(std::filesystem::absolute(path).c_str(), &opened,
                                     SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
  database_.reset(opened);
  if (result != SQLITE_OK) Refuse();
  sqlite3_busy_timeout(opened, kLockPatience);
  CreateTables();
  PrepareInserts();
}

SqliteTable::~SqliteTable() = default;

void SqliteTable::CreateTables() {
  Execute("BEGIN IMMEDIATE");
  const auto number = [this](const std::string& sql) {
    const Statement statement = Prepare(sql);
    if (sqlite3_step(statement.get()) != SQLITE_ROW) Refuse();
    return sqlite3_column_int(statement.get(), 0);
  };
  const int application = number("PRAGMA application_id");
  const int version = number("PRAGMA user_version");
  if (application != kApplication || version != kVersion) {
    if (number("SELECT count(*) FROM sqlite_master") > 0) {
      throw InputError(path_ +
                       ": not a table of this version of hpdm report; choose another --out");
    }
    for (const Table& table : kTables) {
      std::string columns, keys;
      for (const std::string_view key : table.keys) {
        columns += std::string(key) +
                   (key == "session" || key == "latency" ? " TEXT" : " INTEGER") + " NOT NULL, ";
        AppendToList(key, &keys);
      }
      for (const TableColumn& column : table.columns) {
        columns += std::string(column.name) + " " + std::string(column.type) + ", ";
      }
      Execute("CREATE TABLE " + std::string(table.name) + " (" + columns + "PRIMARY KEY (" + keys +
              ")) WITHOUT ROWID");
    }
    Execute("PRAGMA application_id = " + std::to_string(kApplication));
    Execute("PRAGMA user_version = " + std::to_string(kVersion));
  }
  Execute("COMMIT");
}

void SqliteTable::PrepareInserts() {
  for (const Table& table : kTables) {
    const std::string name(table.name);
    deletes_.push_back(Prepare("DELETE FROM " + name + " WHERE session = ?"));
    std::string columns, marks;
    const auto add = [&](std::string_view column) {
      AppendToList(column, &columns);
      AppendToList("?", &marks);
    };
    for (const std::string_view key : table.keys) add(key);
    for (const TableColumn& column : table.columns) add(column.name);
    inserts_.push_back(
        {table.columns, table.keys,
         Prepare("INSERT OR REPLACE INTO " + name + " (" + columns + ") VALUES (" + marks + ")")});
  }
}

std::unordered_map<std::string, KnownSession> SqliteTable::Known() {
  std::unordered_map<std::string, KnownSession> known;
  const Statement statement = Prepare(
      "SELECT session, exit_code, log_bytes, log_mtime_ns, force_limit_N, error, report_version, "
      "summary_mtime_ns, depth_limit_m FROM sessions");
  int result;
  while ((result = sqlite3_step(statement.get())) == SQLITE_ROW) {
    const auto has = [&](int column) {
      return sqlite3_column_type(statement.get(), column) != SQLITE_NULL;
    };
    const auto text = [&](int column) {
      const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement.get(), column));
      const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement.get(), column));
      return bytes == nullptr ? std::string() : std::string(bytes, size);
    };
    KnownSession session;
    if (has(1)) session.exit_code = sqlite3_column_int(statement.get(), 1);
    if (has(2) && has(3)) {
      session.stamp = SessionStamp{sqlite3_column_int64(statement.get(), 2),
                                   sqlite3_column_int64(statement.get(), 3),
                                   sqlite3_column_int64(statement.get(), 7)};
    }
    if (has(4) && has(8)) {
      session.limits = {.force = sqlite3_column_double(statement.get(), 4),
                        .depth = sqlite3_column_double(statement.get(), 8)};
    }
    session.error = text(5);
    session.version = sqlite3_column_int(statement.get(), 6);
    known[text(0)] = session;
  }
  if (result != SQLITE_DONE) Refuse();
  return known;
}

void SqliteTable::Add(std::span<const Json> lines) {
  Execute("BEGIN IMMEDIATE");
  try {
    for (const Json& line : lines) AddRows(line);
    Execute("COMMIT");
  } catch (...) {
    sqlite3_exec(database_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

void SqliteTable::AddRows(const Json& line) {
  const Json& session = line.at("session");
  for (const Statement& statement : deletes_) {
    sqlite3_reset(statement.get());
    Bind(statement.get(), 1, session);
    if (sqlite3_step(statement.get()) != SQLITE_DONE) Refuse();
    sqlite3_reset(statement.get());
  }
  AddRow(inserts_[kSessions], {session}, line);
  int h = 0;
  for (const Json& hand : ListOf(line, "/report/hands")) {
    AddRow(inserts_[kHands], {session, h}, hand);
    int o = 0;
    for (const Json& organ : ListOf(hand, "/organs")) {
      AddRow(inserts_[kContacts], {session, h, o++}, organ);
    }
    ++h;
  }
  int a = 0;
  for (const Json& attachment : ListOf(line, "/report/attachments")) {
    AddRow(inserts_[kAttachments], {session, a++}, attachment);
  }
  for (const auto& [table, place] :
       {std::pair{kExercises, "/report/exercise"}, std::pair{kGoals, "/report/goals"}}) {
    const Json& values = At(line, place);
    if (values.is_object()) AddRow(inserts_[table], {session}, values);
  }
  for (const Json& latency : ListOf(line, "/report/latencies")) {
    const Json& name = At(latency, "/name");
    if (name.is_string()) AddRow(inserts_[kLatencies], {session, name}, latency);
  }
}

void SqliteTable::AddRow(const Insert& insert, const std::vector<Json>& keys, const Json& values) {
  sqlite3_stmt* statement = insert.statement.get();
  sqlite3_reset(statement);
  int at = 0;
  int result = SQLITE_OK;
  for (const Json& key : keys) result |= Bind(statement, ++at, key);
  for (const TableColumn& column : insert.columns) {
    result |= Bind(statement, ++at, At(values, column.place));
  }
  if (result != SQLITE_OK || sqlite3_step(statement) != SQLITE_DONE) Refuse();
  sqlite3_reset(statement);
}

void SqliteTable::Execute(const std::string& sql) {
  if (sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) Refuse();
}

SqliteTable::Statement SqliteTable::Prepare(const std::string& sql) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database_.get(), sql.c_str(), -1, &statement, nullptr) != SQLITE_OK) {
    Refuse();
  }
  return {statement, sqlite3_finalize};
}

void SqliteTable::Refuse() const {
  throw InputError(path_ + ": cannot be used as a table (" + sqlite3_errmsg(database_.get()) +
                   "); choose another --out, or free space and run again to continue");
}

}  // namespace hpdm
