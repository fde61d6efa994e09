// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "browser.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

extern char** environ;

namespace raybundle::testing {
namespace {

constexpr int kPatience_ms = 60000;
constexpr int kCommands = 3, kAnswers = 4;  // the file descriptors that --remote-debugging-pipe speaks on

std::string bytes_from_base64(const std::string& text) {
  std::string bytes(text.size() / 4 * 3, '\0');
  EVP_DecodeBlock(reinterpret_cast<unsigned char*>(bytes.data()), reinterpret_cast<const unsigned char*>(text.data()),
                  static_cast<int>(text.size()));
  return bytes;  // PNG does not mind the one or two zeros that padding leaves at the end
}

pid_t spawn_browser(const std::filesystem::path& folder, int commands, int answers) {
  const std::string profile = "--user-data-dir=" + folder.string();
  std::vector<std::string> words{browser_name(),
                                 "--headless",
                                 "--no-sandbox",
                                 "--hide-scrollbars",
                                 "--no-first-run",
                                 "--use-angle=swiftshader",
                                 "--enable-unsafe-swiftshader",
                                 "--remote-debugging-pipe",
                                 profile};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, commands, kCommands);
  posix_spawn_file_actions_adddup2(&actions, answers, kAnswers);
  const std::string log = (folder / "browser.log").string();
  posix_spawn_file_actions_addopen(&actions, 2, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  pid_t process = -1;
  const int failed = posix_spawnp(&process, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed) throw std::runtime_error("the browser does not start");
  return process;
}

// A pipe whose ends are not inherited and lie above the two descriptors that the browser is given.
std::array<int, 2> high_pipe() {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
  for (int& end : ends) {
    const int high = fcntl(end, F_DUPFD_CLOEXEC, 10);
    close(end);
    end = high;
  }
  return ends;
}

}  // namespace

std::string browser_name() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
    if (std::system(fmt::format("command -v {} >/dev/null", name).c_str()) == 0) return name;
  }
  return {};
}

Browser::Browser(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  signal(SIGPIPE, SIG_IGN);  // a browser that died is reported by the command that it does not answer
  const std::array<int, 2> commands = high_pipe(), answers = high_pipe();
  process_ = spawn_browser(folder, commands[0], answers[1]);
  close(commands[0]);
  close(answers[1]);
  to_browser_ = commands[1];
  from_browser_ = answers[0];
  const auto target = call("Target.createTarget", {{"url", "about:blank"}});
  session_ = call("Target.attachToTarget", {{"targetId", target["targetId"]}, {"flatten", true}})["sessionId"];
  for (const char* domain : {"Page.enable", "Runtime.enable", "Network.enable", "Log.enable"}) call(domain);
}

Browser::~Browser() {
  close(to_browser_);  // it ends when nobody speaks to it any more
  close(from_browser_);
  kill(process_, SIGTERM);
  waitpid(process_, nullptr, 0);
}

nlohmann::json Browser::read_message() {
  std::size_t end = unread_.find('\0');
  while (end == std::string::npos) {
    pollfd ready{from_browser_, POLLIN, 0};
    std::array<char, 65536> buffer;
    const ssize_t got = poll(&ready, 1, kPatience_ms) > 0 ? read(from_browser_, buffer.data(), buffer.size()) : 0;
    if (got <= 0) throw std::runtime_error("the browser does not answer; see browser.log in its folder");
    unread_.append(buffer.data(), static_cast<std::size_t>(got));
    end = unread_.find('\0');
  }
  auto message = nlohmann::json::parse(unread_.substr(0, end));
  unread_.erase(0, end + 1);
  note(message);
  return message;
}

void Browser::note(const nlohmann::json& message) {
  const std::string method = message.value("method", "");
  if (method == "Network.requestWillBeSent") requests.push_back(message["params"]["request"]["url"]);
  if (method == "Page.loadEventFired") loaded_ = true;
  if (method == "Runtime.exceptionThrown") errors.push_back(message["params"]["exceptionDetails"].dump());
  if (method == "Log.entryAdded" && message["params"]["entry"]["level"] == "error") {
    errors.push_back(message["params"]["entry"]["text"]);
  }
}

nlohmann::json Browser::call(const std::string& method, const nlohmann::json& parameters) {
  nlohmann::json command{{"id", ++last_id_}, {"method", method}, {"params", parameters}};
  if (!session_.empty()) command["sessionId"] = session_;
  const std::string text = command.dump() + '\0';
  if (write(to_browser_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    throw std::runtime_error("the browser does not listen");
  }
  while (true) {
    const nlohmann::json message = read_message();
    if (message.value("id", 0) != last_id_) continue;
    if (message.contains("error")) throw std::runtime_error(method + ": " + message["error"].dump());
    return message["result"];
  }
}

void Browser::open(const std::filesystem::path& page) {
  requests.clear();
  errors.clear();
  loaded_ = false;
  call("Page.navigate", {{"url", "file://" + page.string()}});
  while (!loaded_) read_message();
}

nlohmann::json Browser::evaluate(const std::string& expression) {
  const auto answer =
      call("Runtime.evaluate", {{"expression", expression}, {"returnByValue", true}, {"awaitPromise", true}});
  if (answer.contains("exceptionDetails")) throw std::runtime_error(expression + ": " + answer.dump());
  return answer["result"].value("value", nlohmann::json());
}

void Browser::set_window(int width, int height) {
  call("Emulation.setDeviceMetricsOverride",
       {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
}

void Browser::set_dark(bool dark) {
  const nlohmann::json scheme{{"name", "prefers-color-scheme"}, {"value", dark ? "dark" : "light"}};
  call("Emulation.setEmulatedMedia", {{"features", {scheme}}});
}

void Browser::click(const std::string& selector) {
  const auto place = evaluate(fmt::format(
      "(() => {{ const e = document.querySelector({}); e.scrollIntoView({{behavior: 'instant', block: 'center'}});"
      " const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; }})()",
      nlohmann::json(selector).dump()));
  for (const char* type : {"mousePressed", "mouseReleased"}) {
    call("Input.dispatchMouseEvent",
         {{"type", type}, {"x", place[0]}, {"y", place[1]}, {"button", "left"}, {"clickCount", 1}});
  }
}

void Browser::press(const std::string& key) {
  for (const char* type : {"keyDown", "keyUp"}) call("Input.dispatchKeyEvent", {{"type", type}, {"key", key}});
}

void Browser::take_picture(const std::filesystem::path& png) {
  const std::string picture = call("Page.captureScreenshot", {{"format", "png"}})["data"];
  std::ofstream(png, std::ios::binary) << bytes_from_base64(picture);
}

}  // namespace raybundle::testing
