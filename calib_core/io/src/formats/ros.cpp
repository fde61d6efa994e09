// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// ROS: camera_info as YAML for each camera, and for a rig the places of its cameras as URDF. Sources:
// camera_calibration_parsers/src/parse_yml.cpp, sensor_msgs/msg/CameraInfo.msg; URDF: the pose of the child in the
// parent, roll pitch yaw about fixed axes.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "foreign_lens.hpp"
#include "format_list.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"
#include "yaml_node.hpp"

namespace raybundle {
namespace {

std::string matrix_text(const char* key, int rows, int columns, const std::vector<double>& data) {
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: {}\n", key, rows, columns, list_text(data));
}

std::string camera_info(const ForeignLens& lens, const RigCamera& rig_camera) {
  const Camera& camera = rig_camera.camera;
  const std::vector<double> values = values_of(lens, camera);
  const double fx = camera.fx(), fy = camera.fy(), cx = camera.cx(), cy = camera.cy();
  const std::vector<double> coefficients(values.begin() + 4, values.end());
  return fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", camera.size.width, camera.size.height,
                     quoted(rig_camera.name)) +
         matrix_text("camera_matrix", 3, 3, {fx, 0, cx, 0, fy, cy, 0, 0, 1}) +
         fmt::format("distortion_model: {}\n", lens.name) +
         matrix_text("distortion_coefficients", 1, static_cast<int>(coefficients.size()), coefficients) +
         matrix_text("rectification_matrix", 3, 3, {1, 0, 0, 0, 1, 0, 0, 0, 1}) +
         matrix_text("projection_matrix", 3, 4, {fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0});
}

// Rotation = Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& rotation) {
  const double cosine = std::hypot(rotation(0, 0), rotation(1, 0));  // of the pitch
  const double pitch = std::atan2(-rotation(2, 0), cosine);
  if (cosine < 1e-9) return {std::atan2(-rotation(1, 2), rotation(1, 1)), pitch, 0.0};  // straight up or down: one turn
  return {std::atan2(rotation(2, 1), rotation(2, 2)), pitch, std::atan2(rotation(1, 0), rotation(0, 0))};
}

std::string in_xml(const std::string& name) {
  std::string text;
  for (const char c : file_stem(name)) {
    text += c == '<' ? "&lt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
  }
  return text;
}

// Frames as ROS calls them: optical ones, x right, y down, z forward.
std::string urdf(const std::vector<ForeignCamera>& rig) {
  std::string text = "<?xml version=\"1.0\"?>\n<robot name=\"rig\">\n";
  for (const auto& [camera, lens] : rig) {
    text += fmt::format("  <link name=\"{}_optical_frame\"/>\n", in_xml(camera.name));
  }
  for (std::size_t i = 1; i < rig.size(); ++i) {
    const Rigid3 first_from_camera = rig[i].camera.camera_from_rig.inverse();
    const Eigen::Vector3d angles = roll_pitch_yaw(first_from_camera.rotation.toRotationMatrix());
    const Eigen::Vector3d& place = first_from_camera.translation;
    text += fmt::format(
        "  <joint name=\"{0}_joint\" type=\"fixed\">\n    <parent link=\"{1}_optical_frame\"/>\n"
        "    <child link=\"{0}_optical_frame\"/>\n    <origin xyz=\"{2} {3} {4}\" rpy=\"{5} {6} {7}\"/>\n  </joint>\n",
        in_xml(rig[i].camera.name), in_xml(rig[0].camera.name), place.x(), place.y(), place.z(), angles.x(), angles.y(),
        angles.z());
  }
  return text + "</robot>\n";
}

std::vector<NamedText> write(const ForeignFormat&, const std::vector<ForeignCamera>& rig) {
  std::vector<NamedText> files;
  for (const auto& [camera, lens] : rig) {
    files.push_back({file_stem(camera.name) + ".yaml", camera_info(*lens, camera)});
  }
  if (rig.size() > 1) files.push_back({"rig.urdf", urdf(rig)});
  return files;
}

RigCamera camera_from(const ForeignFormat& format, const YamlNode& root) {
  const ImageSize size = image_size_from(root.at("image_width"), root.at("image_height"));
  std::vector<double> values = pinhole_values(root.at("camera_matrix").at("data"));
  const auto model = root.find("distortion_model");
  if (const auto ignored = root.find("camera_model"); ignored && !model) {
    ignored->fail(
        "is not what ROS reads: it takes such a file for plumb_bob; write distortion_model: equidistant for "
        "a fisheye, or plumb_bob");
  }
  const std::string name = model ? model->text() : "plumb_bob";  // as ROS takes a file without one
  const YamlNode coefficients = root.at("distortion_coefficients").at("data");
  const std::vector<double> more = coefficients.numbers();
  values.insert(values.end(), more.begin(), more.end());
  const ForeignLens* lens = lens_named(format, name, values.size());
  if (lens == nullptr) model->fail("is " + in_quotes(name) + "; known: " + known_lenses(format));
  const auto [camera, fault] = camera_from_values(*lens, size, values);
  if (!fault.empty()) coefficients.fail("of " + name + " with its camera_matrix " + fault);
  const auto camera_name = root.find("camera_name");
  return {camera_name ? camera_name->text() : numbered_camera(0), camera, Rigid3{}};
}

std::vector<RigCamera> read(const ForeignFormat& format, std::span<const NamedText> files) {
  if (files.size() > 1) {
    throw Error(ErrorKind::kBadInput,
                "ROS's camera_info does not say where a camera stands: name one file, and its camera becomes a rig of "
                "its own",
                files[1].name);
  }
  return {camera_from(format, YamlNode::parse(files.front()))};
}

bool recognises(std::string_view text) {
  return text.find("image_width:") != text.npos && text.find("distortion_coefficients:") != text.npos &&
         text.find("opencv-matrix") == text.npos;
}

}  // namespace

ForeignFormat ros_format() {
  return {.name = "ros",
          .what = "camera_info YAML of ROS, and URDF of the rig",
          .file = "",
          .holds_extrinsics = false,
          .lenses = {foreign_lens("plumb_bob", "brown_conrady", "fx fy cx cy k1 k2 p1 p2 k3"),
                     foreign_lens("plumb_bob", "brown_conrady", "fx fy cx cy k1 k2 p1 p2"),
                     foreign_lens("plumb_bob", "pinhole", "fx fy cx cy 0 0 0 0 0"),
                     foreign_lens("plumb_bob", "pinhole", "fx fy cx cy"),
                     foreign_lens("rational_polynomial", "rational", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"),
                     foreign_lens("equidistant", "kannala_brandt", "fx fy cx cy k1 k2 k3 k4", kBeforeTheCamera)},
          .recognises = recognises,
          .write = write,
          .read = read};
}

}  // namespace raybundle
