// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "terminal.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>

namespace raybundle::apps {
namespace {

bool on_terminal() { return isatty(STDERR_FILENO) != 0; }

void say_coloured(const char* colour, const std::string& head, const std::string& message) {
  const bool terminal = on_terminal();
  fmt::print(stderr, "{}{}{}{}\n", terminal ? colour : "", head, terminal ? "\033[0m" : "", message);
}

}  // namespace

void say_error(const std::string& message) { say_coloured("\033[1;31m", "raybundle: error: ", message); }

void say(const std::string& message) { fmt::print(stderr, "{}\n", message); }

void say_warning(const std::string& message) { say_coloured("\033[1;33m", "warning: ", message); }

Progress::Progress(std::string what, int total)
    : what_(std::move(what)), total_(std::max(total, 1)), terminal_(on_terminal()) {
  draw();
}

Progress::~Progress() {
  if (terminal_) fmt::print(stderr, "\r\033[K");
}

void Progress::advance() {
  ++done_;
  draw();
}

void Progress::draw() const {
  if (!terminal_) return;
  constexpr int kWidth = 30;
  const int filled = kWidth * std::min(done_, total_) / total_;
  fmt::print(stderr, "\r{} [{:=<{}}{: <{}}] {}/{}", what_, "", filled, "", kWidth - filled, done_, total_);
  std::fflush(stderr);
}

namespace {

// Characters, not bytes: ° and ± are one each.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

}  // namespace

std::string shell_word(const std::string& text) {
  const auto plain = [](unsigned char c) { return std::isalnum(c) != 0 || std::strchr("_./:,=+@%-", c) != nullptr; };
  if (!text.empty() && std::ranges::all_of(text, plain)) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

std::string text_table(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  }
  const auto numeric = [](const std::string& cell) { return cell.find_first_of("0123456789") < 2; };
  std::string table;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const bool right = numeric(rows.size() > 1 && i < rows[1].size() ? rows[1][i] : row[i]);
      line += right ? fmt::format("{:>{}}  ", row[i], widths[i]) : fmt::format("{:<{}}  ", row[i], widths[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    table += line + "\n";
  }
  return table;
}

}  // namespace raybundle::apps
