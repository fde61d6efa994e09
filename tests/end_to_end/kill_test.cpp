// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "kill_runs.hpp"

#include "program.hpp"

namespace raybundle::testing {
namespace {

constexpr const char* kImages = "opencv_stereo_chess";

KillOptions calibration_in(const std::filesystem::path& folder) {
  KillOptions options;
  options.program = RAYBUNDLE_PROGRAM;
  options.arguments = {"calibrate",
                       "--target",
                       "chessboard:9x6:25mm",
                       "--camera",
                       "left=" + (real_data(kImages) / "left0*.jpg").string(),
                       "--model",
                       "brown_conrady"};
  options.folder = folder;
  return options;
}

/// A few kills; `./dev prove kill` does 200.
TEST(Killed, LeavesNoHalfFileAndTheNextRunGoesOnFromTheCache) {
  RAYBUNDLE_NEEDS_DATA(kImages);
  KillOptions options = calibration_in(fresh_folder());
  options.kills = 10;
  const KillOutcome outcome = kill_at_random(options);
  for (const std::string& fault : outcome.faults) ADD_FAILURE() << fault;
  EXPECT_EQ(outcome.killed, options.kills);
}

TEST(Killed, ARunDetectsWhatIsNotInTheCacheAndNothingElse) {
  RAYBUNDLE_NEEDS_DATA(kImages);
  const KillOutcome outcome = resume_from_half_a_cache(calibration_in(fresh_folder()));
  for (const std::string& fault : outcome.faults) ADD_FAILURE() << fault;
}

}  // namespace
}  // namespace raybundle::testing
