// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Kalibr's camchain.yaml. Source: kalibr_common/ConfigReader.py, which takes a number without a point for no number;
// T_cn_cnm1 maps points of the camera before into this one.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "foreign_lens.hpp"
#include "format_list.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"
#include "yaml_node.hpp"

namespace raybundle {
namespace {

// What the file calls the distortions that people, and ForeignName, call otherwise.
constexpr std::pair<std::string_view, std::string_view> kDistortions[] = {{"equi", "equidistant"}};

// pinhole-equi: pinhole and equidistant.
std::pair<std::string, std::string> models_of(std::string_view name) {
  const std::size_t dash = name.find('-');
  std::string_view distortion = name.substr(dash + 1);
  for (const auto& [short_name, in_file] : kDistortions) {
    if (distortion == short_name) distortion = in_file;
  }
  return {std::string(name.substr(0, dash)), std::string(distortion)};
}

// How many of a lens's values are distortion coefficients, which have a list of their own.
std::size_t distortion_size(std::string_view distortion) {
  return distortion == "none" ? 0 : distortion == "fov" ? 1 : 4;
}

std::string matrix_text(const Rigid3& b_from_a) {
  Eigen::Matrix<double, 4, 4> matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = b_from_a.rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = b_from_a.translation;
  std::string text;
  for (int i = 0; i < 4; ++i) {
    text += "  - " + list_text({matrix(i, 0), matrix(i, 1), matrix(i, 2), matrix(i, 3)}) + "\n";
  }
  return text;
}

std::vector<NamedText> write(const ForeignFormat& format, const std::vector<RigCamera>& rig) {
  std::string text;
  for (std::size_t i = 0; i < rig.size(); ++i) {
    const ForeignLens& lens = *lens_for(format, rig[i].camera);
    const auto [model, distortion] = models_of(lens.name);
    const std::vector<double> values = values_of(lens, rig[i].camera);
    const auto split = values.end() - static_cast<std::ptrdiff_t>(distortion_size(distortion));
    text += fmt::format("{}:\n", numbered_camera(i));
    if (i > 0) {
      text += "  T_cn_cnm1:\n" + matrix_text(rig[i].camera_from_rig * rig[i - 1].camera_from_rig.inverse());
    }
    text += fmt::format("  camera_model: {}\n  intrinsics: {}\n", model, list_text({values.begin(), split}));
    text +=
        fmt::format("  distortion_model: {}\n  distortion_coeffs: {}\n", distortion, list_text({split, values.end()}));
    text += fmt::format("  resolution: [{}, {}]\n", rig[i].camera.size.width, rig[i].camera.size.height);
    text += fmt::format("  rostopic: /{}/image_raw\n", rig[i].name);
  }
  return {{std::string(format.file), text}};
}

Camera camera_from(const ForeignFormat& format, const YamlNode& node) {
  const YamlNode model = node.at("camera_model");
  std::string distortion = node.at("distortion_model").text();
  std::vector<double> values = node.at("intrinsics").numbers();
  if (distortion != "none") {
    const std::vector<double> more = node.at("distortion_coeffs").numbers();
    values.insert(values.end(), more.begin(), more.end());
  }
  for (const auto& [short_name, in_file] : kDistortions) {
    if (distortion == in_file) distortion = short_name;
  }
  const std::string name = model.text() + "-" + distortion;
  const ForeignLens* lens = lens_named(format, name, values.size());
  if (lens == nullptr) model.fail("and distortion_model are " + name + "; known: " + known_lenses(format));
  const auto [camera, fault] = camera_from_values(*lens, image_size_from(node.at("resolution")), values);
  if (!fault.empty()) node.at("intrinsics").fail("of " + name + " " + fault);
  return camera;
}

Rigid3 place_from(const YamlNode& node) {
  Eigen::Matrix4d matrix;
  const auto rows = node.rows(4);
  for (int i = 0; i < 4; ++i)
    matrix.row(i) = Eigen::Map<const Eigen::RowVector4d>(rows[static_cast<std::size_t>(i)].data());
  return rigid3_from(node, matrix.topLeftCorner<3, 3>(), matrix.topRightCorner<3, 1>());
}

std::vector<RigCamera> read(const ForeignFormat& format, std::span<const NamedText> files) {
  std::vector<RigCamera> rig;
  for (const NamedText& file : files) {
    const YamlNode root = YamlNode::parse(file);
    while (const auto node = root.find(numbered_camera(rig.size()))) {
      RigCamera camera{numbered_camera(rig.size()), camera_from(format, *node), Rigid3{}};
      if (!rig.empty()) camera.camera_from_rig = place_from(node->at("T_cn_cnm1")) * rig.back().camera_from_rig;
      rig.push_back(camera);
    }
    if (rig.empty()) root.at("cam0");
  }
  return rig;
}

bool recognises(std::string_view text) {
  return text.find("cam0:") != text.npos && text.find("distortion_model:") != text.npos;
}

}  // namespace

ForeignFormat kalibr_format() {
  return {.name = "kalibr",
          .what = "camchain.yaml of Kalibr",
          .file = "camchain.yaml",
          .holds_extrinsics = true,
          .lenses = {foreign_lens("pinhole-none", "pinhole", "fx fy cx cy"),
                     foreign_lens("pinhole-radtan", "brown_conrady", "fx fy cx cy k1 k2 p1 p2"),
                     foreign_lens("pinhole-equi", "kannala_brandt", "fx fy cx cy k1 k2 k3 k4"),
                     foreign_lens("pinhole-fov", "field_of_view", "fx fy cx cy w"),
                     foreign_lens("omni-none", "unified", "xi fx fy cx cy"),
                     foreign_lens("omni-radtan", "unified", "xi fx fy cx cy k1 k2 p1 p2"),
                     foreign_lens("eucm-none", "extended_unified", "alpha beta fx fy cx cy"),
                     foreign_lens("ds-none", "double_sphere", "xi alpha fx fy cx cy")},
          .recognises = recognises,
          .write = write,
          .read = read};
}

}  // namespace raybundle
