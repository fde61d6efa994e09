// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// COLMAP: cameras.txt of a text model, and for a rig rig_config.json of its rig_configurator, with a folder of images
// for each camera. Sources: colmap doc/format.rst, doc/rigs.rst, sensor/models.h. The centre of the top-left pixel is
// (0.5, 0.5) there; quaternions begin with w.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <sstream>

#include "../image_side.hpp"
#include "../json_node.hpp"
#include "../json_text.hpp"
#include "foreign_lens.hpp"
#include "format_list.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/number.hpp"

namespace raybundle {
namespace {

constexpr const char* kCameras = "cameras.txt";
constexpr const char* kRig = "rig_config.json";
constexpr double kHalfPixel = 0.5;

Camera shifted(Camera camera, double by_px) {
  camera.parameters.segment<2>(2).array() += by_px;
  return camera;
}

std::vector<NamedText> write(const ForeignFormat&, const std::vector<ForeignCamera>& rig) {
  std::string text = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  OrderedJson cameras = OrderedJson::array();
  for (std::size_t i = 0; i < rig.size(); ++i) {
    const auto& [rig_camera, lens] = rig[i];
    const Camera& camera = rig_camera.camera;
    const std::vector<double> values = values_of(*lens, shifted(camera, kHalfPixel));
    text += fmt::format("{} {} {} {} {}\n", i + 1, lens->name, camera.size.width, camera.size.height,
                        fmt::join(values, " "));
    OrderedJson entry{{"image_prefix", file_stem(rig_camera.name) + "/"}};
    if (i == 0) {
      entry["ref_sensor"] = true;
    } else {
      const Eigen::Quaterniond& q = rig_camera.camera_from_rig.rotation;
      entry["cam_from_rig_rotation"] = {q.w(), q.x(), q.y(), q.z()};
      entry["cam_from_rig_translation"] = json_from_vector(rig_camera.camera_from_rig.translation);
    }
    entry["camera_model_name"] = lens->name;
    entry["camera_params"] = values;
    cameras.push_back(entry);
  }
  std::vector<NamedText> files{{kCameras, text}};
  if (rig.size() > 1) files.push_back({kRig, pretty_text(OrderedJson::array({{{"cameras", cameras}}}))});
  return files;
}

[[noreturn]] void fail(const std::string& what, const std::string& where) {
  throw Error(ErrorKind::kBadInput, what + "; correct it", where);
}

Camera camera_from(const ForeignFormat& format, const std::string& model, ImageSize size,
                   const std::vector<double>& values, const std::string& where) {
  const ForeignLens* lens = lens_named(format, model, values.size());
  if (lens == nullptr) fail("the model is " + in_quotes(model) + "; known: " + known_lenses(format), where);
  const auto [camera, fault] = camera_from_values(*lens, size, values);
  if (!fault.empty()) fail("the camera, " + model + ", " + fault, where);
  return shifted(camera, -kHalfPixel);
}

// CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]
std::pair<int, Camera> camera_of_line(const ForeignFormat& format, const std::string& line, const std::string& where) {
  std::istringstream words(line);
  std::string id, model, word;
  words >> id >> model;
  const auto number = number_from<int>(id);
  std::vector<double> values;
  while (words >> word) {
    const auto value = number_from<double>(word);
    if (!value) fail(in_quotes(word) + " is no number", where);
    values.push_back(*value);
  }
  const bool sized = number && values.size() > 2 && std::all_of(values.begin(), values.begin() + 2, [](double side) {
                       return side >= 1 && side <= kMaxImageSide_px && side == static_cast<int>(side);
                     });
  if (!sized) fail("has to be CAMERA_ID, MODEL, WIDTH, HEIGHT and parameters", where);
  return {*number, camera_from(format, model, {static_cast<int>(values[0]), static_cast<int>(values[1])},
                               {values.begin() + 2, values.end()}, where)};
}

void read_cameras(const ForeignFormat& format, const NamedText& file, std::map<int, Camera>& cameras) {
  std::istringstream lines(file.text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.find_first_not_of(" \t\r") == line.npos || line.front() == '#') continue;
    const std::string where = file.name + ":" + std::to_string(number);
    const auto [id, camera] = camera_of_line(format, line, where);
    if (!cameras.emplace(id, camera).second) fail("camera " + std::to_string(id) + " stands twice", where);
  }
}

Rigid3 place_from(const JsonNode& node) {
  const JsonNode rotation = node.at("cam_from_rig_rotation");
  const Eigen::Vector4d q = rotation.vector<4>();
  const JsonNode translation = node.at("cam_from_rig_translation");
  return {unit_quaternion(rotation, {q[0], q[1], q[2], q[3]}), translation.vector<3>()};
}

// What the rig says of the lens has to be what cameras.txt says of the camera in the same place of its order.
void expect_same_lens(const ForeignFormat& format, const JsonNode& node, const Camera& camera) {
  const auto model = node.find("camera_model_name");
  const auto parameters = node.find("camera_params");
  if (!model || !parameters) return;
  std::vector<double> values;
  for (std::size_t i = 0; i < parameters->array_size(); ++i) {
    const JsonNode value = (*parameters)[i];
    values.push_back(value.number());
  }
  const Camera said = camera_from(format, model->text(), camera.size, values, "camera_params");
  if (said.model == camera.model && said.parameters.isApprox(camera.parameters, 1e-9)) return;
  parameters->fail("are not those of the camera in the same place of cameras.txt; put both in the same order");
}

// Names and places of the cameras that cameras.txt has in the same order.
void read_rig(const ForeignFormat& format, const NamedText& file, std::vector<RigCamera>& rig) {
  const JsonDocument document = parse_json(file.text, file.name);
  const JsonNode root(document);
  root.expect_array_size(1);
  const JsonNode only = root[0];
  const JsonNode cameras = only.at("cameras");
  cameras.expect_array_size(rig.size());
  for (std::size_t i = 0; i < rig.size(); ++i) {
    const JsonNode node = cameras[i];
    expect_same_lens(format, node, rig[i].camera);
    const JsonNode prefix = node.at("image_prefix");
    std::string name = prefix.name();
    while (name.ends_with('/')) name.pop_back();
    if (!name.empty()) rig[i].name = name.substr(name.find_last_of('/') + 1);
    const auto reference = node.find("ref_sensor");
    if (!reference || !reference->boolean()) rig[i].camera_from_rig = place_from(node);
  }
}

std::vector<RigCamera> read(const ForeignFormat& format, std::span<const NamedText> files) {
  const auto is_rig = [](const NamedText& file) { return file.text.find("\"cameras\"") != std::string::npos; };
  std::map<int, Camera> cameras;  // by id
  for (const NamedText& file : files) {
    if (!is_rig(file)) read_cameras(format, file, cameras);
  }
  if (cameras.empty()) {
    throw Error(ErrorKind::kBadInput, std::string("has no cameras; name ") + kCameras + " too", files[0].name);
  }
  std::vector<RigCamera> rig;
  for (const auto& [id, camera] : cameras) rig.push_back({numbered_camera(rig.size()), camera, Rigid3{}});
  const auto placed = std::ranges::find_if(files, is_rig);
  if (placed != files.end()) {
    read_rig(format, *placed, rig);
  } else if (rig.size() > 1) {
    throw Error(ErrorKind::kBadInput,
                std::string("has several cameras, but not where they stand; name ") + kRig + " too", files[0].name);
  }
  return rig;
}

bool recognises(std::string_view text) {
  return text.find("image_prefix") != text.npos || text.find("CAMERA_ID, MODEL") != text.npos;
}

}  // namespace

