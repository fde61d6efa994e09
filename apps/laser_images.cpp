// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <utility>

#include "media/media.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/frame_names.hpp"

namespace raybundle::apps {
namespace {

using FilesByFrame = std::map<std::string, std::string>;

FilesByFrame by_frame(const std::vector<std::string>& files) {
  const std::vector<std::string> names = frame_names(files);
  FilesByFrame found;
  for (std::size_t i = 0; i < files.size(); ++i) found[names[i]] = files[i];
  return found;
}

// The files of `from` without a counterpart in `in`.
std::vector<std::string> lonely(const FilesByFrame& from, const FilesByFrame& in) {
  std::vector<std::string> files;
  for (const auto& [frame, file] : from) {
    if (!in.contains(frame)) files.push_back(file);
  }
  return files;
}

void require_none(const std::vector<std::string>& lonely, const char* counterpart) {
  if (lonely.empty()) return;
  const std::string more = lonely.size() == 1 ? "" : fmt::format(", nor for {} others", lonely.size() - 1);
  throw Error(ErrorKind::kBadInput,
              fmt::format("there is no image with the laser {} for this one{}; add it, or leave this one out",
                          counterpart, more),
              lonely.front());
}

void require_size(const cv::Mat& image, const std::string& path, const SensorTable& table) {
  const ImageSize& size = table.rays.size;
  if (image.cols == size.width && image.rows == size.height) return;
  throw Error(ErrorKind::kBadInput,
              fmt::format("is of {}x{} pixels, and camera {} was calibrated with {}x{}", image.cols, image.rows,
                          table.camera, size.width, size.height),
              path);
}

}  // namespace

std::vector<LaserShot> laser_shots(const std::vector<std::string>& on, const std::vector<std::string>& off) {
  std::vector<LaserShot> shots;
  for (const std::string& file : on) shots.push_back({file, ""});
  if (off.empty()) return shots;
  const FilesByFrame with = by_frame(on), without = by_frame(off);
  const std::vector<std::string> no_off = lonely(with, without), no_on = lonely(without, with);
  const bool named_alike = with.size() == on.size() && without.size() == off.size() && no_off.size() < with.size();
  if (!named_alike && on.size() != off.size()) {
    throw Error(ErrorKind::kBadInput, fmt::format("there are {} images with the laser on and {} with it off; they have "
                                                  "to be as many, in the same order",
                                                  on.size(), off.size()));
  }
  if (named_alike) {
    require_none(no_off, "off");
    require_none(no_on, "on");
  }
  if (on.size() == 1 && off.size() == 1) warn_of_other_moment(on[0], off[0]);
  const std::vector<std::string> frames = frame_names(on);
  for (std::size_t i = 0; i < on.size(); ++i) shots[i].off = named_alike ? without.at(frames[i]) : off[i];
  return shots;
}

void for_each_moment(const LaserShot& shot, const SensorTable& table, EightBits& bits,
                     const std::function<bool(const ShotImages& images, const std::string& name)>& use) {
  const std::string name = std::filesystem::path(shot.on).stem().string();
  const auto checked = [&](ShotImages images) {
    require_size(images.on, shot.on, table);
    if (!images.off.empty()) require_size(images.off, shot.off, table);
    bits.take({&images.on, &images.off});
    return images;
  };
  if (is_video(shot.on) != is_video(shot.off) && !shot.off.empty()) {
    throw Error(ErrorKind::kBadInput, "one of laser on and off is a video and the other one an image", shot.off);
  }
  if (!is_video(shot.on)) {
    use(checked({read_gray(shot.on), shot.off.empty() ? cv::Mat() : read_gray(shot.off)}), name);
    return;
  }
  const std::unique_ptr<VideoReader> on = media().open_video(shot.on);
  std::unique_ptr<VideoReader> off;
  if (!shot.off.empty()) off = media().open_video(shot.off);
  for (int count = 0;; ++count) {
    const cv::Mat image = on->next();
    if (image.empty() && count == 0) throw Error(ErrorKind::kIo, kNoVideo, shot.on);
    if (image.empty()) return;
    const cv::Mat dark = off ? off->next() : cv::Mat();
    if (off && dark.empty()) {
      throw Error(count == 0 ? ErrorKind::kIo : ErrorKind::kBadInput,
                  count == 0 ? kNoVideo : fmt::format("ends behind {} frames, before the one with the laser on", count),
                  shot.off);
    }
    if (!use(checked({image, dark}), fmt::format("{}_{:06}", name, count))) return;
  }
}

GreyView view_of(const cv::Mat& image) {
  if (image.empty()) return {};
  return {image.ptr<std::uint8_t>(), image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step1())};
}

}  // namespace raybundle::apps
