// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// cv::FileStorage YAML for each camera, with the names of OpenCV's sample calibration.cpp, and of stereo_calib.cpp for
// the place: x_in_camera = R x_in_first_camera + T. Coefficients in the order of cv::projectPoints, cv::fisheye (with
// fisheye_model: 1) and cv::omnidir (with xi).
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "foreign_lens.hpp"
#include "format_list.hpp"
#include "raybundle/geometry/error.hpp"
#include "yaml_node.hpp"

namespace raybundle {
namespace {

constexpr std::string_view kFisheye = "fisheye", kOmnidir = "omnidir";

std::vector<NamedText> write(const ForeignFormat&, const std::vector<ForeignCamera>& rig) {
  std::vector<NamedText> files;
  for (const auto& [rig_camera, lens] : rig) {
    const Camera& camera = rig_camera.camera;
    std::vector<double> values = values_of(*lens, camera);
    std::string text = fmt::format("%YAML:1.0\n---\ncamera_name: {}\nimage_width: {}\nimage_height: {}\n",
                                   quoted(rig_camera.name), camera.size.width, camera.size.height);
    text += fmt::format("fisheye_model: {}\n", lens->name == kFisheye ? 1 : 0);
    if (lens->name == kOmnidir) {
      text += "xi: " + real_text(values.front()) + "\n";
      values.erase(values.begin());
    }
    text +=
        opencv_matrix_text("camera_matrix", 3, 3, {camera.fx(), 0, camera.cx(), 0, camera.fy(), camera.cy(), 0, 0, 1});
    const std::vector<double> coefficients(values.begin() + 4, values.end());
    text += opencv_matrix_text("distortion_coefficients", static_cast<int>(coefficients.size()), 1, coefficients);
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation =
        rig_camera.camera_from_rig.rotation.toRotationMatrix();
    const Eigen::Vector3d& place = rig_camera.camera_from_rig.translation;
    text += opencv_matrix_text("R", 3, 3, {rotation.data(), rotation.data() + 9});
    text += opencv_matrix_text("T", 3, 1, {place.data(), place.data() + 3});
    files.push_back({file_stem(rig_camera.name) + ".yml", text});
  }
  return files;
}

// Which lens coefficients belong to: theirs are told by two flags and their number.
std::string_view lens_name_of(const YamlNode& root, std::size_t coefficients) {
  const auto fisheye = root.find("fisheye_model");
  if (fisheye && fisheye->number() != 0.0) return kFisheye;
  if (root.find("xi")) return kOmnidir;
  return coefficients <= 5 ? "plumb_bob" : coefficients == 8 ? "rational_polynomial" : "thin_prism";
}

Rigid3 place_from(const YamlNode& root) {
  const auto rotation = root.find("R"), translation = root.find("T");
  if (!rotation && !translation) return {};
  const std::vector<double> r = root.at("R").at("data").numbers(9);
  const std::vector<double> t = root.at("T").at("data").numbers(3);
  return rigid3_from(*rotation, Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r.data()),
                     Eigen::Map<const Eigen::Vector3d>(t.data()));
}

RigCamera camera_from(const ForeignFormat& format, const YamlNode& root, std::size_t index) {
  const auto width = root.find_first({"image_width", "image_Width"});
  const auto height = root.find_first({"image_height", "image_Height"});
  const auto matrix = root.find_first({"camera_matrix", "Camera_Matrix", "cameraMatrix", "K"});
  const auto distortion =
      root.find_first({"distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeffs", "D"});
  const YamlNode k_node = (matrix ? *matrix : root.at("camera_matrix")).at("data");
  const YamlNode d_node = (distortion ? *distortion : root.at("distortion_coefficients")).at("data");
  const ImageSize size =
      image_size_from(width ? *width : root.at("image_width"), height ? *height : root.at("image_height"));
  std::vector<double> values = pinhole_values(k_node);
  const std::vector<double> coefficients = d_node.numbers();
  const std::string_view name = lens_name_of(root, coefficients.size());
  if (name == kOmnidir) values.insert(values.begin(), root.at("xi").number());
  values.insert(values.end(), coefficients.begin(), coefficients.end());
  const auto [camera, fault] = camera_from_values(*lens_named(format, name, values.size()), size, values);
  if (!fault.empty()) d_node.fail(fmt::format("of {} with the camera matrix {}", name, fault));
  const auto camera_name = root.find("camera_name");
  return {camera_name ? camera_name->text() : numbered_camera(index), camera, place_from(root)};
}

std::vector<RigCamera> read(const ForeignFormat& format, std::span<const NamedText> files) {
  std::vector<RigCamera> rig;
  for (const NamedText& file : files) {
    const YamlNode root = YamlNode::parse(file);
    if (!rig.empty() && !root.find("R")) root.at("R");
    rig.push_back(camera_from(format, root, rig.size()));
  }
  return rig;
}

bool recognises(std::string_view text) {
  return text.find("!!opencv-matrix") != text.npos && text.find("body_T_cam") == text.npos;
}

}  // namespace

ForeignFormat opencv_format() {
  return {.name = "opencv",
          .what = "FileStorage YAML of OpenCV: cv::projectPoints, cv::fisheye, cv::omnidir",
          .file = "",
          .holds_extrinsics = true,
          .lenses = {foreign_lens("plumb_bob", "brown_conrady", "fx fy cx cy k1 k2 p1 p2 k3"),
                     foreign_lens("plumb_bob", "brown_conrady", "fx fy cx cy k1 k2 p1 p2"),
                     foreign_lens("plumb_bob", "pinhole", "fx fy cx cy 0 0 0 0 0"),
                     foreign_lens("rational_polynomial", "rational", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"),
                     foreign_lens("thin_prism", "thin_prism", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4"),
                     foreign_lens("thin_prism", "thin_prism", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 0 0"),
                     foreign_lens(kFisheye, "kannala_brandt", "fx fy cx cy k1 k2 k3 k4", kBeforeTheCamera),
                     foreign_lens(kOmnidir, "unified", "xi fx fy cx cy k1 k2 p1 p2")},
          .recognises = recognises,
          .write = write,
          .read = read};
}

}  // namespace raybundle
