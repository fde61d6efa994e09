// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <optional>

#include "image_files.hpp"
#include "laser_frame_files.hpp"
#include "output_folder.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "reconstruct.hpp"
#include "stereo_cabin.hpp"
#include "stereo_exposure.hpp"
#include "stereo_flags.hpp"
#include "stereo_frame_files.hpp"
#include "stereo_page.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

struct Flags {
  std::string calibration, left, right, output, vehicle;
  std::vector<double> exposure;  // shutter [ms], gain
  StereoFlags stereo;
  bool json = false;
};

GreyView view_of(const cv::Mat& grey) {
  return {grey.data, grey.cols, grey.rows, static_cast<std::ptrdiff_t>(grey.step[0])};
}

/// Takes pairs one after the other and writes what they say.
class Reconstruction {
 public:
  explicit Reconstruction(const Flags& flags) : flags_(flags), setup_(stereo_setup(flags.calibration, flags.stereo)) {
    require_writable(flags.output);
    if (!flags.vehicle.empty()) cabin_.emplace(read_stereo_cabin(flags.vehicle), setup_.matcher.rectification());
    if (!flags.exposure.empty()) exposure_.emplace(setup_.left.camera.size, flags.exposure);
    for (const std::string& line : setup_.said) say(line);
    if (flags.json) return;
    fmt::print("{:<16} {:>8} {:>8} {:>9} {:>10}  {}\n", "frame", "points", "matched", "depth m", "sigma mm", "state");
  }

  void take(const std::string& name, const cv::Mat& left, const cv::Mat& right, const std::string& left_path,
            const std::string& right_path) {
    require_size(left, setup_.left.camera.size, left_path);
    require_size(right, setup_.right.camera.size, right_path);
    const StereoFrame frame = setup_.matcher.process(view_of(left), view_of(right));
    nlohmann::ordered_json more = nlohmann::ordered_json::object();
    if (cabin_) more["cabin"] = cabin_->take(frame);
    if (exposure_) more["exposure"] = exposure_->advise(view_of(left));
    const StereoFrameFiles files = stereo_frame_files(frame, setup_.matcher, left_path, right_path, more);
    const fs::path folder(flags_.output);
    write_results(folder, {{folder / (name + "_left.png"), files.left_png},
                           {folder / (name + "_right.png"), files.right_png},
                           {folder / (name + "_disparity.png"), files.disparity_png},
                           {folder / (name + "_depth.png"), files.depth_png},
                           {folder / (name + ".ply"), files.ply},
                           {folder / (name + ".json"), files.json}});
    if (std::ssize(page_) < kMostPageFrames) {
      page_.push_back(stereo_page_frame(name, frame));
      if (cabin_) page_.back().update({{"drawn", cabin_->drawn()}, {"cabin", cabin_->words()}});
    }
    flags_.json ? static_cast<void>(fmt::print("{}", files.json)) : print_row(name, frame);
    std::fflush(stdout);
    if (frame.state != State::kOk) {
      say_warning(fmt::format("{}: only {:.1f} % of what both cameras show was matched", name,
                              100.0 * frame.disparity.matched / std::max(1, setup_.matcher.covered())));
      ++missed_;
    }
    ++taken_;
  }

  void finish() const {
    if (taken_ == 0) throw Error(ErrorKind::kNotEnoughData, "there was no pair of images to reconstruct from");
    const fs::path page = fs::path(flags_.output) / "stereo.html";
    write_results(flags_.output, {{page, stereo_page(page_)}});
    if (!flags_.json) {
      fmt::print("\nwrote {}: rectified pair, disparity, depth, PLY and JSON for each of {} pairs\nlook  {}\n",
                 flags_.output, taken_, page.string());
    }
    if (missed_ == 0) return;
    say_warning(fmt::format(
        "{} of {} pairs missed the gate of {:g} % matched: are both images of one moment, left and right not "
        "exchanged, and the cameras where they were when they were calibrated?",
        missed_, taken_, flags_.stereo.least_matched_percent));
    throw GateFailed{};
  }

 private:
  static void require_size(const cv::Mat& image, ImageSize size, const std::string& path) {
    if (image.cols == size.width && image.rows == size.height) return;
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("is {}x{} but its camera was calibrated with {}x{}; give the images as the camera took them",
                    image.cols, image.rows, size.width, size.height),
        path);
  }

  void print_row(const std::string& name, const StereoFrame& frame) const {
    const StereoSummary summary = summary_of(frame);
    fmt::print("{:<16} {:>8} {:>6.1f} % {:>9} {:>10}  {}\n", name, summary.points,
               100.0 * summary.points / std::max(1, setup_.matcher.covered()),
               summary.points > 0 ? fmt::format("{:.3f}", summary.median_depth_m) : "-",
               summary.points > 0 ? fmt::format("{:.1f}", 1e3 * summary.median_sigma_m) : "-", state_name(frame.state));
    if (cabin_) fmt::print("{:<16} {}\n", "", cabin_->words());
  }

  const Flags& flags_;
  StereoSetup setup_;
  std::optional<CabinWatch> cabin_;
  std::optional<ExposureAdvice> exposure_;
  nlohmann::json page_ = nlohmann::json::array();
  int taken_ = 0;
  int missed_ = 0;  // of the gate
};

