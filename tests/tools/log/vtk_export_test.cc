#include "tools/log/vtk_export.h"

#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "engine/base/error.h"
#include "lcmtypes/analysis/logged_session.h"
#include "tests/support/liver_scene.h"
#include "tests/support/program.h"
#include "tests/support/recorded_session.h"
#include "tests/support/scratch_folder.h"
#include "tools/replay/log_replay.h"

/// `hpdm log export --format vtk`, read with Python's standard library and compared with the
/// engine's own surface.

namespace hpdm {
namespace {

namespace fs = std::filesystem;

const std::string kStone =
    "[[organ]]\nname = \"a stone / far away\"\nmodel = \"rigid\"\n"
    "mesh = \"" HPDM_SOURCE_DIR
    "/scenes/meshes/gallbladder.obj\"\n"
    "pose.position = [0.5, 0.0, 0.0]\n";
const std::string kTwoOrgans = kLiver + kRearSupport + kStone + kPalpatingProbe;

class VtkExportTest : public testing::Test {
 protected:
  void RecordSession(int ticks = 500, int hand_lead_ms = 300) {
    std::ofstream(folder_ / "scene.toml") << kTwoOrgans;
    Record({.scene = folder_ / "scene.toml",
            .log = log_,
            .ticks = ticks,
            .hand_lead_ms = hand_lead_ms});
  }
  /// Returns read_vtk.py's text about the index.
  std::string ReadBack(const fs::path& index) const {
    const std::string out = folder_ / "read.txt";
    EXPECT_EQ(Shell(std::string("/usr/bin/python3 -B ") + HPDM_SOURCE_DIR +
                    "/tests/tools/log/read_vtk.py " + index.string() + " >" + out),
              0);
    return ReadFile(out);
  }

  const ScratchFolder folder_;
  const std::string log_ = folder_ / "session.lcmlog";
};

TEST_F(VtkExportTest, TheLastSurfaceIsTheOneThatAReplayComputes) {
  RecordSession();
  const ExportedSurfaces exported = ExportVtk(log_, folder_ / "vtk");
  Session session(LoadScene(folder_ / "scene.toml"));
  const LogReplay replay = ReplayLog(LoggedSession(log_), 0, &session);
  session.render_scenes->Update();
  const SceneSnapshot& last = session.render_scenes->Front();
  ASSERT_EQ(exported.steps, last.step.number);
  ASSERT_EQ(exported.steps, replay.steps_compared);
  ASSERT_EQ(exported.organs.size(), 2u);
  EXPECT_EQ(exported.organs[0].name, "liver");
  EXPECT_EQ(exported.organs[0].skipped, 0u);
  EXPECT_GT(exported.organs[0].surfaces, 5u);
  EXPECT_LE(exported.organs[1].surfaces, 2u) << "nothing moved it";

  std::istringstream read(ReadBack(exported.index));
  std::string line, time, file, liver;
  int entries = 0;
  for (; std::getline(read, line) && !line.empty(); ++entries) {
    std::istringstream(line) >> time >> file;
    if (file.starts_with("liver_")) liver = file;
  }
  EXPECT_EQ(entries, static_cast<int>(2 * (exported.steps + 1))) << "both organs, and their rest";
  EXPECT_EQ(std::stod(time), static_cast<double>(last.step.time_ns) / 1e9);
  EXPECT_TRUE(file.starts_with("a_stone___far_away_")) << file;

  // The index's last entry is the stone; an index of the liver alone gives the other surface.
  std::ofstream(folder_ / "vtk/liver.pvd") << "<VTKFile><Collection><DataSet timestep=\"0\" file=\""
                                           << liver << "\"/></Collection></VTKFile>";
  std::istringstream surface(ReadBack(folder_ / "vtk/liver.pvd"));
  std::getline(surface, line);
  std::getline(surface, line);
  const auto& engine = last.organs[0].vertices;
  const Points& rest = session.organs()[0].rest().vertices;
  double largest_error = 0, largest_displacement = 0;
  for (Eigen::Index v = 0; v < engine.rows(); ++v) {
    Vector3d position, displacement;
    for (int d = 0; d < 3; ++d) surface >> position[d];
    for (int d = 0; d < 3; ++d) surface >> displacement[d];
    const Vector3d expected = engine.row(v).cast<double>().transpose();
    largest_error = std::max(largest_error, (position - expected).norm());
    largest_error =
        std::max(largest_error, (displacement - (expected - rest.row(v).transpose())).norm());
    largest_displacement = std::max(largest_displacement, displacement.norm());
  }
  EXPECT_LT(largest_error, 1e-7) << "floats of positions up to 0.3 m";
  EXPECT_GT(largest_displacement, 1e-3) << "the probe pressed";
  const Triangles& triangles = session.organs()[0].rest().triangles;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      int corner = -1;
      surface >> corner;
      ASSERT_EQ(corner, triangles(t, k));
    }
  }
  EXPECT_TRUE(surface.good());
}

TEST_F(VtkExportTest, ATimeHasOneSurfaceOfAnOrganAlthoughStepOneBeginsAtZero) {
  RecordSession(100, 0);
  std::istringstream read(ReadBack(ExportVtk(log_, folder_ / "vtk").index));
  std::set<std::string> seen;
  std::string line, time, file;
  while (std::getline(read, line) && !line.empty()) {
    std::istringstream(line) >> time >> file;
    const std::string organ = file.substr(0, file.rfind('_'));
    EXPECT_TRUE(seen.insert(organ + " at " + time).second) << organ << " at " << time;
  }
  EXPECT_TRUE(seen.contains("liver at 0"));
  EXPECT_EQ(seen.size() % 2, 0u) << "both organs";
}

TEST_F(VtkExportTest, AnExportThatIsEndedLeavesNoFile) {
  RecordSession();
  int events = 0;
  EXPECT_THROW(ExportVtk(log_, folder_ / "vtk",
                         [&events] {
                           if (++events == 1000) throw InputError("ended");
                         }),
               InputError);
  EXPECT_TRUE(fs::is_empty(folder_ / "vtk"));
}

TEST_F(VtkExportTest, ALogWithoutOrgansLeavesNoFile) {
  SessionLog(log_, 0).Append("OTHER", 0, {});
  EXPECT_THROW(ExportVtk(log_, folder_ / "vtk"), InputError);
  EXPECT_TRUE(fs::is_empty(folder_ / "vtk"));
}

}  // namespace
}  // namespace hpdm
