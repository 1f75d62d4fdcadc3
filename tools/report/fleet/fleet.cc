#include "tools/report/fleet/fleet.h"

#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>

#include "engine/base/error.h"
#include "tools/report/fleet/session_line.h"
#include "tools/report/fleet/session_search.h"
#include "tools/report/fleet/session_table.h"
#include "tools/shared/child_process.h"
#include "tools/shared/path_text.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

void NameFailure(const std::string& session, const std::string& why) {
  std::fprintf(stderr, "hpdm: %s: %s\n", session.c_str(), why.c_str());
}

std::string FirstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

/// One session's process.
struct Job {
  Job(const std::vector<std::string>& words, const FleetOptions& options)
      : process(words),
        deadline(Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                    std::chrono::duration<double>(options.patience))) {}

  ChildProcess process;
  Clock::time_point deadline;
  std::string session;
  std::optional<SessionStamp> stamp;
};

/// Returns the line of a job that ended in any way.
Json LineOf(const Job& job, int status) {
  const bool exited = WIFEXITED(status);
  Json line = Json::parse(job.process.out(), nullptr, false);
  const std::optional<KnownSession> reported = KnownFrom(line);
  if (exited && reported && reported->exit_code == WEXITSTATUS(status) && !job.process.too_much()) {
    line["session"] = job.session;
    return line;
  }
  if (!exited) {
    return FailedLine(job.session, std::nullopt, job.stamp,
                      Format("its reader was ended by signal %d (%s)", WTERMSIG(status),
                             strsignal(WTERMSIG(status))));
  }
  // The line does not confirm the exit code, so the session is tried again next time.
  const std::string why = FirstLine(job.process.err());
  return FailedLine(
      job.session, std::nullopt, job.stamp,
      why.empty() ? Format("its reader exited with %d and no report", WEXITSTATUS(status)) : why);
}

class Fleet {
 public:
  explicit Fleet(const FleetOptions& options) : options_(options) {
    if (options.table.empty()) return;
    table_ = OpenSessionTable(options.table);
    if (!options.again) known_ = table_->Known();
  }

  FleetSummary Run() {
    const FoundSessions found = FindSessions(options_.folder);
    for (const std::string& why : found.unread) {
      NameFailure(PathText(why), "not searched; make the folder readable");
      ++summary_.failed;
    }
    for (const std::string& log : found.outside) {
      NameFailure(PathText(log), "is a link out of its session folder; skipped");
    }
    summary_.sessions = found.folders.size();
    auto next = found.folders.begin();
    while (next != found.folders.end() || !jobs_.empty()) {
      while (next != found.folders.end() &&
             jobs_.size() < static_cast<std::size_t>(options_.jobs)) {
        Start(*next++);
      }
      Wait();
      Reap();
    }
    return summary_;
  }

 private:
  /// True if nothing about the session has changed, and its log was read to the end or has no
  /// session. A log that could not be opened has no stamp and is tried again.
  bool IsUnchanged(const KnownSession& known, const std::optional<SessionStamp>& stamp) const {
    const bool same_limits = known.exit_code == 0 && known.limits == options_.limits;
    return known.version == kReportVersion && known.stamp && known.stamp == stamp &&
           (same_limits || known.exit_code == 2);
  }

  void Start(const fs::path& folder) {
    const std::string session = SessionName(folder);
    const fs::path whole = fs::absolute(options_.folder) / folder;
    const std::optional<SessionStamp> stamp = StampOf(whole);
    const auto known = known_.find(session);
    if (known != known_.end() && IsUnchanged(known->second, stamp)) {
      if (known->second.exit_code == 0) {
        ++summary_.unchanged;
      } else {
        ++summary_.failed;
        NameFailure(session, known->second.error + " (unchanged)");
      }
      return;
    }
    jobs_.push_back(std::make_unique<Job>(
        std::vector<std::string>{options_.program, "report", "--json-line", "--force-limit",
                                 Format("%.17g", options_.limits.force), "--depth-limit",
                                 Format("%.17g", options_.limits.depth), "--", whole.native()},
        options_));
    jobs_.back()->session = session;
    jobs_.back()->stamp = stamp;
  }

