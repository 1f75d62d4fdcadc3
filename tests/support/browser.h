#pragma once

#include <sys/types.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace httplib {
class Client;
}

namespace hpdm {

/// A headless Chromium that a test reads and clicks, through chromedriver (W3C WebDriver) on a free
/// port of the loopback. Its WebGL is SwiftShader's, on the processor. A failed command throws
/// std::runtime_error with the driver's message. One thread.
class Browser {
 public:
  /// Returns the reason why no browser can be started here; empty if one can.
  static std::string WhyMissing();

  /// A window of `width` x `height` CSS pixels, light. `arguments` are further ones of Chromium.
  explicit Browser(int width = 1280, int height = 900,
                   const std::vector<std::string>& arguments = {});
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  /// Loads a page (http:// or file://) and waits until it and its scripts have loaded.
  void Open(const std::string& url);
  /// Runs JavaScript in the page, `arguments` in it, and gives what it returns (a promise's value).
  nlohmann::json Execute(const std::string& script,
                         const nlohmann::json& arguments = nlohmann::json::array());
  /// Waits until the expression is true, checked every 50 ms; false after `seconds`.
  bool WaitFor(const std::string& expression, double seconds = 10);

  /// Visible text of the first element that a CSS selector names.
  std::string Text(const std::string& selector);
  /// Scrolls to the element and clicks its middle, as a hand does: refused where another covers it.
  void Click(const std::string& selector);
  /// Types into the element.
  void Type(const std::string& selector, const std::string& text);

  /// Emulates a screen of so many CSS pixels; a narrow one as a phone's.
  void Resize(int width, int height);
  void UseDarkColours(bool dark);
  /// The visible part, or the whole page, as PNG.
  void Screenshot(const std::string& path, bool whole_page = false);

  /// Since the last call: uncaught errors and the console's messages of level "error", failed
  /// requests among them.
  std::vector<std::string> Errors();
  /// Since the last call: addresses the browser asked for, but "data:" and "blob:".
  std::vector<std::string> Requests();

 private:
  nlohmann::json Command(const std::string& path, const nlohmann::json& body);
  nlohmann::json DevTools(const std::string& command, const nlohmann::json& parameters);
  nlohmann::json Log(const std::string& type);
  std::string Element(const std::string& selector);

  pid_t pid_ = -1;  // process id of chromedriver, which leads a process group
  std::unique_ptr<httplib::Client> driver_;
  std::string session_;
};

}  // namespace hpdm
