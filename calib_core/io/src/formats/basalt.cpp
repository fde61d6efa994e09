// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Basalt's calibration.json. Source: basalt-headers serialization/headers_serialization.h, which wants every key that is
// written here; T_imu_cam maps points of a camera into the body, here the first camera.
#include "../image_side.hpp"
#include "../json_node.hpp"
#include "../json_text.hpp"
#include "foreign_lens.hpp"
#include "format_list.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"

namespace raybundle {
namespace {

constexpr const char* kTranslation[] = {"px", "py", "pz"};
constexpr const char* kRotation[] = {"qx", "qy", "qz", "qw"};

std::vector<NamedText> write(const ForeignFormat& format, const std::vector<ForeignCamera>& rig) {
  OrderedJson places = OrderedJson::array(), lenses = OrderedJson::array(), sizes = OrderedJson::array();
  OrderedJson vignettes = OrderedJson::array();
  for (const auto& [camera, lens] : rig) {
    const Rigid3 first_from_camera = camera.camera_from_rig.inverse();
    OrderedJson place, parameters;
    for (int i = 0; i < 3; ++i) place[kTranslation[i]] = first_from_camera.translation[i];
    for (int i = 0; i < 4; ++i) place[kRotation[i]] = first_from_camera.rotation.coeffs()[i];
    const std::vector<double> values = values_of(*lens, camera.camera);
    auto value = values.begin();
    for (const std::string_view name : places_of(*lens)) parameters[std::string(name)] = *value++;
    places.push_back(place);
    lenses.push_back({{"camera_type", lens->name}, {"intrinsics", parameters}});
    sizes.push_back({camera.camera.size.width, camera.camera.size.height});
  }
  const OrderedJson nine(9, 0.0), twelve(12, 0.0);
  const OrderedJson json{{"value0",
                          {{"T_imu_cam", places},
                           {"intrinsics", lenses},
                           {"resolution", sizes},
                           {"calib_accel_bias", nine},
                           {"calib_gyro_bias", twelve},
                           {"imu_update_rate", 200.0},
                           {"accel_noise_std", {0.016, 0.016, 0.016}},
                           {"gyro_noise_std", {0.000282, 0.000282, 0.000282}},
                           {"accel_bias_std", {0.001, 0.001, 0.001}},
                           {"gyro_bias_std", {0.0001, 0.0001, 0.0001}},
                           {"cam_time_offset_ns", 0},
                           {"vignette", vignettes}}}};
  return {{std::string(format.file), pretty_text(json)}};
}

Camera camera_from(const ForeignFormat& format, const JsonNode& node, ImageSize size) {
  const JsonNode type = node.at("camera_type");
  const JsonNode intrinsics = node.at("intrinsics");
  const ForeignLens* lens = lens_named(format, type.text(), 0);
  if (lens == nullptr) type.fail("is " + in_quotes(type.text()) + "; known: " + known_lenses(format));
  std::vector<double> values;
  for (const std::string_view name : places_of(*lens)) values.push_back(intrinsics.at(name).number());
  const auto [camera, fault] = camera_from_values(*lens, size, values);
  if (!fault.empty()) intrinsics.fail(fault);
  return camera;
}

Rigid3 camera_from_body(const JsonNode& node) {
  Rigid3 body_from_camera;
  for (int i = 0; i < 3; ++i) body_from_camera.translation[i] = node.at(kTranslation[i]).number();
  for (int i = 0; i < 4; ++i) body_from_camera.rotation.coeffs()[i] = node.at(kRotation[i]).number();
  body_from_camera.rotation = unit_quaternion(node, body_from_camera.rotation);
  return body_from_camera.inverse();
}

std::vector<RigCamera> read(const ForeignFormat& format, std::span<const NamedText> files) {
  if (files.size() > 1) {
    throw Error(ErrorKind::kBadInput, "a rig of Basalt is one file; name only that", files[1].name);
  }
  const JsonDocument document = parse_json(files[0].text, files[0].name);
  const JsonNode root(document);
  const JsonNode value = root.at("value0");
  const JsonNode places = value.at("T_imu_cam"), lenses = value.at("intrinsics"), sizes = value.at("resolution");
  places.expect_array_size(lenses.array_size());
  sizes.expect_array_size(lenses.array_size());
  std::vector<RigCamera> rig;
  for (std::size_t i = 0; i < lenses.array_size(); ++i) {
    const JsonNode size = sizes[i], lens = lenses[i], place = places[i];
    size.expect_array_size(2);
    rig.push_back({numbered_camera(i),
                   camera_from(format, lens,
                               {size[0].whole_number(1, kMaxImageSide_px), size[1].whole_number(1, kMaxImageSide_px)}),
                   camera_from_body(place)});
  }
  return rig;
}

bool recognises(std::string_view text) { return text.find("\"T_imu_cam\"") != text.npos; }

}  // namespace

ForeignFormat basalt_format() {
  return {.name = "basalt",
          .what = "calibration.json of Basalt",
          .file = "calibration.json",
          .holds_extrinsics = true,
          .lenses = {foreign_lens("pinhole", "pinhole", "fx fy cx cy"),
                     foreign_lens("kb4", "kannala_brandt", "fx fy cx cy k1 k2 k3 k4"),
                     foreign_lens("ds", "double_sphere", "fx fy cx cy xi alpha"),
                     foreign_lens("eucm", "extended_unified", "fx fy cx cy alpha beta"),
                     foreign_lens("ucm", "extended_unified", "fx fy cx cy alpha")},
          .recognises = recognises,
          .write = write,
          .read = read};
}

}  // namespace raybundle
