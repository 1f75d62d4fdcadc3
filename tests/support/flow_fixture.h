#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/base/error.h"
#include "render/gl/egl_context.h"
#include "tests/support/program.h"

namespace hpdm {

inline const std::filesystem::path kSharedData = kSource.parent_path() / "shared" / "data";
inline const std::string kScene = (kScenes / "liver_palpation.toml").string();

/// The program run on real scenes, as a user does, in a folder of the test's own.
class Flow : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("hpdm_") + test->test_suite_name() + test->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // `before`: shell commands that the program starts after.
  Outcome Hpdm(const std::string& arguments, const std::string& before = "") const {
    const std::string out = folder_ / "stdout", err = folder_ / "stderr";
    const int exit_code =
        Shell(before + kHpdmProgram + " " + arguments + " >" + out + " 2>" + err + " </dev/null");
    return {exit_code, ReadFile(out), ReadFile(err)};
  }
  std::string Folder(const std::string& name) const { return folder_ / name; }

  static std::string WhyNoPicture() {
    try {
      EglContext context;
      return "";
    } catch (const MachineError& error) {
      return error.what();
    }
  }

  std::filesystem::path folder_;
};

#define SKIP_WITHOUT_EGL()                                    \
  if (const std::string why = WhyNoPicture(); !why.empty()) { \
    GTEST_SKIP() << "no picture can be drawn here: " << why;  \
  }

}  // namespace hpdm
