// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "image_files.hpp"
#include "laser_frame_files.hpp"
#include "laser_images.hpp"
#include "output_folder.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "reconstruct.hpp"
#include "stereo_anchors.hpp"
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
  std::string calibration, left, right, output, vehicle, laser;
  std::vector<double> exposure;  // shutter [ms], gain
  StereoFlags stereo;
  bool json = false;
};

// The files of one moment.
struct Moment {
  std::string name, left, right;
  std::string lit;  // the left camera with the laser on; empty: none
};

// The images of one moment; `lit` may be empty, or the left one itself.
struct Images {
  cv::Mat left, right, lit;
};

cv::Mat image_at(const std::string& path) {
  const cv::Mat image = read_gray(path);
  if (image.depth() == CV_8U) return image;
  cv::Mat bytes;
  image.convertTo(bytes, CV_8U, 1.0 / 256.0);
  return bytes;
}

// Real pairs match 12 to 43 % of what both cameras show; with left and right exchanged, by chance, 5 to 12 %, which is
// a third of what they match the right way round, and at most a half.
constexpr double kFewMatched = 0.25;
constexpr double kExchanged = 1.5;  // times as many matches the other way round

/// Takes pairs one after the other and writes what they say.
class Reconstruction {
 public:
  explicit Reconstruction(const Flags& flags)
      : flags_(flags), setup_(stereo_setup(flags.calibration, flags.stereo, !flags.laser.empty())) {
    require_writable(flags.output);
    fs::remove(page_file());  // an earlier run's shows other pairs
    if (!flags.vehicle.empty()) cabin_.emplace(read_stereo_cabin(flags.vehicle), setup_.matcher.rectification());
    if (!flags.exposure.empty()) exposure_.emplace(setup_.left.camera.size, flags.exposure);
    if (!flags.laser.empty()) anchors_.emplace(flags.calibration, setup_.left, setup_.matcher.rectification());
    for (const std::string& line : setup_.said) say(line);
    if (flags.json) return;
    fmt::print("{:<16} {:>8} {:>8} {:>9} {:>10}  {}\n", "frame", "points", "matched", "depth m", "sigma mm", "state");
  }

  // Reads the images of a moment; those that are not what they should be cost only themselves.
  void take(const Moment& moment, bool only_one) {
    Images images;
    try {
      images = {image_at(moment.left), image_at(moment.right), {}};
      if (moment.lit == moment.left)
        images.lit = images.left;
      else if (!moment.lit.empty())
        images.lit = image_at(moment.lit);
      require_sizes(moment, images);  // here a wrong one costs its pair only
    } catch (const Error& error) {
      if (only_one) throw;
      say_warning(fmt::format("{}; the pair is left out", error.what()));
      ++left_out_;
      return;
    }
    take(moment, images);
  }

  /// @throws Error(kBadInput) when an image has another size than its camera
  void take(const Moment& moment, const Images& images) {
    require_sizes(moment, images);
    const std::string& name = moment.name;
    const cv::Mat &left = images.left, &right = images.right;
    std::span<const AnchorDot> dots;
    if (anchors_) dots = anchors_->take(images.lit, moment.lit == moment.left ? cv::Mat() : left);
    const StereoFrame frame = setup_.matcher.process(view_of(left), view_of(right), dots);
    nlohmann::ordered_json more{{"nearest_m", setup_.nearest_m}};
    if (cabin_) more["cabin"] = cabin_->take(frame);
    if (exposure_) more["exposure"] = exposure_->advise(view_of(left));
    if (anchors_) {
      more["laser"] = {{"image", moment.lit},
                       {"dots", dots.size()},
                       {"filled", frame.fused.filled},
                       {"contradicted", frame.fused.contradicted}};
    }
    const StereoFrameFiles files = stereo_frame_files(frame, setup_.matcher, moment.left, moment.right, more);
    const fs::path folder(flags_.output);
    write_results(folder, {{folder / (name + "_left.png"), files.left_png},
                           {folder / (name + "_right.png"), files.right_png},
                           {folder / (name + "_disparity.png"), files.disparity_png},
                           {folder / (name + "_depth.png"), files.depth_png},
                           {folder / (name + ".ply"), files.ply},
                           {folder / (name + ".json"), files.json}});
    if (std::ssize(page_) < kMostPageFrames) {
      page_.push_back(stereo_page_frame(name, frame));
      if (cabin_) page_.back().update(cabin_->on_page());
    }
    flags_.json ? static_cast<void>(fmt::print("{}", files.json)) : print_row(name, frame);
    std::fflush(stdout);
    judge(name, frame, images);
    names_.insert(name);
    ++taken_;
  }

