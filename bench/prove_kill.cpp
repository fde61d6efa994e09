// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// `raybundle calibrate` killed 200 times at random moments: how many of them left anything but whole files. The bar: 0.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "kill_runs.hpp"
#include "real_data.hpp"

int main() {
  namespace fs = std::filesystem;
  const fs::path images = raybundle::testing::real_data("opencv_stereo_chess");
  if (!fs::is_directory(images)) {
    std::fprintf(stderr, "there is no %s: set RAYBUNDLE_DATA to the folder of real data\n", images.c_str());
    return 1;
  }
  raybundle::testing::KillOptions options;
  options.program = RAYBUNDLE_PROGRAM;
  options.arguments = {"calibrate",
                       "--target",
                       "chessboard:9x6:25mm",
                       "--camera",
                       "left=" + (images / "left[0-9][0-9].jpg").string(),
                       "--camera",
                       "right=" + (images / "right[0-9][0-9].jpg").string(),
                       "--model",
                       "brown_conrady"};
  options.folder = fs::temp_directory_path() / ("raybundle_prove_kill_" + std::to_string(::getpid()));
  const raybundle::testing::KillOutcome outcome = raybundle::testing::kill_at_random(options);
  fs::remove_all(options.folder);
  std::printf("a whole run takes %.2f s; %d runs were killed in it, %d were faster than the signal\n",
              outcome.whole_seconds, outcome.killed, outcome.finished);
  std::printf("%d of them began with a cache that a killed run had left, of which there must be some\n",
              outcome.resumed);
  std::printf("whole files left under a temporary name: %d\n", outcome.temporaries);
  for (const std::string& fault : outcome.faults) std::printf("fault: %s\n", fault.c_str());
  const bool reached = outcome.faults.empty() && outcome.resumed > 0;
  std::printf("faults: %zu, bar 0: %s\n", outcome.faults.size(), reached ? "reached" : "MISSED");
  return reached ? 0 : 1;
}
