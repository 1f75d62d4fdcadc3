#include "tests/support/browser.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

constexpr char kPage[] = R"html(<!doctype html><title>page</title>
<button id="more" onclick="n.textContent = Number(n.textContent) + 1">more</button>
<p id="n">0</p><input id="name"><p id="colours"></p>
<script>
colours.textContent = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
</script>)html";

class BrowserTest : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = Browser::WhyMissing(); !why.empty()) GTEST_SKIP() << why;
    std::ofstream(folder_ / "page.html") << kPage;
    address_ = "file://" + folder_ / "page.html";
  }
  ScratchFolder folder_;
  std::string address_;
};

TEST_F(BrowserTest, ReadsClicksAndTypes) {
  Browser browser;
  browser.Open(address_);
  browser.Click("#more");
  EXPECT_EQ(browser.Text("#n"), "1");
  browser.Type("#name", "liver");
  EXPECT_EQ(browser.Execute("return [document.title, arguments[0] + 1]", {41}).dump(),
            R"(["page",42])");
  EXPECT_EQ(browser.Execute("return document.getElementById('name').value"), "liver");
  EXPECT_TRUE(browser.WaitFor("document.body"));
  EXPECT_FALSE(browser.WaitFor("false", 0.1));
  EXPECT_TRUE(browser.Errors().empty());
  EXPECT_THROW(browser.Click("#absent"), std::runtime_error);
}

TEST_F(BrowserTest, ReportsErrorsAndRequests) {
  Browser browser;
  browser.Open(address_);
  EXPECT_EQ(browser.Requests(), std::vector<std::string>{address_});
  browser.Execute(
      "setTimeout(() => { throw Error('torn'); }); return new Promise(done => "
      "setTimeout(done, 50))");
  const std::vector<std::string> errors = browser.Errors();
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_NE(errors[0].find("torn"), std::string::npos);
}

TEST_F(BrowserTest, HasWebGlColoursSizesAndPictures) {
  Browser browser(800, 600);
  browser.UseDarkColours(true);
  browser.Open(address_);
  EXPECT_EQ(browser.Text("#colours"), "dark");
  EXPECT_TRUE(
      browser.Execute("return document.createElement('canvas').getContext('webgl2') != null"));
  browser.Resize(390, 844);
  EXPECT_TRUE(browser.WaitFor("screen.width == 390"));
  browser.Screenshot(folder_ / "page.png");
  EXPECT_GT(std::filesystem::file_size(folder_ / "page.png"), 1000u);
}

}  // namespace
}  // namespace hpdm
