#include "render/gl/egl_context.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>

#include "engine/base/error.h"
#include "render/gl/shaders.h"

namespace hpdm {
namespace {

/// The context, or null with the reason where the machine has none.
std::unique_ptr<EglContext> TryContext(std::string* reason) {
  try {
    return std::make_unique<EglContext>();
  } catch (const MachineError& error) {
    *reason = error.what();
    return nullptr;
  }
}

class EglContextTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string reason;
    context_ = TryContext(&reason);
    if (!context_) GTEST_SKIP() << reason;
  }
  std::unique_ptr<EglContext> context_;
};

TEST_F(EglContextTest, IsCoreOpenGl33OrNewerAndNamesItsRenderer) {
  EXPECT_GE(epoxy_gl_version(), 33);
  GLint profile = 0;
  glGetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
  EXPECT_TRUE(profile & GL_CONTEXT_CORE_PROFILE_BIT);
  EXPECT_FALSE(context_->renderer().empty());
  EXPECT_EQ(context_->Failure(), "");
}

TEST_F(EglContextTest, ReportsAGlErrorOnceByName) {
  glEnable(0xFFFF);
  EXPECT_EQ(context_->Failure(), "OpenGL reported GL_INVALID_ENUM");
  EXPECT_EQ(context_->Failure(), "");
}

TEST_F(EglContextTest, EndsWithoutDisturbingAnotherThreadsContext) {
  std::thread other([] {
    std::string reason;
    const auto second = TryContext(&reason);
    ASSERT_TRUE(second) << reason;
    EXPECT_EQ(second->Failure(), "");
  });
  other.join();
  GLuint buffer = 0;
  glGenBuffers(1, &buffer);
  EXPECT_NE(buffer, 0u);
  EXPECT_EQ(context_->Failure(), "");
}

TEST_F(EglContextTest, NoticesThatItIsNotCurrentAndCanBeMadeCurrentAgain) {
  std::string reason;
  auto second = TryContext(&reason);
  ASSERT_TRUE(second) << reason;
  EXPECT_NE(context_->Failure().find("no longer current"), std::string::npos);
  second.reset();
  EXPECT_TRUE(context_->MakeCurrent());
  EXPECT_EQ(context_->Failure(), "");
}

TEST_F(EglContextTest, AShaderThatDoesNotCompileIsNamedWithItsLogInOneLine) {
  const char* vertex = "void main() { gl_Position = vec4(0.0); }\n";
  const char* broken = "out vec4 colour;\nvoid main() { colour = undeclared_name; }\n";
  try {
    ShaderProgram("velvet", {vertex}, {broken});
    FAIL() << "a broken shader compiled";
  } catch (const MachineError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("velvet (fragment)"), std::string::npos) << message;
    EXPECT_NE(message.find("undeclared_name"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(EglContextDeathTest, WithoutADriverTheMessageNamesTheMissingPackages) {
  // Runs in another process: the EGL library reads the list of its drivers only once.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent.json", 1);
        try {
          EglContext context;
          std::exit(0);
        } catch (const MachineError& error) {
          std::fputs(error.what(), stderr);
          std::exit(3);
        }
      },
      testing::ExitedWithCode(3), "libegl-mesa0.*libgl1-mesa-dri");
}

}  // namespace
}  // namespace hpdm