ForeignFormat colmap_format() {
  return {.name = "colmap",
          .what = "cameras.txt and rig_config.json of COLMAP",
          .file = "",
          .holds_extrinsics = true,
          .lenses = {foreign_lens("PINHOLE", "pinhole", "fx fy cx cy"),
                     foreign_lens("OPENCV", "brown_conrady", "fx fy cx cy k1 k2 p1 p2"),
                     foreign_lens("FULL_OPENCV", "rational", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"),
                     foreign_lens("FULL_OPENCV", "brown_conrady", "fx fy cx cy k1 k2 p1 p2 k3 0 0 0"),
                     foreign_lens("OPENCV_FISHEYE", "kannala_brandt", "fx fy cx cy k1 k2 k3 k4", kBeforeTheCamera),
                     foreign_lens("FOV", "field_of_view", "fx fy cx cy w", kBeforeTheCamera),
                     foreign_lens("EUCM", "extended_unified", "fx fy cx cy alpha beta"),
                     foreign_lens("SIMPLE_PINHOLE", "pinhole", "f cx cy"),
                     foreign_lens("SIMPLE_RADIAL", "brown_conrady", "f cx cy k1"),
                     foreign_lens("RADIAL", "brown_conrady", "f cx cy k1 k2"),
                     foreign_lens("SIMPLE_RADIAL_FISHEYE", "kannala_brandt", "f cx cy k1", kBeforeTheCamera),
                     foreign_lens("RADIAL_FISHEYE", "kannala_brandt", "f cx cy k1 k2", kBeforeTheCamera)},
          .recognises = recognises,
          .write = write,
          .read = read};
}

}  // namespace raybundle
