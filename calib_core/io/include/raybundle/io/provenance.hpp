// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace raybundle {

/// Where a result comes from: enough to make it again, or to see why it cannot be made again.
struct Provenance {
  /// A file that went in.
  struct Input {
    std::string path;    ///< as the user gave it
    std::string sha256;  ///< of its bytes, hexadecimal
  };
  std::string command;  ///< what was run
  std::vector<Input> inputs;
  std::vector<std::pair<std::string, std::string>> options;   ///< name, value; defaults too, and --flags as given
  std::vector<std::pair<std::string, std::string>> versions;  ///< program or library, version
};

}  // namespace raybundle
