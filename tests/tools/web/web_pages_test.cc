#include "tools/web/web_pages.h"

#include <gtest/gtest.h>

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "tests/support/read_file.h"

namespace hpdm {
namespace {

/// The list is the one in tools/web/build.mjs.
std::string HashOfSources() {
  std::map<std::string, std::string> sources;
  for (const auto& entry : std::filesystem::directory_iterator(HPDM_SOURCE_DIR "/tools/web/src")) {
    sources[entry.path().filename().string()] = ReadFile(entry.path());
  }
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const auto& [name, text] : sources) {
    for (const char c : name + text) {
      hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001b3u;
    }
  }
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016" PRIx64, hash);
  return digits;
}

TEST(WebPages, AreBuiltFromTheSourcesBesideThem) {
  const std::string stamp = "<!-- sources " + HashOfSources() + " -->";
  EXPECT_NE(DashboardPage().find(stamp), std::string_view::npos)
      << "run: cd tools/web && npm ci && npm run build";
  EXPECT_NE(ReportPage().find(stamp), std::string_view::npos);
}

TEST(WebPages, AreTheCommittedFilesAndAskForNothingElse) {
  for (const auto& [page, name] :
       {std::pair{DashboardPage(), "dashboard.html"}, std::pair{ReportPage(), "report.html"}}) {
    EXPECT_EQ(page, ReadFile(std::string(HPDM_SOURCE_DIR "/tools/web/built/") + name));
    for (const char* reference : {" src=\"", "<link", "@import", "url(http"}) {
      EXPECT_EQ(page.find(reference), std::string_view::npos) << name << ": " << reference;
    }
  }
}

}  // namespace
}  // namespace hpdm
