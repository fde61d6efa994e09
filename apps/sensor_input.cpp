// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "sensor_input.hpp"

#include <fmt/format.h>

#include <opencv2/core.hpp>

#include "image_files.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/io/hash.hpp"
#include "raybundle/scene/csv.hpp"

namespace raybundle::apps {

void declare_sensor_flags(CLI::App& verb, SensorFlags& flags) {
  verb.add_option("--nearest", flags.nearest_m, "least depth of a dot [m]")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  verb.add_option("--farthest", flags.farthest_m, "greatest depth of a dot [m]")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  verb.add_option("--tolerance", flags.tolerance_px,
                  "of a dot from its beam's curve [px]; what the calibration advises unless said, else 1")
      ->check(CLI::Range(0.05, 20.0));
}

SensorTable table_from_calibration(const std::string& path, const SensorFlags& flags) {
  const CalibrationFile file = read_calibration(path);
  const auto& laser = file.calibration.laser;
  SensorRange range{flags.nearest_m, flags.farthest_m, SensorRange{}.tolerance_px};
  if (laser && laser->advice) range.tolerance_px = laser->advice->ambiguity.tolerance_px;
  if (flags.tolerance_px) range.tolerance_px = *flags.tolerance_px;
  const std::string origin = fmt::format("{} of SHA-256 {}", path, sha256_of_file(path));
  return sensor_table(file.calibration, flags.camera, range, origin);
}

SensorTable sensor_of(const std::string& path, const SensorFlags& flags) {
  return is_table(text_of_file(path)) ? read_table(path) : table_from_calibration(path, flags);
}

cv::Mat sensor_image(const std::string& path, const SensorTable& table) {
  std::string reason;
  cv::Mat image = read_gray(path, reason);
  if (image.empty()) throw Error(ErrorKind::kIo, reason.empty() ? "is no image" : reason, path);
  if (image.cols != table.rays.size.width || image.rows != table.rays.size.height) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("is of {}x{} pixels, and camera {} was calibrated with {}x{}", image.cols, image.rows,
                            table.camera, table.rays.size.width, table.rays.size.height),
                path);
  }
  if (image.depth() == CV_8U) return image;
  double largest = 0.0;
  cv::minMaxLoc(image, nullptr, &largest);
  const double full = largest < 1024.0 ? 1023.0 : largest < 4096.0 ? 4095.0 : 65535.0;
  cv::Mat grey;
  image.convertTo(grey, CV_8U, 255.0 / full);
  return grey;
}

GreyView view_of(const cv::Mat& image) {
  return {image.ptr<std::uint8_t>(), image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step1())};
}

}  // namespace raybundle::apps
