// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Command lines that are wrong by themselves, whatever files there are.

#include <gmock/gmock.h>

#include <string>
#include <utility>
#include <vector>

#include "program.hpp"

namespace raybundle::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(BadUsage, UnknownVerbsAndFlags) {
  EXPECT_EQ(raybundle_program({"calibrat"}).exit_code, 2);
  EXPECT_EQ(raybundle_program({"calibrate", "--modell", "pinhole"}).exit_code, 2);
  EXPECT_EQ(raybundle_program({}).exit_code, 2);
  EXPECT_EQ(raybundle_program({"calibrate", "--help"}).exit_code, 0);
}

// Who comes from another program types the name that the lens has there.
TEST(BadUsage, NamesThatOthersHaveForAModelLeadToOurs) {
  const std::pair<const char*, const char*> names[] = {
      {"fisheye", "\"kannala_brandt\""}, {"pinhole-equi", "\"kannala_brandt\""}, {"equi", "\"kannala_brandt\""},
      {"OpenCV8", "\"rational\""},       {"PLUMB_BOB", "\"brown_conrady\""},     {"omni", "\"unified\""}};
  for (const auto& [theirs, ours] : names) {
    const ProgramRun run =
        raybundle_program({"calibrate", "--target", "chessboard:9x6:25mm", "--camera", "a=*.png", "--model", theirs});
    EXPECT_EQ(run.exit_code, 2) << theirs;
    EXPECT_THAT(run.err, HasSubstr(ours)) << theirs;
    EXPECT_THAT(run.err, Not(HasSubstr("Known:"))) << theirs;
  }
}

TEST(BadUsage, FlagsOfTheOtherKindOfDrawingAreRefused) {
  const auto says = [](std::vector<std::string> flags, const char* said) {
    flags.insert(flags.begin(), {"target", "chessboard:9x6:25mm", "-o"});
    const ProgramRun run = raybundle_program(flags);
    EXPECT_EQ(run.exit_code, 2) << said;
    EXPECT_THAT(run.err, HasSubstr(said));
  };
  const std::string folder = fresh_folder().string();
  says({folder + "/b.png", "--paper", "A4"}, "--paper is for a page");
  says({folder + "/b.png", "--margin", "5"}, "--margin is for a page");
  says({folder + "/b.png", "--dpi", "100", "--square-px", "30"}, "--square-px is for a .png without --dpi");
  says({folder + "/b.pdf", "--dpi", "100"}, "--dpi is for .png");
}

// The calibration says what lenses and beams there are.
TEST(BadUsage, ValidateTakesNoFlagsOfWhatItDoesNotAsk) {
  for (const char* flag : {"--model", "--anchor"}) {
    const ProgramRun run = raybundle_program({"validate", "a.json", flag, "pinhole"});
    EXPECT_EQ(run.exit_code, 2) << flag;
    EXPECT_THAT(run.err, HasSubstr(std::string("raybundle validate has no flag '") + flag + "'"));
  }
}

// NaN is within every range that is asked for by comparing.
TEST(NumberFlags, NoneTakesWhatIsNoNumber) {
  const std::vector<std::string> verbs[] = {{"compare", "a.json", "b.json", "--max-px"},
                                            {"eye-safety", "--edition", "1993", "--power"},
                                            {"eye-safety", "--edition", "1993", "--brightest"},
                                            {"validate", "a.json", "--max-rms"},
                                            {"survey", "a.json", "--max-rms"},
                                            {"reconstruct", "stereo", "a.json", "l", "r", "-o", "o", "--near"},
                                            {"reconstruct", "stereo", "a.json", "l", "r", "-o", "o", "--uniqueness"},
                                            {"simulate", "random:1", "-o", "o", "--turn"}};
  for (std::vector<std::string> arguments : verbs) {
    const std::string flag = arguments.back();
    arguments.push_back("nan");
    const ProgramRun run = raybundle_program(arguments);
    EXPECT_EQ(run.exit_code, 2) << flag;
    EXPECT_THAT(run.err, HasSubstr(flag + ": 'nan' must be a number"));
  }
  const ProgramRun negative = raybundle_program({"eye-safety", "--edition", "1993", "--power", "-3"});
  EXPECT_EQ(negative.exit_code, 2);
  EXPECT_THAT(negative.err, HasSubstr("'-3' must be a number above 0"));
}

}  // namespace
}  // namespace raybundle::testing
