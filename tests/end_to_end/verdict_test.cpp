// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "program.hpp"
#include "raybundle/io/observations_file.hpp"
#include "synthetic_world.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// Corners of a stereo head, as observations.json.
class Requires : public ::testing::Test {
 protected:
  void SetUp() override {
    SyntheticOptions options = stereo_head();
    options.noise_px = 0.1;
    write_text(place / "corners.json", text_from_observations({synthetic_world(options).problem, {}}));
  }

  ProgramRun calibrate_with(const std::vector<std::string>& demands) {
    std::vector<std::string> words{
        "calibrate", "--observations",        (place / "corners.json").string(), "--model", "kannala_brandt",
        "-o",        (place / "out").string()};
    words.insert(words.end(), demands.begin(), demands.end());
    return raybundle_program(words);
  }

  const fs::path place = fresh_folder();
};

TEST_F(Requires, WhatIsReachedPasses) {
  const ProgramRun run = calibrate_with({"--require", "rms 1 px", "--require", "depth 50 mm at 1 m over 60 deg"});
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  const nlohmann::json verdict = json_of(place / "out" / "report.json")["verdict"];
  EXPECT_EQ(verdict["judgements"].size(), 3u);  // of two cameras and of one pair
  EXPECT_EQ(verdict["grade"], "pass");
}

// Everything has been written when the exit code says no.
TEST_F(Requires, WhatIsMissedEndsWithExitCodeOneAndAdvice) {
  const ProgramRun run = calibrate_with({"--require", "projection 0.001 px"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.out, HasSubstr("fail     projection 0.001 px: camera0"));
  EXPECT_THAT(run.out, HasSubstr("next best views"));
  const nlohmann::json report = json_of(place / "out" / "report.json");
  EXPECT_EQ(report["verdict"]["grade"], "fail");
  EXPECT_EQ(report["next_views"]["views"].size(), 3u);
  EXPECT_TRUE(fs::exists(place / "out" / "report.html"));
}

TEST_F(Requires, ReadsAFileOfGates) {
  write_text(place / "gates.toml", "require = [\"rms 1 px for camera1\"]\n");
  EXPECT_EQ(calibrate_with({"--gates", (place / "gates.toml").string()}).exit_code, 0);
  write_text(place / "gates.toml", "requires = [\"rms 1 px\"]\n");
  const ProgramRun run = calibrate_with({"--gates", (place / "gates.toml").string()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("gates.toml:1"));
  EXPECT_THAT(run.err, HasSubstr("Did you mean \"require\""));
}

// Wrong words are found before the work and leave nothing behind.
TEST_F(Requires, RefusesWhatItDoesNotUnderstand) {
  for (const char* words : {"depth 20 px at 1 m", "sharpness 1 px", "rms 1 px for camera7", ""}) {
    const ProgramRun run = calibrate_with({"--require", words});
    EXPECT_EQ(run.exit_code, 2) << words;
    EXPECT_THAT(run.err, Not(IsEmpty()));
    EXPECT_FALSE(fs::exists(place / "out")) << words;
  }
}

// The page is drawn again from report.json alone; what is no report is refused and leaves no page.
TEST_F(Requires, DrawsThePageAgain) {
  ASSERT_EQ(calibrate_with({}).exit_code, 0);
  const fs::path report = place / "out" / "report.json", page = place / "again.html";
  EXPECT_EQ(raybundle_program({"report", report.string(), "-o", page.string()}).exit_code, 0);
  EXPECT_THAT(text_of(page), HasSubstr("\"raybundle report\""));
  const std::string whole = text_of(report);
  for (const std::string& bad :
       {std::string(), whole.substr(0, whole.size() / 2), std::string("{}"), std::string("[]")}) {
    write_text(place / "bad.json", bad);
    const ProgramRun run =
        raybundle_program({"report", (place / "bad.json").string(), "-o", (place / "bad.html").string()});
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.err, HasSubstr("bad.json"));
    EXPECT_FALSE(fs::exists(place / "bad.html"));
  }
}

}  // namespace
}  // namespace raybundle::testing
