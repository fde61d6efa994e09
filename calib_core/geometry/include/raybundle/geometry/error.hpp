// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace raybundle {

/// What went wrong, by what the caller can do about it. The program maps each kind to an exit code, which README lists.
enum class ErrorKind {
  kBadInput,       ///< wrong usage, configuration or file content: mend the input
  kNotEnoughData,  ///< the input is well formed but cannot determine the answer: take more or other images
  kSolveFailed,    ///< the optimisation broke down
  kIo,             ///< reading or writing failed
};

/// Bad input, files and degenerate data. `what()` is one sentence: what is wrong, where, what to do next.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message, std::string where = {})
      : std::runtime_error(where.empty() ? message : where + ": " + message), kind_(kind), where_(std::move(where)) {}

  ErrorKind kind() const { return kind_; }
  const std::string& where() const { return where_; }  ///< file:line, view or field; may be empty

 private:
  ErrorKind kind_;
  std::string where_;
};

}  // namespace raybundle