  void finish() const {
    if (taken_ == 0) throw Error(ErrorKind::kNotEnoughData, "there was no pair of images to reconstruct from");
    remove_former_frames(flags_.output, names_);
    const fs::path page = page_file();
    write_results(flags_.output, {{page, stereo_page(page_)}});
    if (!flags_.json) {
      fmt::print("\nwrote {}: rectified pair, disparity, depth, PLY and JSON for each of {} pairs\nlook  {}\n",
                 flags_.output, taken_, page.string());
    }
    if (left_out_ > 0) say_warning(fmt::format("{} of {} pairs could not be used", left_out_, taken_ + left_out_));
    if (exchanged_ > 0)
      say_warning(fmt::format("{} of {} pairs fit the other way round: exchange LEFT and RIGHT", exchanged_, taken_));
    if (missed_ > 0) {
      say_warning(fmt::format(
          "{} of {} pairs missed the gate of {:g} % matched: are both images of one moment, and the cameras where "
          "they were when they were calibrated?",
          missed_, taken_, flags_.stereo.least_matched_percent));
    }
    if (left_out_ + missed_ + exchanged_ > 0) throw GateFailed{};
  }

 private:
  fs::path page_file() const { return fs::path(flags_.output) / "stereo.html"; }

  void require_sizes(const Moment& moment, const Images& images) const {
    require_size(images.left, setup_.left.camera.size, moment.left);
    require_size(images.right, setup_.right.camera.size, moment.right);
    if (!anchors_) return;
    if (moment.lit.empty()) {
      throw Error(ErrorKind::kBadInput,
                  "there is no image with the laser on for this one; add it, or leave --laser out", moment.left);
    }
    require_size(images.lit, setup_.left.camera.size, moment.lit);
  }

  static void require_size(const cv::Mat& image, ImageSize size, const std::string& path) {
    if (image.cols == size.width && image.rows == size.height) return;
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("is {}x{} but its camera was calibrated with {}x{}; give the images as the camera took them",
                    image.cols, image.rows, size.width, size.height),
        path);
  }

  double matched_share(int matched) const {
    return static_cast<double>(matched) / std::max(1, setup_.matcher.covered());
  }

  // The last that is done with a frame: to look whether left and right are exchanged is to match once more.
  void judge(const std::string& name, const StereoFrame& frame, const Images& images) {
    const double share = matched_share(frame.disparity.matched);
    const bool missed = frame.state != State::kOk;
    bool exchanged = false;
    if (share < kFewMatched && setup_.left.camera.size == setup_.right.camera.size) {
      const StereoFrame other = setup_.matcher.process(view_of(images.right), view_of(images.left));
      const double other_share = matched_share(other.disparity.matched);
      exchanged = other_share > kExchanged * share;
      if (exchanged) {
        say_warning(
            fmt::format("{}: left and right seem to be exchanged: {:.1f} % was matched, the other way round it "
                        "would be {:.1f} %",
                        name, 100 * share, 100 * other_share));
      }
    }
    if (missed && !exchanged)
      say_warning(fmt::format("{}: only {:.1f} % of what both cameras show was matched", name, 100 * share));
    missed_ += missed && !exchanged;
    exchanged_ += exchanged;
  }

  void print_row(const std::string& name, const StereoFrame& frame) const {
    const StereoSummary summary = summary_of(frame);
    fmt::print("{:<16} {:>8} {:>6.1f} % {:>9} {:>10}  {}\n", name, summary.points,
               100 * matched_share(frame.disparity.matched),
               summary.points > 0 ? fmt::format("{:.3f}", summary.median_depth_m) : "-",
               summary.points > 0 ? fmt::format("{:.1f}", 1e3 * summary.median_sigma_m) : "-", state_name(frame.state));
    if (cabin_) fmt::print("{:<16} {}\n", "", cabin_->words());
    if (exposure_) fmt::print("{:<16} {}\n", "", exposure_->words());
  }

  const Flags& flags_;
  StereoSetup setup_;
  std::optional<CabinWatch> cabin_;
  std::optional<LaserAnchors> anchors_;
  std::optional<ExposureAdvice> exposure_;
  nlohmann::json page_ = nlohmann::json::array();
  std::set<std::string> names_;  // of the frames taken
  int taken_ = 0;
  int missed_ = 0;  // of the gate
  int exchanged_ = 0;
  int left_out_ = 0;
};

