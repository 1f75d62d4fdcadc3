#include "tools/plots/python_plot.h"

#include <gtest/gtest.h>

#include "tools/shared/child_process.h"

namespace hpdm {
namespace {

TEST(PythonPlot, AScriptThatEndsWellSaysNothing) {
  EXPECT_EQ(RunPlotScript("import sys; sys.exit(sys.argv[1] != 'a b')", {"a b"}), "");
}

TEST(PythonPlot, MatplotlibIsMentionedOnlyIfItIsMissing) {
  const bool installed = RunChild({"/usr/bin/python3", "-c",
                                   "import importlib; importlib.import_module('matplotlib')"}) == 0;
  const std::string remark = RunPlotScript("raise OSError('no space')", {});
  EXPECT_EQ(remark.find("matplotlib") == std::string::npos, installed) << remark;
  EXPECT_EQ(remark.find("free space") != std::string::npos, installed) << remark;
}

}  // namespace
}  // namespace hpdm
