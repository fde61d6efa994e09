// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>

#include "image_codec.hpp"
#include "image_files.hpp"
#include "media/media.hpp"
#include "number_flags.hpp"
#include "raybundle/geometry/error.hpp"
#include "reconstruct.hpp"
#include "stereo_reconstruction.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;
using Flags = StereoReconstructionFlags;

std::vector<ImageFile> files_of(int camera, const std::string& pattern) {
  return fs::is_directory(pattern) ? images_in_folder(camera, pattern) : image_files(camera, "", {pattern});
}

// Frames with the same number belong together, until the first of the videos ends.
void take_videos(const std::vector<std::string>& paths, StereoReconstruction& reconstruction) {
  std::vector<std::unique_ptr<VideoReader>> videos;
  for (const std::string& path : paths) videos.push_back(media().open_video(path));
  for (int frame = 0;; ++frame) {
    std::vector<cv::Mat> images;
    for (const auto& video : videos) images.push_back(video->next());
    const auto ended = std::ranges::find_if(images, [](const cv::Mat& image) { return image.empty(); });
    if (ended != images.end()) {
      const std::string& path = paths[ended - images.begin()];
      if (frame == 0) throw Error(ErrorKind::kIo, kNoVideo, path);
      const bool all = std::ranges::all_of(images, [](const cv::Mat& image) { return image.empty(); });
      if (!all) say_warning(fmt::format("{} ends first, after {} frames", path, frame));
      return;
    }
    const bool laser = images.size() == 3;
    reconstruction.take({fmt::format("{:06}", frame), paths[0], paths[1], laser ? paths[2] : ""},
                        {images[0], images[1], laser ? images[2] : cv::Mat()});
  }
}

std::map<std::string, std::string> paths_by_frame(const std::vector<ImageFile>& files) {
  std::map<std::string, std::string> paths;
  for (const ImageFile& file : files) paths[file.frame] = file.path;
  return paths;
}

void warn_of_lonely(const std::vector<ImageFile>& files, std::size_t paired, const char* side, const char* other) {
  if (paired == files.size()) return;
  say_warning(fmt::format("{} of {} {} images have no {} one of the same number", files.size() - paired, files.size(),
                          side, other));
}

// Single images belong together, whatever they are called.
StereoMoment single_moment(const std::string& left, const std::string& right, const std::vector<ImageFile>& lit) {
  warn_of_other_moment(left, right);
  if (lit.size() > 1) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("--laser names {} images, {} and others, for one pair; name the one of its moment",
                            lit.size(), lit[0].path));
  }
  return {fs::path(left).stem().string(), left, right, lit.size() == 1 ? lit[0].path : std::string()};
}

// Images with the same frame name belong together.
std::vector<StereoMoment> moments_of(const std::vector<ImageFile>& left, const std::vector<ImageFile>& right,
                                     const std::vector<ImageFile>& lit) {
  const std::map<std::string, std::string> right_of = paths_by_frame(right), lit_of = paths_by_frame(lit);
  std::vector<StereoMoment> moments;
  for (const ImageFile& file : left) {
    const auto found = right_of.find(file.frame), laser = lit_of.find(file.frame);
    if (found == right_of.end()) continue;
    moments.push_back({file.frame, file.path, found->second, laser == lit_of.end() ? "" : laser->second});
  }
  warn_of_lonely(left, moments.size(), "left", "right");
  warn_of_lonely(right, moments.size(), "right", "left");
  const auto with_laser =
      std::ranges::count_if(moments, [](const StereoMoment& moment) { return !moment.lit.empty(); });
  warn_of_lonely(lit, static_cast<std::size_t>(with_laser), "laser", "left and right");
  return moments;
}

// Files that are no images, among others: they are named here, for they have no number that a pair could be found by.
std::size_t leave_out_unreadable(std::vector<ImageFile>& files) {
  if (files.size() < 2) return 0;
  return std::erase_if(files, [](const ImageFile& file) {
    std::string reason;
    const bool no_image = !file.video && !may_be_image(file.path) && read_gray(file.path, reason).empty();
    if (no_image) say_warning(fmt::format("{}: {}; the pair is left out", file.path, reason));
    return no_image;
  });
}

