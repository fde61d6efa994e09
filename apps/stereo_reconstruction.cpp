// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_reconstruction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <span>
#include <utility>

#include "image_files.hpp"
#include "laser_images.hpp"
#include "output_folder.hpp"
#include "raybundle/geometry/error.hpp"
#include "state_name.hpp"
#include "stereo_frame_files.hpp"
#include "stereo_page.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

// Real pairs match 10 to 42 % of what both cameras show; with left and right exchanged, by chance, 4 to 6 %, which is
// a third of what they match the right way round, and at most a half.
constexpr double kFewMatched = 0.25;
constexpr double kExchanged = 1.5;  // times as many matches the other way round

// Sensors' noise spreads an image of nothing over a few grey values, and any scene over far more.
constexpr int kFewGreys = 16;
constexpr double kStray = 0.01;  // of the pixels on either side: dead ones, and light past what covers the lens

// Why nothing can be matched in an image of one grey; empty for any other.
std::string blank_reason(const cv::Mat& image, const std::string& path) {
  std::array<int, 256> count{};
  for (const std::uint8_t grey : cv::Mat_<std::uint8_t>(image)) ++count[grey];
  const auto stray = static_cast<int>(kStray * static_cast<double>(image.total()));
  int darkest = 0, brightest = 255;
  for (int below = count[0]; below <= stray; below += count[static_cast<std::size_t>(darkest)]) ++darkest;
  for (int above = count[255]; above <= stray; above += count[static_cast<std::size_t>(brightest)]) --brightest;
  if (brightest - darkest >= kFewGreys) return {};
  return fmt::format("{} shows nothing, its grey values are {} to {}: is the camera covered, or badly exposed?", path,
                     darkest, brightest);
}

void require_size(const cv::Mat& image, ImageSize size, const std::string& path) {
  if (image.cols == size.width && image.rows == size.height) return;
  throw Error(ErrorKind::kBadInput,
              fmt::format("is {}x{} but its camera was calibrated with {}x{}; give the images as the camera took them",
                          image.cols, image.rows, size.width, size.height),
              path);
}

}  // namespace

StereoReconstruction::StereoReconstruction(const StereoReconstructionFlags& flags)
    : flags_(flags), setup_(stereo_setup(flags.calibration, flags.stereo, !flags.laser.empty())) {
  require_writable(flags.output);
  if (!flags.vehicle.empty()) cabin_.emplace(read_stereo_cabin(flags.vehicle), setup_.matcher.rectification());
  if (!flags.exposure.empty()) exposure_.emplace(setup_.left.camera.size, flags.exposure);
  if (!flags.laser.empty()) {
    anchors_.emplace(flags.calibration, flags.dots, setup_.left, setup_.matcher.rectification());
  }
  for (const std::string& line : setup_.said) say(line);
  if (flags.json) return;
  fmt::print("{:<16} {:>8} {:>8} {:>9} {:>10}  {}\n", "frame", "points", "matched", "depth m", "sigma mm", "state");
}

void StereoReconstruction::take(const StereoMoment& moment, bool only_one) {
  StereoImages images;
  try {
    images = {read_gray(moment.left), read_gray(moment.right), {}};
    const bool lit_apart = !moment.lit.empty() && moment.lit != moment.left;
    if (lit_apart) images.lit = read_gray(moment.lit);
    bits_.take({&images.left, &images.right, &images.lit});
    if (moment.lit == moment.left) images.lit = images.left;
    require_sizes(moment, images);
  } catch (const Error& error) {
    if (only_one) throw;
    say_warning(fmt::format("{}; the pair is left out", error.what()));
    ++left_out_;
    return;
  }
  reconstruct(moment, images);
}

void StereoReconstruction::take(const StereoMoment& moment, const StereoImages& images) {
  require_sizes(moment, images);
  reconstruct(moment, images);
}

void StereoReconstruction::reconstruct(const StereoMoment& moment, const StereoImages& images) {
  const std::string& name = moment.name;
  std::span<const AnchorDot> dots;
  if (anchors_) dots = anchors_->take(images.lit, moment.lit == moment.left ? cv::Mat() : images.left);
  const StereoFrame frame = setup_.matcher.process(view_of(images.left), view_of(images.right), dots);
  nlohmann::ordered_json more{{"nearest_m", setup_.nearest_m}};
  if (cabin_) more["cabin"] = cabin_->take(frame);
  if (exposure_) more["exposure"] = exposure_->advise(view_of(images.left));
  if (anchors_) {
    more["laser"] = {{"image", moment.lit},
                     {"dots", dots.size()},
                     {"filled", frame.fused.filled},
                     {"contradicted", frame.fused.contradicted}};
    without_dots_ += dots.empty();
  }
  const StereoFrameFiles files = stereo_frame_files(frame, setup_.matcher, moment.left, moment.right, more);
  if (names_.empty()) fs::remove(page_file());  // a former run's shows other pairs than lie beside it from now on
  write_results(flags_.output, named_files(flags_.output, name, files));
  names_.insert(name);
  if (std::ssize(page_) < kMostPageFrames) {
    page_.push_back(stereo_page_frame(name, frame));
    if (cabin_) page_.back().update(cabin_->on_page());
  }
  flags_.json ? static_cast<void>(fmt::print("{}", files.json)) : print_row(name, frame);
  std::fflush(stdout);
  judge(moment, frame, images);
}

