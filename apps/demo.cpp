// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "calibrate_job.hpp"
#include "raybundle/geometry/error.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

constexpr const char* kPackagedImages = "/usr/share/doc/opencv-doc/examples/data";

struct DemoFlags {
  std::string images = kPackagedImages;
  std::string output = "raybundle-demo";
};

// The squares of that board were never published; 25 mm gives the baseline a plausible scale.
constexpr const char* kBoard = "chessboard:9x6:25mm";

void run(const DemoFlags& flags, const std::string& program) {
  if (!std::filesystem::exists(std::filesystem::path(flags.images) / "left01.jpg")) {
    throw Error(ErrorKind::kIo,
                fmt::format("{} holds no left01.jpg; run ./dev demo, which unpacks Debian's package opencv-doc, or say "
                            "with --images where its examples/data are",
                            flags.images));
  }
  const std::string left = flags.images + "/left[0-9][0-9].jpg", right = flags.images + "/right[0-9][0-9].jpg";
  CalibrateJob job;
  job.input.target = kBoard;
  job.input.cameras = {"left=" + left, "right=" + right};
  job.input.models = {"brown_conrady"};
  job.output = flags.output;
  job.command = "raybundle demo";
  job.next =
      fmt::format("{} target {} -o board.pdf    # print it, and calibrate a camera of your own", program, kBoard);
  fmt::print(
      "raybundle calibrate --target {} \\\n    --camera left='{}' --camera right='{}' \\\n    --model {} -o {}\n\n",
      kBoard, left, right, job.input.models.front(), job.output);
  run_calibration(job);
}

}  // namespace

void add_demo_verb(CLI::App& app) {
  auto flags = std::make_shared<DemoFlags>();
  CLI::App* verb = app.add_subcommand("demo", "calibrate a real stereo rig from real images");
  verb->add_option("--images", flags->images, "the folder of opencv-doc's examples/data")
      ->type_name("DIR")
      ->capture_default_str();
  verb->add_option("-o,--output", flags->output, "folder to write")->type_name("DIR")->capture_default_str();
  verb->footer("Example:\n  raybundle demo --images build/demo/images -o build/demo/result");
  verb->callback([flags, &app] { run(*flags, app.get_name()); });
}

}  // namespace raybundle::apps
