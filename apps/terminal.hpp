// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace raybundle::apps {

/// One line on stderr: `raybundle: error: ...`, red on a terminal.
void say_error(const std::string& message);

/// One line on stderr: what the user should know but need not act on.
void say(const std::string& message);

/// One line on stderr: `warning: ...`, yellow on a terminal.
void say_warning(const std::string& message);

/// A progress bar on stderr, drawn only on a terminal. Call advance() from one thread at a time.
class Progress {
 public:
  Progress(std::string what, int total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance();

 private:
  void draw() const;

  std::string what_;
  int total_;
  int done_ = 0;
  bool terminal_;
};

/// A path or a name as one word of a command to be typed: in quotes where the shell would take it apart.
std::string shell_word(const std::string& text);

/// Rows of cells as an aligned text table, the first row being its head; numbers flush right.
std::string text_table(const std::vector<std::vector<std::string>>& rows);

}  // namespace raybundle::apps
