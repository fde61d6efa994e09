// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <glog/logging.h>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdlib>
#include <exception>

#include "raybundle/geometry/error.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace {

using raybundle::ErrorKind;

constexpr int kDone = 0, kGateFailed = 1, kWrongUsage = 2, kNotEnoughData = 3, kSolveFailed = 4, kIo = 5;

int exit_code(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kBadInput:
      return kWrongUsage;
    case ErrorKind::kNotEnoughData:
      return kNotEnoughData;
    case ErrorKind::kSolveFailed:
      return kSolveFailed;
    case ErrorKind::kIo:
      return kIo;
  }
  return kSolveFailed;
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);                    // images are worked on side by side by our own threads
  FLAGS_minloglevel = google::GLOG_FATAL;  // Ceres logs each step that it rejects; we report the outcome
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // we say ourselves what cannot be read

  CLI::App app{"Raybundle calibrates wide-angle and fisheye cameras, alone, as a stereo head or as a rig."};
  app.set_version_flag("--version", RAYBUNDLE_VERSION);
  app.require_subcommand(1);
  app.footer(
      "First run:  raybundle calibrate --target chessboard:9x6:25mm --camera left='left*.jpg' --camera "
      "right='right*.jpg' --model kannala_brandt -o out\n"
      "Exit codes: 0 done, 1 a quality gate failed, 2 wrong usage, 3 not enough usable data, 4 the solve failed, "
      "5 reading or writing failed");
  for (auto add_verb : raybundle::apps::kVerbs) add_verb(app);

  try {
    app.parse(argc, argv);
    return kDone;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kWrongUsage;
  } catch (const raybundle::apps::GateFailed&) {
    return kGateFailed;
  } catch (const raybundle::Error& error) {
    raybundle::apps::say_error(error.what());
    return exit_code(error.kind());
  } catch (const std::exception& error) {
    raybundle::apps::say_error(fmt::format("unexpected: {}; this is a bug, please report it", error.what()));
    return kSolveFailed;
  }
}
