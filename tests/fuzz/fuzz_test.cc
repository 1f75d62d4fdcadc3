#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "lcmtypes/wire/message_schema.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/seeds.h"

// The inputs that libFuzzer begins with, and those that once broke a reader, in every build.
namespace hpdm::fuzz {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = fs::path(HPDM_SOURCE_DIR) / "tests/fuzz";

std::vector<std::uint8_t> Read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<fs::path> Files(const fs::path& folder) {
  std::vector<fs::path> files;
  if (!fs::is_directory(folder)) return files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

class FuzzTarget : public testing::TestWithParam<Target> {};

TEST_P(FuzzTarget, TakesEverySeed) {
  const std::vector<fs::path> files = Files(kFolder / "corpus" / GetParam().name);
  EXPECT_FALSE(files.empty());
  for (const fs::path& file : files) {
    EXPECT_NO_THROW(EXPECT_TRUE(GetParam().run(Read(file)))) << file;
    // tools/fuzz.sh cuts longer ones off.
    EXPECT_LT(fs::file_size(file), 4096u) << file;
  }
}

TEST_P(FuzzTarget, KeepsItsPromiseForEveryEarlierFinding) {
  for (const fs::path& file : Files(kFolder / "findings" / GetParam().name)) {
    EXPECT_NO_THROW(GetParam().run(Read(file))) << file;
  }
}

TEST_P(FuzzTarget, RefusesEmptyInput) { EXPECT_FALSE(GetParam().run({})); }

INSTANTIATE_TEST_SUITE_P(All, FuzzTarget, testing::ValuesIn(kTargets),
                         [](const auto& target) { return std::string(target.param.name); });

// A changed message type has another hash, so its old seed would be refused. HPDM_WRITE_SEEDS=1
// writes the seeds again.
TEST(FuzzSeeds, BinarySeedsAreOfTheCurrentTypes) {
  for (const Seed& seed : BinarySeeds()) {
    const fs::path path = kFolder / "corpus" / seed.target / seed.name;
    if (std::getenv("HPDM_WRITE_SEEDS") != nullptr) {
      fs::create_directories(path.parent_path());
      std::ofstream(path, std::ios::binary)
          .write(reinterpret_cast<const char*>(seed.bytes.data()),
                 static_cast<std::streamsize>(seed.bytes.size()));
    }
    EXPECT_TRUE(Read(path) == seed.bytes)
        << path << ": HPDM_WRITE_SEEDS=1 fuzz_test writes it anew";
  }
}

TEST(FuzzSeeds, EveryMessageHasASeed) {
  const std::vector<Seed> seeds = BinarySeeds();
  for (const char* type : {"tool_t", "force_t", "contact_t", "organ_t", "mesh_t", "stats_t",
                           "event_t", "device_t", "exercise_t", "teacher_t"}) {
    EXPECT_EQ(std::count_if(seeds.begin(), seeds.end(),
                            [&](const Seed& seed) {
                              const LcmStruct* found = MessageSchemas::Hpdm().Find(seed.bytes);
                              return seed.target == "Message" && found != nullptr &&
                                     found->name == std::string("hpdm.") + type;
                            }),
              1)
        << type;
  }
}

}  // namespace
}  // namespace hpdm::fuzz