  /// Waits until a job has written output or exceeded its time limit.
  void Wait() {
    std::vector<ChildProcess*> processes;
    Clock::duration patience = std::chrono::hours(1);
    for (const auto& job : jobs_) {
      processes.push_back(&job->process);
      patience = std::min(patience, job->deadline - Clock::now());
      // A process that has closed its outputs is about to end, which Poll does not report.
      if (job->process.silent()) patience = std::min<Clock::duration>(patience, kPause);
    }
    const auto ms = std::chrono::ceil<std::chrono::milliseconds>(patience).count();
    if (!processes.empty()) ChildProcess::Poll(processes, static_cast<int>(std::max<long>(ms, 0)));
  }

  void Reap() {
    for (auto& job : jobs_) {
      std::optional<Json> line;
      if (const std::optional<int> status = job->process.Ended()) {
        line = LineOf(*job, *status);
      } else if (Clock::now() >= job->deadline) {
        job->process.Kill();
        line = FailedLine(
            job->session, std::nullopt, job->stamp,
            Format("took longer than %g s; give it more time with --timeout", options_.patience));
      }
      if (!line) continue;
      Finish(*line);
      job.reset();
    }
    std::erase(jobs_, nullptr);
  }

  void Finish(const Json& line) {
    if (table_) table_->Add({&line, 1});
    if (options_.lines != nullptr) options_.lines->push_back(line);
    if (options_.print_lines) Print(LineText(line) + "\n");
    if (line.at("exit_code") == 0) {
      ++summary_.reported;
    } else {
      ++summary_.failed;
      NameFailure(line.at("session"), line.at("error"));
    }
  }

  static void Print(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() ||
        std::fflush(stdout) != 0) {
      throw InputError("stdout: cannot be written; the table has all sessions so far");
    }
  }

  static constexpr std::chrono::milliseconds kPause{2};

  const FleetOptions& options_;
  std::unique_ptr<SessionTable> table_;
  std::unordered_map<std::string, KnownSession> known_;
  std::vector<std::unique_ptr<Job>> jobs_;
  FleetSummary summary_;
};

}  // namespace

FleetSummary ReportAll(const FleetOptions& options) { return Fleet(options).Run(); }

FleetSummary CollectLines(const std::vector<std::string>& files, const fs::path& table) {
  constexpr std::size_t kLinesTogether = 1000;
  // Checks the files before creating the table. Pipes are accepted; a device may have no end.
  for (const std::string& path : files) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    const bool readable = fs::is_regular_file(status) || fs::is_fifo(status);
    if (path != "-" && (!readable || access(path.c_str(), R_OK) != 0)) {
      throw InputError(path + ": cannot be read; give files with lines of --json-line");
    }
  }
  const std::unique_ptr<SessionTable> to = OpenSessionTable(table);
  std::unordered_map<std::string, KnownSession> known = to->Known();
  FleetSummary summary;
  std::vector<Json> lines;
  for (const std::string& path : files) {
    std::ifstream file;
    if (path != "-") file.open(path, std::ios::binary);
    std::istream& in = path == "-" ? std::cin : file;
    std::string text;
    for (std::size_t number = 1; std::getline(in, text); ++number) {
      Json line = Json::parse(text, nullptr, false);
      const std::optional<KnownSession> reported = KnownFrom(line);
      ++summary.sessions;
      if (!reported) {
        ++summary.failed;
        NameFailure(PathText(path) + ":" + std::to_string(number), "not a line of a session");
        continue;
      }
      if (reported->exit_code == 0) ++summary.reported;
      const auto [kept, is_new] = known.try_emplace(line["session"].get<std::string>(), *reported);
      if (!is_new && !Replaces(*reported, kept->second)) continue;
      kept->second = *reported;
      lines.push_back(std::move(line));
      if (lines.size() < kLinesTogether) continue;
      to->Add(lines);
      lines.clear();
    }
  }
  to->Add(lines);
  return summary;
}

}  // namespace hpdm