// Results among the images would be taken for images by the next run.
void refuse_output_among(const std::vector<ImageFile>& files, const std::string& output) {
  std::error_code ignored;
  for (const ImageFile& file : files) {
    const fs::path folder = fs::path(file.path).parent_path();
    if (!fs::equivalent(folder.empty() ? fs::path(".") : folder, output, ignored)) continue;
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("{} lies in the output folder, where results would mix with the images; choose another with "
                    "-o",
                    file.path));
  }
}

void run(const Flags& flags) {
  std::vector<ImageFile> left = files_of(0, flags.left);
  std::vector<ImageFile> right = files_of(1, flags.right);
  std::vector<ImageFile> lit = flags.laser.empty() ? std::vector<ImageFile>() : files_of(0, flags.laser);
  std::vector<std::string> videos;
  std::size_t sequences = 0;
  for (const std::vector<ImageFile>* files : {&left, &right, &lit}) {
    refuse_output_among(*files, flags.output);
    sequences += !files->empty();
    if (!files->empty() && files->front().video) videos.push_back(files->front().path);
  }
  if (!videos.empty() && videos.size() < sequences) {
    throw Error(ErrorKind::kBadInput, "is a video, and others are images; give videos of all, or images", videos[0]);
  }
  std::vector<StereoMoment> moments;  // single images are told before some are left out: two that are left are no pair
  if (videos.empty() && left.size() == 1 && right.size() == 1) {
    moments.push_back(single_moment(left[0].path, right[0].path, lit));
  }
  const bool any_unreadable = leave_out_unreadable(left) + leave_out_unreadable(right) + leave_out_unreadable(lit) > 0;
  std::vector<ImageFile> both = left;
  both.insert(both.end(), right.begin(), right.end());
  refuse_shared_images(both, {"left", "right"});
  StereoReconstruction reconstruction(flags);
  if (!videos.empty()) {
    take_videos(videos, reconstruction);
  } else {
    if (moments.empty()) moments = moments_of(left, right, lit);
    for (const StereoMoment& moment : moments) reconstruction.take(moment, moments.size() == 1);
  }
  reconstruction.finish();
  if (any_unreadable) throw GateFailed{};
}

}  // namespace

void add_stereo_reconstruction(CLI::App& reconstruct) {
  auto flags = std::make_shared<Flags>();
  CLI::App* verb = reconstruct.add_subcommand("stereo", "image pairs -> disparity, depth and points");
  verb->add_option("calibration", flags->calibration, "calibration.json")->required()->type_name("CALIBRATION");
  verb->add_option("left", flags->left, "image, pattern in quotes, folder or video")->required()->type_name("LEFT");
  verb->add_option("right", flags->right, "the same moments from the right")->required()->type_name("RIGHT");
  verb->add_option("-o,--output", flags->output, "folder to write; frames of a former run in it are removed")
      ->type_name("DIR")
      ->required();
  declare_stereo_flags(*verb, flags->stereo);
  verb->add_option("--vehicle", flags->vehicle,
                   "where the pair is in a car: tells seat and head (docs/formats/stereo.md)")
      ->type_name("TOML");
  CLI::Option* laser =
      verb->add_option(
              "--laser", flags->laser,
              "the left camera with the rig's laser on, at the same moments: its dots anchor depth where there is "
              "no texture; may be the left images themselves")
          ->type_name("IMAGE");
  declare_sensor_flags(*verb, flags->dots);
  for (CLI::Option* option : flags->dots.options) option->needs(laser);
  verb->add_option("--exposure", flags->exposure, "shutter [ms] and gain of the images: advises what they should be")
      ->expected(2)
      ->check(above_zero);
  verb->add_flag("--json", flags->json, "print the results as JSON, one after the other");
  verb->footer(
      "Images of a moment have the same number in their names. What is written: docs/formats/stereo.md\n"
      "Exit code 1 when a pair misses the gate of --least-matched, fits the other way round, or could not be used.\n"
      "Example:\n"
      "  raybundle reconstruct stereo out/calibration.json 'left*.jpg' 'right*.jpg' -o points");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
