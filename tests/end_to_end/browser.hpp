// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace raybundle::testing {

/// Chromium's name on this machine; empty when there is none.
std::string browser_name();

/// A headless Chromium, driven through pipes by the DevTools protocol. It ends with this object.
class Browser {
 public:
  /// @param folder  of its profile, which is made
  /// @throws std::runtime_error when it does not start or answer
  explicit Browser(const std::filesystem::path& folder);
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  /// Sends a command and waits for its answer.
  nlohmann::json call(const std::string& method, const nlohmann::json& parameters = nlohmann::json::object());

  /// Loads a page and waits until it has been loaded; forgets the requests and errors of the one before.
  void open(const std::filesystem::path& page);

  /// Value of an expression of JavaScript in the page.
  nlohmann::json evaluate(const std::string& expression);

  void set_window(int width, int height);
  void set_dark(bool dark);
  void click(const std::string& selector);  ///< scrolls to the element and presses the mouse in its middle
  void press(const std::string& key);       ///< as KeyboardEvent.key calls it
  void take_picture(const std::filesystem::path& png);

  std::vector<std::string> requests;  ///< addresses that the page asked for, itself among them
  std::vector<std::string> errors;    ///< exceptions and messages of the console that report one

 private:
  nlohmann::json read_message();
  void note(const nlohmann::json& message);

  pid_t process_ = -1;
  int to_browser_ = -1;
  int from_browser_ = -1;
  int last_id_ = 0;
  bool loaded_ = false;
  std::string session_;
  std::string unread_;
};

}  // namespace raybundle::testing