void StereoReconstruction::finish() const {
  const std::size_t taken = names_.size();
  if (taken == 0) throw Error(ErrorKind::kNotEnoughData, "there was no pair of images to reconstruct from");
  remove_former_stereo_frames(flags_.output, names_);
  write_results(flags_.output, {{page_file(), stereo_page(page_)}});
  if (!flags_.json) {
    fmt::print("\nwrote {}: rectified pair, disparity, depth, PLY and JSON for {}\nlook  {}\n", flags_.output,
               taken == 1 ? "the pair" : fmt::format("each of {} pairs", taken), page_file().string());
  }
  if (left_out_ > 0) say_warning(fmt::format("{} of {} pairs could not be used", left_out_, taken + left_out_));
  if (exchanged_ > 0)
    say_warning(fmt::format("{} of {} pairs fit the other way round: exchange LEFT and RIGHT", exchanged_, taken));
  if (missed_ > 0) {
    say_warning(fmt::format(
        "{} of {} pairs missed the gate of {:g} % matched: are both images of one moment, and the cameras where "
        "they were when they were calibrated?",
        missed_, taken, flags_.stereo.least_matched_percent));
  }
  if (without_dots_ > 0) {
    say_warning(fmt::format(
        "no dot got a place in {} of {} pairs: does the laser shine in the --laser images, on what lies from "
        "--nearest {:g} to --farthest {:g} m before the left camera?",
        without_dots_, taken, flags_.dots.nearest_m, flags_.dots.farthest_m));
  }
  if (left_out_ + missed_ + exchanged_ > 0) throw GateFailed{};
}

fs::path StereoReconstruction::page_file() const { return fs::path(flags_.output) / "stereo.html"; }

void StereoReconstruction::require_sizes(const StereoMoment& moment, const StereoImages& images) const {
  require_size(images.left, setup_.left.camera.size, moment.left);
  require_size(images.right, setup_.right.camera.size, moment.right);
  if (!anchors_) return;
  if (moment.lit.empty()) {
    throw Error(ErrorKind::kBadInput, "there is no image with the laser on for this one; add it, or leave --laser out",
                moment.left);
  }
  require_size(images.lit, setup_.left.camera.size, moment.lit);
}

double StereoReconstruction::matched_share(int matched) const {
  return static_cast<double>(matched) / std::max(1, setup_.matcher.covered());
}

// The last that is done with a frame: to look whether left and right are exchanged is to match once more.
void StereoReconstruction::judge(const StereoMoment& moment, const StereoFrame& frame, const StereoImages& images) {
  const std::string& name = moment.name;
  const double share = matched_share(frame.disparity.matched);
  const bool missed = frame.state != State::kOk;
  bool exchanged = false;
  if (share < kFewMatched && setup_.left.camera.size == setup_.right.camera.size) {
    const StereoFrame other = setup_.matcher.process(view_of(images.right), view_of(images.left));
    const double other_share = matched_share(other.disparity.matched);
    exchanged = other_share > kExchanged * share && 100 * other_share >= flags_.stereo.least_matched_percent;
    if (exchanged) {
      say_warning(
          fmt::format("{}: left and right seem to be exchanged: {:.1f} % was matched, the other way round it "
                      "would be {:.1f} %",
                      name, 100 * share, 100 * other_share));
    }
  }
  if (missed && !exchanged) {
    say_warning(fmt::format("{}: only {:.1f} % of what both cameras show was matched", name, 100 * share));
    for (const auto& [image, path] : {std::pair(&images.left, &moment.left), std::pair(&images.right, &moment.right)}) {
      const std::string reason = blank_reason(*image, *path);
      if (!reason.empty()) say_warning(fmt::format("{}: {}", name, reason));
    }
  }
  missed_ += missed && !exchanged;
  exchanged_ += exchanged;
}

void StereoReconstruction::print_row(const std::string& name, const StereoFrame& frame) const {
  const StereoSummary summary = summary_of(frame);
  fmt::print("{:<16} {:>8} {:>6.1f} % {:>9} {:>10}  {}\n", name, summary.points,
             100 * matched_share(frame.disparity.matched),
             summary.points > 0 ? fmt::format("{:.3f}", summary.median_depth_m) : "-",
             summary.points > 0 ? fmt::format("{:.1f}", 1e3 * summary.median_sigma_m) : "-", state_name(frame.state));
  if (cabin_) fmt::print("{:<16} {}\n", "", cabin_->words());
  if (exposure_) fmt::print("{:<16} {}\n", "", exposure_->words());
}

}  // namespace raybundle::apps