std::vector<ImageFile> files_of(int camera, const std::string& pattern) {
  return fs::is_directory(pattern) ? images_in_folder(camera, pattern) : image_files(camera, "", {pattern});
}

// Frames with the same number belong together, until the first of the videos ends.
void take_videos(const std::vector<std::string>& paths, Reconstruction& reconstruction) {
  std::vector<std::unique_ptr<GreyVideo>> videos;
  for (const std::string& path : paths) videos.push_back(std::make_unique<GreyVideo>(path));
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

// Images with the same frame name belong together; single images always do.
std::vector<Moment> moments_of(const std::vector<ImageFile>& left, const std::vector<ImageFile>& right,
                               const std::vector<ImageFile>& lit) {
  if (left.size() == 1 && right.size() == 1) {
    return {{fs::path(left[0].path).stem().string(), left[0].path, right[0].path,
             lit.size() == 1 ? lit[0].path : std::string()}};
  }
  const std::map<std::string, std::string> right_of = paths_by_frame(right), lit_of = paths_by_frame(lit);
  std::vector<Moment> moments;
  for (const ImageFile& file : left) {
    const auto found = right_of.find(file.frame), laser = lit_of.find(file.frame);
    if (found == right_of.end()) continue;
    moments.push_back({file.frame, file.path, found->second, laser == lit_of.end() ? "" : laser->second});
  }
  if (moments.size() < left.size()) {
    say_warning(fmt::format("{} of {} left images have no right one of the same number", left.size() - moments.size(),
                            left.size()));
  }
  return moments;
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
  const std::vector<ImageFile> left = files_of(0, flags.left);
  const std::vector<ImageFile> right = files_of(1, flags.right);
  const std::vector<ImageFile> lit = flags.laser.empty() ? std::vector<ImageFile>() : files_of(0, flags.laser);
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
  for (std::size_t i = 0; i < std::min(left.size(), right.size()); ++i) {
    if (left[i].path != right[i].path) continue;
    throw Error(ErrorKind::kBadInput, "is given as left and as right; name the images of either camera", left[i].path);
  }
  Reconstruction reconstruction(flags);
  if (!videos.empty()) {
    take_videos(videos, reconstruction);
  } else {
    const std::vector<Moment> moments = moments_of(left, right, lit);
    for (const Moment& moment : moments) reconstruction.take(moment, moments.size() == 1);
  }
  reconstruction.finish();
}

// As CLI::PositiveNumber, which tells the largest of all numbers in full.
std::string above_zero(const std::string& text) {
  double value = 0.0;
  const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value > 0.0;
  return good ? "" : fmt::format("'{}' is no number above 0", text);
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
  verb->add_option("--laser", flags->laser,
                   "the left camera with the rig's laser on, at the same moments: its dots anchor depth where there is "
                   "no texture; may be the left images themselves")
      ->type_name("IMAGE");
  verb->add_option("--exposure", flags->exposure, "shutter [ms] and gain of the images: advises what they should be")
      ->expected(2)
      ->check(above_zero);
  verb->add_flag("--json", flags->json, "print the results as JSON, one after the other");
  verb->footer(
      "Images of a moment have the same number in their names. What is written: docs/formats/stereo.md\n"
      "Exit code 1 when a pair misses the gate of --least-matched, or could not be read.\n"
      "Example:\n"
      "  raybundle reconstruct stereo out/calibration.json 'left*.jpg' 'right*.jpg' -o points");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
