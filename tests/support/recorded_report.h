#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/program.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {

/// A session of two simulated hands, recorded once for all tests.
class ReportTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    recorded_ = new ScratchFolder;
    const Outcome run = Hpdm("run " HPDM_SOURCE_DIR
                             "/scenes/two_hands.toml --clock lockstep "
                             "--seconds 6 --no-pictures --out " +
                             Recorded());
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  static void TearDownTestSuite() {
    delete recorded_;
    recorded_ = nullptr;
  }
  static std::string Recorded() { return *recorded_ / "session"; }

  static Outcome Hpdm(const std::string& arguments) {
    const ScratchFolder folder;
    const std::string out = folder / "out", err = folder / "err";
    const int status = std::system(
        (kHpdmProgram + " " + arguments + " >" + out + " 2>" + err + " </dev/null").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadFile(out), ReadFile(err)};
  }
  /// A page of the recorded session, and its figures.
  std::string Page(const std::string& options = "") {
    const Outcome report = Hpdm("report " + Recorded() + " --out " + page_ + " " + options);
    EXPECT_EQ(report.exit_code, 0) << report.err;
    return ReadFile(page_);
  }
  static nlohmann::json Results(const std::string& options = "") {
    return nlohmann::json::parse(Hpdm("report " + Recorded() + " --json " + options).out);
  }

  inline static ScratchFolder* recorded_ = nullptr;
  ScratchFolder folder_;
  std::string page_ = folder_ / "report.html";
};

}  // namespace hpdm
