// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Kalibr's camchain.yaml. Source: kalibr_common/ConfigReader.py, which takes a number without a point for no number;
// T_cn_cnm1 maps points of the camera before into this one.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "foreign_lens.hpp"
#include "format_list.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/rigid3_matrix.hpp"
#include "raybundle/scene/number.hpp"
#include "yaml_node.hpp"

namespace raybundle {
namespace {

const std::string kTopic = "/image_raw";

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
  const Eigen::Matrix4d matrix = matrix_from_rigid3(b_from_a);
  std::string text;
  for (int i = 0; i < 4; ++i) {
    text += "  - " + list_text({matrix(i, 0), matrix(i, 1), matrix(i, 2), matrix(i, 3)}) + "\n";
  }
  return text;
}

std::vector<NamedText> write(const ForeignFormat& format, const std::vector<ForeignCamera>& rig) {
  std::string text;
  for (std::size_t i = 0; i < rig.size(); ++i) {
    const auto& [camera, lens] = rig[i];
    const auto [model, distortion] = models_of(lens->name);
    const std::vector<double> values = values_of(*lens, camera.camera);
    const auto split = values.end() - static_cast<std::ptrdiff_t>(distortion_size(distortion));
    text += fmt::format("{}:\n", numbered_camera(i));
    if (i > 0) {
      text += "  T_cn_cnm1:\n" + matrix_text(camera.camera_from_rig * rig[i - 1].camera.camera_from_rig.inverse());
    }
    text += fmt::format("  camera_model: {}\n  intrinsics: {}\n", model, list_text({values.begin(), split}));
    text +=
        fmt::format("  distortion_model: {}\n  distortion_coeffs: {}\n", distortion, list_text({split, values.end()}));
    text += fmt::format("  resolution: [{}, {}]\n", camera.camera.size.width, camera.camera.size.height);
    text += fmt::format("  rostopic: {}\n", quoted("/" + file_stem(camera.name) + kTopic));
  }
  return {{std::string(format.file), text}};
}

Camera camera_from(const ForeignFormat& format, const YamlNode& node) {
  const YamlNode model = node.at("camera_model");
  std::string distortion = node.at("distortion_model").text();
  std::vector<double> values = node.at("intrinsics").numbers();
  const auto coefficients = node.find("distortion_coeffs");
  const std::vector<double> more = coefficients ? coefficients->numbers() : std::vector<double>{};
  if (distortion != "none") {
    values.insert(values.end(), more.begin(), more.end());
  } else if (std::ranges::any_of(more, [](double value) { return value != 0.0; })) {
    coefficients->fail("are there, but distortion_model is none; correct one of them");
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

Rigid3 transform_from(const YamlNode& node) {
  Eigen::Matrix4d matrix;
  const auto rows = node.rows(4);
  for (int i = 0; i < 4; ++i) {
    matrix.row(i) = Eigen::Map<const Eigen::RowVector4d>(rows[static_cast<std::size_t>(i)].data());
  }
  return rigid3_from(node, matrix);
}

// The place on the body that Kalibr, when an IMU was calibrated too, and OpenVINS say.
std::optional<Rigid3> camera_from_body(const YamlNode& node) {
  if (const auto from_body = node.find("T_cam_imu")) return transform_from(*from_body);
  if (const auto from_camera = node.find("T_imu_cam")) return transform_from(*from_camera).inverse();
  return std::nullopt;
}

// /left/image_raw: left.
std::string name_of(const YamlNode& node, std::size_t index) {
  const auto topic = node.find("rostopic");
  std::string name = topic ? topic->text() : "";
  if (!name.starts_with('/') || !name.ends_with(kTopic)) return numbered_camera(index);
  return name.substr(1, name.size() - 1 - kTopic.size());
}

std::vector<RigCamera> read(const ForeignFormat& format, std::span<const NamedText> files) {
  if (files.size() > 1) {
    throw Error(ErrorKind::kBadInput, "a rig of Kalibr is one file; name only that", files[1].name);
  }
  const YamlNode root = YamlNode::parse(files[0]);
  root.at("cam0");
  std::vector<RigCamera> rig;
  std::optional<Rigid3> body_from_first;
  while (const auto node = root.find(numbered_camera(rig.size()))) {
    RigCamera camera{name_of(*node, rig.size()), camera_from(format, *node), Rigid3{}};
    const auto from_body = camera_from_body(*node);
    if (rig.empty()) {
      if (from_body) body_from_first = from_body->inverse();
    } else if (from_body && body_from_first && !node->find("T_cn_cnm1")) {
      camera.camera_from_rig = *from_body * *body_from_first;
    } else {
      camera.camera_from_rig = transform_from(node->at("T_cn_cnm1")) * rig.back().camera_from_rig;
    }
    rig.push_back(camera);
  }
  for (const std::string& key : root.keys()) {
    const auto number = key.starts_with("cam") ? number_from<std::size_t>(key.substr(3)) : std::nullopt;
    if (number && *number >= rig.size()) root.at(key).fail("is there, but " + numbered_camera(rig.size()) + " is not");
  }
  return rig;
}

// Kalibr's reader ends at values that it takes for mistakes.
bool takes(const ForeignLens& lens, const Camera& camera) {
  const auto value = [&](std::string_view name) {
    const auto names = parameter_names(camera.model);
    return camera.parameters[std::ranges::find(names, name) - names.begin()];
  };
  if (camera.cx() <= 0.0 || camera.cy() <= 0.0) return false;
  if (lens.name.starts_with("omni")) return value("xi") >= 0.0;
  if (lens.name.starts_with("ds")) return value("alpha") >= 0.0 && value("alpha") < 1.0;
  if (lens.name.starts_with("eucm")) return value("alpha") >= 0.0 && value("alpha") < 1.0 && value("beta") >= 0.0;
  return true;
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
          .lenses = {foreign_lens("pinhole-radtan", "brown_conrady", "fx fy cx cy k1 k2 p1 p2"),
                     // Its reader knows pinhole-none but does not get on with it.
                     foreign_lens("pinhole-radtan", "pinhole", "fx fy cx cy 0 0 0 0"),
                     foreign_lens("pinhole-none", "pinhole", "fx fy cx cy"),
                     foreign_lens("pinhole-equi", "kannala_brandt", "fx fy cx cy k1 k2 k3 k4", kBeforeTheCamera),
                     foreign_lens("pinhole-fov", "field_of_view", "fx fy cx cy w", kBeforeTheCamera),
                     foreign_lens("omni-none", "unified", "xi fx fy cx cy"),
                     foreign_lens("omni-radtan", "unified", "xi fx fy cx cy k1 k2 p1 p2"),
                     foreign_lens("eucm-none", "extended_unified", "alpha beta fx fy cx cy"),
                     foreign_lens("ds-none", "double_sphere", "xi alpha fx fy cx cy")},
          .recognises = recognises,
          .write = write,
          .read = read,
          .takes = takes};
}

}  // namespace raybundle
