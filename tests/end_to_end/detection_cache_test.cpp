// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "detection_cache.hpp"

#include <gmock/gmock.h>

#include <chrono>

#include "program.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using apps::kDaysInCache;
using std::chrono::days;

fs::file_time_type now() { return fs::file_time_type::clock::now(); }

TEST(DetectionCache, ForgetsWhatNoRunHasUsedForLong) {
  const fs::path place = fresh_folder(), cache = place / "cache", entries = cache / "raybundle" / "detections";
  const std::string image = (place / "board.png").string();
  ASSERT_EQ(raybundle_program({"target", "chessboard:9x6:25mm", "-o", image, "--square-px", "30"}).exit_code, 0);
  const auto detect = [&] {
    raybundle_program({"detect", "--target", "chessboard:9x6:25mm", "--camera", "a=" + image, "-o",
                       (place / "observations.json").string()},
                      "", cache);
  };
  const auto names = [&] {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(entries)) found.push_back(entry.path().filename().string());
    return found;
  };
  const auto leave = [&](const char* name, int days_ago) {
    write_text(entries / name, "[");
    fs::last_write_time(entries / name, now() - days(days_ago));
  };
  fs::create_directories(entries);
  leave("old.json", kDaysInCache + 1);
  leave(".killed.json.1.0.tmp", kDaysInCache + 1);
  leave("younger.json", kDaysInCache - 1);
  detect();
  ASSERT_THAT(names(), ::testing::SizeIs(2));
  ASSERT_THAT(names(), ::testing::Contains("younger.json"));

  // What is used counts from then on.
  fs::remove(entries / "younger.json");
  const fs::path mine = entries / names().at(0);
  const std::string content = text_of(mine);
  fs::last_write_time(mine, now() - days(kDaysInCache + 1));
  detect();
  EXPECT_LT(now() - fs::last_write_time(mine), days(1));
  EXPECT_EQ(text_of(mine), content);
}

}  // namespace
}  // namespace raybundle::testing
