#include "tests/support/browser.h"

#include <httplib.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace hpdm {
namespace {

using nlohmann::json;
using std::chrono::steady_clock;

bool InPath(const char* program) {
  const std::string command = std::string("command -v ") + program + " >/dev/null 2>&1";
  return std::system(command.c_str()) == 0;
}

std::string FromBase64(const std::string& text) {
  const auto value = [](char c) -> int {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
  };
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    if (value(c) < 0) continue;
    bits = bits << 6 | static_cast<unsigned>(value(c));
    if ((count += 6) >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 0xff);
  }
  return bytes;
}

// Starts chromedriver on a free port, which it prints. In a process group of its own, so that its
// browser ends with it.
int StartDriver(pid_t* pid) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  *pid = fork();
  if (*pid == 0) {
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    dup2(ends[1], STDOUT_FILENO);
    dup2(ends[1], STDERR_FILENO);
    close(ends[0]);
    close(ends[1]);
    execlp("chromedriver", "chromedriver", "--port=0", nullptr);
    _exit(127);
  }
  close(ends[1]);
  std::string text, word = "successfully on port ";
  char c;
  while (read(ends[0], &c, 1) == 1) {
    text += c;
    const std::size_t at = text.find(word);
    if (at != std::string::npos && (c == '.' || c == '\n')) {
      const int port = std::atoi(text.c_str() + at + word.size());
      if (port > 0) {
        // Whatever else it prints has a reader, or else it would end.
        std::thread([end = ends[0]] {
          char ignored[256];
          while (read(end, ignored, sizeof ignored) > 0) {
          }
          close(end);
        }).detach();
        return port;
      }
    }
  }
  close(ends[0]);
  throw std::runtime_error("chromedriver does not start: " + text);
}

}  // namespace

std::string Browser::WhyMissing() {
  if (!InPath("chromium")) return "no chromium here (package chromium)";
  if (!InPath("chromedriver")) return "no chromedriver here (package chromium-driver)";
  return {};
}

Browser::Browser(int width, int height, const std::vector<std::string>& arguments) {
  const int port = StartDriver(&pid_);
  driver_ = std::make_unique<httplib::Client>("127.0.0.1", port);
  driver_->set_read_timeout(60);
  driver_->set_keep_alive(true);
  driver_->set_tcp_nodelay(true);
  json all = {"--headless=new",
              "--no-sandbox",
              "--disable-gpu",
              "--use-angle=swiftshader",
              "--enable-unsafe-swiftshader",
              "--disable-dev-shm-usage",
              "--hide-scrollbars",
              "--no-first-run",
              "--disable-background-networking",
              "--disable-component-update",
              "--window-size=" + std::to_string(width) + "," + std::to_string(height)};
  for (const std::string& argument : arguments) all.push_back(argument);
  const json capabilities = {{"browserName", "chrome"},
                             {"goog:loggingPrefs", {{"browser", "ALL"}, {"performance", "ALL"}}},
                             {"goog:chromeOptions",
                              {{"binary", "/usr/bin/chromium"},
                               {"args", all},
                               {"perfLoggingPrefs", {{"enablePage", false}}}}}};
  session_ = Command("/session", {{"capabilities", {{"alwaysMatch", capabilities}}}})
                 .at("sessionId")
                 .get<std::string>();
  Resize(width, height);
  UseDarkColours(false);
}

Browser::~Browser() {
  if (!session_.empty()) driver_->Delete("/session/" + session_);
  if (pid_ > 0) {
    kill(-pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
}

json Browser::Command(const std::string& path, const json& body) {
  const std::string full = session_.empty() ? path : "/session/" + session_ + path;
  const httplib::Result result = driver_->Post(full, body.dump(), "application/json");
  if (!result) throw std::runtime_error(full + ": " + httplib::to_string(result.error()));
  const json answer = json::parse(result->body, nullptr, false);
  if (answer.is_discarded()) throw std::runtime_error(full + ": " + result->body);
  const json value = answer.value("value", json());
  if (result->status != 200) {
    throw std::runtime_error(full + ": " + value.value("message", result->body));
  }
  return value;
}

json Browser::DevTools(const std::string& command, const json& parameters) {
  return Command("/goog/cdp/execute", {{"cmd", command}, {"params", parameters}});
}

void Browser::Open(const std::string& url) { Command("/url", {{"url", url}}); }

json Browser::Execute(const std::string& script, const json& arguments) {
  return Command("/execute/sync", {{"script", script}, {"args", arguments}});
}

bool Browser::WaitFor(const std::string& expression, double seconds) {
  const auto end = steady_clock::now() + std::chrono::duration<double>(seconds);
  do {
    const json value = Execute("return Boolean(" + expression + ")");
    if (value.is_boolean() && value.get<bool>()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  } while (steady_clock::now() < end);
  return false;
}

std::string Browser::Element(const std::string& selector) {
  const json element = Command("/element", {{"using", "css selector"}, {"value", selector}});
  return element.begin().value().get<std::string>();  // its only member
}

std::string Browser::Text(const std::string& selector) {
  return Execute("return document.querySelector(arguments[0]).innerText", {selector})
      .get<std::string>();
}

void Browser::Click(const std::string& selector) {
  Command("/element/" + Element(selector) + "/click", json::object());
}

void Browser::Type(const std::string& selector, const std::string& text) {
  Command("/element/" + Element(selector) + "/value", {{"text", text}});
}

void Browser::Resize(int width, int height) {
  DevTools("Emulation.setDeviceMetricsOverride", {{"width", width},
                                                  {"height", height},
                                                  {"deviceScaleFactor", width < 600 ? 2 : 1},
                                                  {"mobile", width < 600}});
}

void Browser::UseDarkColours(bool dark) {
  DevTools(
      "Emulation.setEmulatedMedia",
      {{"features", {{{"name", "prefers-color-scheme"}, {"value", dark ? "dark" : "light"}}}}});
}

void Browser::Screenshot(const std::string& path, bool whole_page) {
  const json picture = DevTools("Page.captureScreenshot",
                                {{"format", "png"}, {"captureBeyondViewport", whole_page}});
  const std::string bytes = FromBase64(picture.at("data").get<std::string>());
  std::ofstream(path, std::ios::binary) << bytes;
}

json Browser::Log(const std::string& type) { return Command("/se/log", {{"type", type}}); }

std::vector<std::string> Browser::Errors() {
  std::vector<std::string> errors;
  for (const json& entry : Log("browser")) {
    if (entry.value("level", "") == "SEVERE") errors.push_back(entry.value("message", ""));
  }
  return errors;
}

std::vector<std::string> Browser::Requests() {
  std::vector<std::string> addresses;
  for (const json& entry : Log("performance")) {
    const json message = json::parse(entry.value("message", ""), nullptr, false);
    if (message.is_discarded()) continue;
    const json& event = message.at("message");
    if (event.value("method", "") != "Network.requestWillBeSent") continue;
    const std::string url = event.at("params").at("request").at("url").get<std::string>();
    if (!url.starts_with("data:") && !url.starts_with("blob:")) addresses.push_back(url);
  }
  return addresses;
}

}  // namespace hpdm
