// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace raybundle::testing {

/// What is run, and killed, again and again.
struct KillOptions {
  std::filesystem::path program;
  std::vector<std::string> arguments;  ///< without -o
  std::filesystem::path folder;        ///< of the test: output/ and cache/ are made in it
  int kills = 200;                     ///< runs to be killed, apart from those that are done before the signal
  unsigned seed = 1;
};

/// What killing it did.
struct KillOutcome {
  int killed = 0;            ///< runs that the signal ended
  int finished = 0;          ///< runs that were done before it
  int resumed = 0;           ///< runs that began with a cache that earlier ones had filled in part
  int temporaries = 0;       ///< whole files that were left under their temporary name
  double whole_seconds = 0;  ///< of a run without a cache that is left alone
  std::vector<std::string> faults;
};

/// Runs `program arguments -o folder/output` to its end, then kills it at random moments, with its cache empty, half
/// full or full, and looks at what is left each time: every file of the earlier run has to be there and whole, every
/// entry of the cache too, none of which a later run may write again. At the end one run is left alone and has to give
/// the first result again from the cache as it is.
KillOutcome kill_at_random(const KillOptions& options);

/// Goes on from half a cache as after a kill, with nothing left to chance: runs the program to its end, deletes half of
/// its cache and runs it again. It may not write again what was kept, has to bring back what was not, and has to give
/// the same result.
KillOutcome resume_from_half_a_cache(const KillOptions& options);

}  // namespace raybundle::testing
