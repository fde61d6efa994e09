// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <system_error>

#include "exit_code.hpp"
#include "number_flags.hpp"
#include "raybundle/geometry/error.hpp"
#include "terminal.hpp"
#include "usage_error.hpp"
#include "verbs.hpp"

namespace {

using enum raybundle::apps::ExitCode;
using raybundle::apps::say_error;

constexpr const char* kNoMemory =
    "there is not enough memory; use fewer threads (--threads 1), fewer or smaller images, or another machine";

std::string output_failure(const char* why) { return fmt::format("standard output cannot be written: {}", why); }

// What was written to standard output has to have arrived there.
//
// @returns `good`, or after a line on stderr the code for what could not be written
int unless_output_failed(int good) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return good;
  say_error(output_failure(std::strerror(errno)));
  return kIo;
}

// The exit code of the exception that is being handled, after one line on stderr.
int said_exit_code(const CLI::App& app) try { throw; } catch (const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return unless_output_failed(app.exit(error));  // --help and --version
  say_error(raybundle::apps::usage_message(app, error));
  return kWrongUsage;
} catch (const raybundle::apps::GateFailed&) {
  return unless_output_failed(kGateFailed);
} catch (const raybundle::Error& error) {
  say_error(error.what());
  return raybundle::apps::exit_code(error.kind());
} catch (const std::bad_alloc&) {
  say_error(kNoMemory);
  return kIo;
} catch (const cv::Exception& error) {
  const bool memory = error.code == cv::Error::StsNoMem;
  say_error(memory ? kNoMemory : fmt::format("unexpected: {}; this is a bug, please report it", error.what()));
  return memory ? kIo : kSolveFailed;
} catch (const std::system_error& error) {
  const bool output = std::ferror(stdout) != 0;
  say_error(output ? output_failure(error.code().message().c_str()) : error.what());
  return kIo;
} catch (const std::exception& error) {
  say_error(fmt::format("unexpected: {}; this is a bug, please report it", error.what()));
  return kSolveFailed;
}

// An exception that leaves a thread or a destructor ends here: memory that ran out in there is no bug.
[[noreturn]] void end_at_once() {
  const bool memory = [] {
    try {
      if (std::current_exception()) throw;
    } catch (const std::bad_alloc&) {
      return true;
    } catch (...) {
    }
    return false;
  }();
  if (!memory) std::abort();
  std::fputs("raybundle: error: ", stderr);
  std::fputs(kNoMemory, stderr);
  std::fputs("\n", stderr);
  std::_Exit(kIo);
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that grows too large is then an error of writing, which we can say
  std::set_terminate(end_at_once);
  cv::setNumThreads(1);  // images are worked on side by side by our own threads
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // we say ourselves what cannot be read

  CLI::App app{"Raybundle calibrates wide-angle and fisheye cameras, alone, as a stereo head or as a rig."};
  app.set_version_flag("--version", RAYBUNDLE_VERSION);
  app.require_subcommand(1);
  app.footer(
      "First run:  raybundle calibrate --target chessboard:9x6:25mm --camera left='left*.jpg' --camera "
      "right='right*.jpg' --model kannala_brandt -o out\n"
      "Exit codes: 0 done, 1 a quality gate failed, 2 wrong usage, 3 not enough usable data, 4 the solve failed, "
      "5 reading or writing failed, or memory ran out");
  for (auto add_verb : raybundle::apps::kVerbs) add_verb(app);
  raybundle::apps::refuse_endless_numbers(app);

  try {
    app.parse(argc, argv);
    return unless_output_failed(kDone);
  } catch (...) {
    return said_exit_code(app);
  }
}
