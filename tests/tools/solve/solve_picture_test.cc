#include "tools/solve/solve_picture.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "engine/base/error.h"
#include "render/gl/egl_context.h"
#include "render/image/image_file.h"
#include "tests/support/scratch_folder.h"
#include "tools/session/session.h"
#include "tools/shared/surface_table.h"

namespace hpdm {
namespace {

const std::string kSource = HPDM_SOURCE_DIR;
const std::string kCase = kSource + "/scenes/cases/liver_press.toml";
const std::string kReference = kSource + "/tests/reference/liver_press.csv";

std::string RefusalOf(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SolvePicture, ShowsTheSolvedShapeAndNamesItsScale) {
  try {
    EglContext();
  } catch (const MachineError& error) {
    GTEST_SKIP() << error.what();
  }
  const ScratchFolder folder;
  const StaticCase load_case = LoadStaticCase(kCase);
  const Points solved = ReadReferenceDisplacements(kReference, load_case.rest);
  const double largest = solved.rowwise().norm().maxCoeff();

  const SolvedColours displaced =
      WriteSolvedPicture(folder.path() / "u.png", load_case, solved, nullptr);
  EXPECT_FALSE(displaced.error);
  EXPECT_GE(displaced.full_scale, largest);
  EXPECT_LE(displaced.full_scale, 2.5 * largest);  // the next of 1, 2, 5, 10
  const SolvedColours exact =
      WriteSolvedPicture(folder.path() / "error.png", load_case, solved, &solved);
  EXPECT_TRUE(exact.error);

  const Image image = ReadPng(folder.path() / "u.png");
  EXPECT_EQ(image.width, 640);
  EXPECT_EQ(image.height, 480);
  EXPECT_NE(image.rgb, ReadPng(folder.path() / "error.png").rgb);
}

TEST(Reference, AReferenceForAnotherMeshOrPoseIsRefusedInOneLine) {
  const ScratchFolder folder;
  const SurfaceMesh rest = LoadStaticCase(kCase).rest;
  SurfaceTable table = ReadSurfaceTable(kReference);
  const std::string moved = folder.path() / "moved.csv", fewer = folder.path() / "fewer.csv";
  table.positions.col(0).array() += 0.01;
  WriteSurfaceTable(moved, table);
  EXPECT_EQ(RefusalOf([&] { ReadReferenceDisplacements(moved, rest); }),
            moved +
                ": its vertices are off the organ's by up to 10.0 mm; give the reference of "
                "the same mesh in the same pose");
  WriteSurfaceTable(fewer, {table.positions.topRows(5), table.displacements.topRows(5)});
  EXPECT_EQ(RefusalOf([&] { ReadReferenceDisplacements(fewer, rest); }),
            fewer + ": has 5 vertices, the organ " + std::to_string(rest.vertices.rows()) +
                "; give the reference of the same mesh");
}

TEST(Reference, GoesToTheOrganThatIsNamedOrToTheOnlyOne) {
  for (const std::string& argument : {kReference, "liver=" + kReference}) {
    Session session(LoadScene(kCase));
    EXPECT_EQ(session.OrganVisuals()[0].reference, nullptr);
    session.LoadReference(argument);
    const OrganVisual view = session.OrganVisuals()[0];
    ASSERT_NE(view.reference, nullptr);
    EXPECT_EQ(view.reference->rows(), view.rest->vertices.rows());
    // A quarter of the largest displacement, 5.2 mm, rounded up.
    EXPECT_DOUBLE_EQ(view.error_scale, 0.002);
  }
}

}  // namespace
}  // namespace hpdm
