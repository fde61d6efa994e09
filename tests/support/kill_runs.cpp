// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "kill_runs.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <random>
#include <thread>

#include "text_file.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

// Per run to be killed; about one is to be expected where the machine is twice as fast as when it was timed.
constexpr int kMostFinished = 10;

// Starts the program with its streams closed off and a cache of its own.
pid_t start(const KillOptions& options) {
  std::vector<std::string> words{options.program.string()};
  words.insert(words.end(), options.arguments.begin(), options.arguments.end());
  words.insert(words.end(), {"-o", (options.folder / "output").string()});
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const std::string cache = (options.folder / "cache").string();
  const pid_t child = ::fork();
  if (child != 0) return child;
  const int nothing = ::open("/dev/null", O_RDWR);
  for (const int stream : {0, 1, 2}) ::dup2(nothing, stream);
  ::setenv("XDG_CACHE_HOME", cache.c_str(), 1);
  ::execv(pointers.front(), pointers.data());
  ::_exit(127);
}

int wait_for(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return status;
}

double seconds_of_whole_run(const KillOptions& options, KillOutcome& outcome) {
  const auto begin = Clock::now();
  const int status = wait_for(start(options));
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) outcome.faults.push_back("a run that is left alone fails");
  return Seconds(Clock::now() - begin).count();
}

// Every text of ours ends in one of these.
bool looks_whole(const fs::path& file) {
  std::string text = text_of(file);
  text.erase(text.find_last_not_of(" \n") + 1);
  return text.ends_with('}') || text.ends_with(']') || text.ends_with("</html>");
}

using Times = std::map<fs::path, fs::file_time_type>;

Times cache_entries(const KillOptions& options, KillOutcome& outcome) {
  Times entries;
  std::error_code none;
  for (const auto& entry : fs::recursive_directory_iterator(options.folder / "cache", none)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = entry.path().filename().string();
    if (name.ends_with(".tmp")) {
      ++outcome.temporaries;
      fs::remove(entry.path());
    } else {
      entries[entry.path()] = entry.last_write_time();
      if (!looks_whole(entry.path())) outcome.faults.push_back("half a cache entry: " + name);
    }
  }
  return entries;
}

// What a run has put into an empty cache. Without it nothing that is looked at here could fail.
Times first_cache_entries(const KillOptions& options, KillOutcome& outcome) {
  const Times entries = cache_entries(options, outcome);
  if (entries.empty()) outcome.faults.push_back("a whole run leaves nothing in the cache");
  return entries;
}

void check_kept(const Times& before, const Times& after, KillOutcome& outcome) {
  for (const auto& [entry, time] : before) {
    const auto same = after.find(entry);
    if (same == after.end() || same->second != time) {
      outcome.faults.push_back("detected again: " + entry.filename().string());
    }
  }
}

std::string calibration_of(const KillOptions& options) {
  return text_of(options.folder / "output" / "calibration.json");
}

void check_output(const KillOptions& options, const std::string& calibration, KillOutcome& outcome) {
  int found = 0;
  for (const auto& entry : fs::directory_iterator(options.folder / "output")) {
    const std::string name = entry.path().filename().string();
    if (!looks_whole(entry.path())) outcome.faults.push_back("half a file: " + name);
    if (name.ends_with(".tmp")) {
      ++outcome.temporaries;
      fs::remove(entry.path());
    } else {
      ++found;
    }
  }
  if (found != 3) outcome.faults.push_back("the output holds " + std::to_string(found) + " files, not 3");
  if (calibration_of(options) != calibration) {
    outcome.faults.push_back("calibration.json is not what the same images gave before");
  }
}

}  // namespace

KillOutcome kill_at_random(const KillOptions& options) {
  KillOutcome outcome;
  const fs::path cache = options.folder / "cache";
  fs::create_directories(cache);
  outcome.whole_seconds = seconds_of_whole_run(options, outcome);
  const std::string calibration = calibration_of(options);
  const std::size_t all = first_cache_entries(options, outcome).size();
  const double cached_seconds = seconds_of_whole_run(options, outcome);

  std::mt19937 random(options.seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  while (outcome.killed < options.kills) {
    if (outcome.finished > kMostFinished * options.kills) {
      outcome.faults.push_back("nearly every run is done before it is killed");
      break;
    }
    if (unit(random) < 0.2) fs::remove_all(cache);
    const Times before = cache_entries(options, outcome);
    outcome.resumed += !before.empty() && before.size() < all;
    const double longest = before.size() == all ? cached_seconds : outcome.whole_seconds;
    const pid_t child = start(options);
    std::this_thread::sleep_for(Seconds(longest * unit(random)));
    ::kill(child, SIGKILL);
    const bool killed = WIFSIGNALED(wait_for(child));
    ++(killed ? outcome.killed : outcome.finished);
    check_output(options, calibration, outcome);
    check_kept(before, cache_entries(options, outcome), outcome);
  }
  seconds_of_whole_run(options, outcome);
  check_output(options, calibration, outcome);
  return outcome;
}

KillOutcome resume_from_half_a_cache(const KillOptions& options) {
  KillOutcome outcome;
  fs::create_directories(options.folder / "cache");
  outcome.whole_seconds = seconds_of_whole_run(options, outcome);
  const std::string calibration = calibration_of(options);
  const Times all = first_cache_entries(options, outcome);
  Times kept;
  for (auto entry = all.begin(); kept.size() < all.size() / 2; ++entry) kept.insert(*entry);
  for (const auto& [entry, time] : all) {
    if (!kept.contains(entry)) fs::remove(entry);
  }
  seconds_of_whole_run(options, outcome);
  const Times after = cache_entries(options, outcome);
  check_kept(kept, after, outcome);
  if (after.size() != all.size()) outcome.faults.push_back("not every image is in the cache again");
  check_output(options, calibration, outcome);
  return outcome;
}

}  // namespace raybundle::testing
