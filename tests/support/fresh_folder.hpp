// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace raybundle {

/// Another empty folder of the running test, removed when the tests end.
inline std::filesystem::path fresh_folder() {
  struct RemovedAtExit {
    std::vector<std::filesystem::path> folders;
    ~RemovedAtExit() {
      std::error_code ignored;
      for (const auto& folder : folders) std::filesystem::remove_all(folder, ignored);
    }
  };
  static RemovedAtExit all;
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string("raybundle_") + test->test_suite_name() + "_" + test->name() + "_" +
                     std::to_string(getpid()) + "_" + std::to_string(all.folders.size());
  for (char& c : name) c = c == '/' ? '_' : c;
  std::filesystem::path folder = std::filesystem::temp_directory_path() / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  all.folders.push_back(folder);
  return folder;
}

}  // namespace raybundle
