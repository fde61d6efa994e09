// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Geometry>  // before OpenCV's header for it
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/eigen.hpp>

#include "export.hpp"
#include "output_folder.hpp"
#include "page_text.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/stereo/remap.hpp"
#include "stereo_flags.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

struct Flags {
  std::string folder;
  RectifyFlags rectify;
};

// Columns and rows of the camera's image for cv::remap; -1 where it shows nothing.
struct Maps {
  cv::Mat x, y;
};
Maps maps_of(const RemapTable& table) {
  Maps maps{cv::Mat(table.size.height, table.size.width, CV_32F, -1.0F),
            cv::Mat(table.size.height, table.size.width, CV_32F, -1.0F)};
  for (int v = 0, i = 0; v < table.size.height; ++v) {
    for (int u = 0; u < table.size.width; ++u, ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (!table.covered[at]) continue;
      maps.x.at<float>(v, u) = static_cast<float>(table.x_256[at]) / 256.0F;
      maps.y.at<float>(v, u) = static_cast<float>(table.y_256[at]) / 256.0F;
    }
  }
  return maps;
}

cv::Mat rotation_of(const Eigen::Quaterniond& rotation) {
  cv::Mat matrix;
  cv::eigen2cv(Eigen::Matrix3d(rotation.toRotationMatrix()), matrix);
  return matrix;
}

// The projections of both rectified cameras, as cv::stereoRectify names them; the right one holds -focal · baseline.
cv::Mat projection_of(const Rectification& pair, bool right) {
  const RectifiedCamera& camera = pair.camera;
  return (cv::Mat_<double>(3, 4) << camera.focal_px, 0, camera.centre_px.x(),
          right ? -camera.focal_px * pair.baseline_m : 0.0, 0, camera.focal_px, camera.centre_px.y(), 0, 0, 0, 1, 0);
}

std::string yaml_of(const Rectification& pair, const Maps& left, const Maps& right) {
  cv::FileStorage file(".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  file << "projection" << std::string(rectified_projection_name(pair.camera.projection));
  file << "width" << pair.camera.size.width << "height" << pair.camera.size.height;
  file << "focal_px" << pair.camera.focal_px << "baseline_m" << pair.baseline_m;
  file << "centre_px" << cv::Vec2d(pair.camera.centre_px.x(), pair.camera.centre_px.y());
  file << "R1" << rotation_of(pair.rectified_from_left) << "R2" << rotation_of(pair.rectified_from_right);
  if (const auto q = q_matrix(pair.camera, pair.baseline_m)) {
    cv::Mat matrix;
    cv::eigen2cv(*q, matrix);
    file << "P1" << projection_of(pair, false) << "P2" << projection_of(pair, true) << "Q" << matrix;
  }
  file << "left_map_x" << left.x << "left_map_y" << left.y << "right_map_x" << right.x << "right_map_y" << right.y;
  return file.releaseAndGetString();
}

bool write(const ExportRequest& request, const Flags& flags) {
  if (flags.folder.empty()) return false;
  require_writable(flags.folder);
  const CalibrationFile file = read_calibration(request.calibration);
  const auto [left, right] = camera_pair(file.calibration, flags.rectify);
  const Rectification pair = rectify(left, right, rectify_options(flags.rectify));
  const Maps left_maps = maps_of(remap_table(left.camera, pair.camera, pair.rectified_from_left));
  const Maps right_maps = maps_of(remap_table(right.camera, pair.camera, pair.rectified_from_right));
  const fs::path path = fs::path(flags.folder) / "rectification.yml";
  const std::string text = yaml_of(pair, left_maps, right_maps);
  write_results(flags.folder, {{path, text}});
  if (request.json) {
    const nlohmann::ordered_json result{{"file", path.string()},
                                        {"projection", rectified_projection_name(pair.camera.projection)},
                                        {"width", pair.camera.size.width},
                                        {"height", pair.camera.size.height}};
    fmt::print("{}\n", text_of_json(result, 2));
    return true;
  }
  fmt::print("{}\nwrote {}: R1, R2, {}and maps for cv::remap\n", rectification_text(pair), path.string(),
             pair.camera.projection == RectifiedProjection::kPinhole ? "P1, P2, Q " : "");
  return true;
}

}  // namespace

Export add_rectification_export(CLI::App& verb) {
  auto flags = std::make_shared<Flags>();
  CLI::Option* folder = verb.add_option("--rectification", flags->folder,
                                        "folder for the maps and matrices of a rectified pair, for OpenCV")
                            ->type_name("DIR");
  declare_rectify_flags(verb, flags->rectify);
  for (CLI::Option* option : flags->rectify.options) option->needs(folder);
  for (const char* of_others : {"--output", "--camera"}) folder->excludes(verb.get_option(of_others));
  return [flags](const ExportRequest& request) { return write(request, *flags); };
}

}  // namespace raybundle::apps