std::vector<ImageFile> files_of(int camera, const std::string& pattern) {
  return fs::is_directory(pattern) ? image_files(camera, pattern, {"*"}) : image_files(camera, "", {pattern});
}

cv::Mat image_at(const std::string& path) {
  std::string reason;
  const cv::Mat image = read_gray(path, reason);
  if (image.empty()) throw Error(ErrorKind::kIo, reason, path);
  if (image.depth() == CV_8U) return image;
  cv::Mat bytes;
  image.convertTo(bytes, CV_8U, 1.0 / 256.0);
  return bytes;
}

void take_videos(const std::string& left, const std::string& right, Reconstruction& reconstruction) {
  cv::VideoCapture left_video(left), right_video(right);
  if (!left_video.isOpened()) throw Error(ErrorKind::kIo, "cannot be read as a video", left);
  if (!right_video.isOpened()) throw Error(ErrorKind::kIo, "cannot be read as a video", right);
  const auto grey = [](cv::VideoCapture& video, cv::Mat& image) {
    if (!video.read(image)) return false;
    if (image.channels() > 1) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
    return true;
  };
  cv::Mat left_image, right_image;
  for (int frame = 0;; ++frame) {
    const bool in_left = grey(left_video, left_image);
    const bool in_right = grey(right_video, right_image);
    if (in_left != in_right) say_warning(fmt::format("{} ends first, after {} frames", in_left ? right : left, frame));
    if (!in_left || !in_right) return;
    reconstruction.take(fmt::format("{:06}", frame), left_image, right_image, left, right);
  }
}

// Images with the same frame name belong together; two single images always do.
void take_images(const std::vector<ImageFile>& left, const std::vector<ImageFile>& right,
                 Reconstruction& reconstruction) {
  if (left.size() == 1 && right.size() == 1) {
    const std::string name = fs::path(left[0].path).stem().string();
    return reconstruction.take(name, image_at(left[0].path), image_at(right[0].path), left[0].path, right[0].path);
  }
  std::map<std::string, std::string> right_of;
  for (const ImageFile& file : right) right_of[file.frame] = file.path;
  std::size_t alone = 0;
  for (const ImageFile& file : left) {
    const auto found = right_of.find(file.frame);
    if (found == right_of.end()) {
      ++alone;
      continue;
    }
    reconstruction.take(file.frame, image_at(file.path), image_at(found->second), file.path, found->second);
  }
  if (alone > 0)
    say_warning(fmt::format("{} of {} left images have no right one of the same number", alone, left.size()));
}

void run(const Flags& flags) {
  const std::vector<ImageFile> left = files_of(0, flags.left);
  const std::vector<ImageFile> right = files_of(1, flags.right);
  Reconstruction reconstruction(flags);
  if (left.size() == 1 && right.size() == 1 && left[0].video && right[0].video) {
    take_videos(left[0].path, right[0].path, reconstruction);
  } else {
    take_images(left, right, reconstruction);
  }
  reconstruction.finish();
}

}  // namespace

void add_stereo_reconstruction(CLI::App& reconstruct) {
  auto flags = std::make_shared<Flags>();
  CLI::App* verb = reconstruct.add_subcommand("stereo", "image pairs -> disparity, depth and points");
  verb->add_option("calibration", flags->calibration, "calibration.json")->required()->type_name("CALIBRATION");
  verb->add_option("left", flags->left, "image, pattern in quotes, folder or video")->required()->type_name("LEFT");
  verb->add_option("right", flags->right, "the same moments from the right")->required()->type_name("RIGHT");
  verb->add_option("-o,--output", flags->output, "folder to write")->type_name("DIR")->required();
  declare_stereo_flags(*verb, flags->stereo);
  verb->add_option("--vehicle", flags->vehicle,
                   "where the pair is in a car: tells seat and head (docs/formats/stereo.md)")
      ->type_name("TOML");
  verb->add_option("--exposure", flags->exposure, "shutter [ms] and gain of the images: advises what they should be")
      ->expected(2)
      ->check(CLI::PositiveNumber);
  verb->add_flag("--json", flags->json, "print the results as JSON, one after the other");
  verb->footer(
      "Images of a moment have the same number in their names. What is written: docs/formats/stereo.md\n"
      "Exit code 1 when a pair misses the gate of --least-matched.\n"
      "Example:\n"
      "  raybundle reconstruct stereo out/calibration.json 'left*.jpg' 'right*.jpg' -o points");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
