// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// CamOdoCal's YAML for each camera, which VINS-Fusion reads too, and for a rig the places that VINS-Fusion's own file
// wants. Sources: camodocal camera_models/*Camera.cc; VINS-Fusion's body_T_camN maps points of a camera into the body,
// here the first camera. KANNALA_BRANDT counts its coefficients from k2.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "foreign_lens.hpp"
#include "format_list.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/rigid3_matrix.hpp"
#include "raybundle/scene/csv.hpp"
#include "yaml_node.hpp"

namespace raybundle {
namespace {

/// A part of the file: `keys` are theirs for as many of a lens's values.
struct Section {
  const char* name;
  std::vector<const char*> keys;
};

// In the order of the lens's places.
std::vector<Section> sections_of(std::string_view lens) {
  const Section distortion{"distortion_parameters", {"k1", "k2", "p1", "p2"}};
  if (lens == "PINHOLE") return {distortion, {"projection_parameters", {"fx", "fy", "cx", "cy"}}};
  if (lens == "KANNALA_BRANDT") return {{"projection_parameters", {"k2", "k3", "k4", "k5", "mu", "mv", "u0", "v0"}}};
  return {{"mirror_parameters", {"xi"}}, distortion, {"projection_parameters", {"gamma1", "gamma2", "u0", "v0"}}};
}

std::string camera_text(const ForeignLens& lens, const RigCamera& camera) {
  std::string text = fmt::format("%YAML:1.0\n---\nmodel_type: {}\ncamera_name: {}\nimage_width: {}\nimage_height: {}\n",
                                 lens.name, quoted(camera.name), camera.camera.size.width, camera.camera.size.height);
  const std::vector<double> values = values_of(lens, camera.camera);
  auto value = values.begin();
  for (const Section& section : sections_of(lens.name)) {
    text += fmt::format("{}:\n", section.name);
    for (const char* key : section.keys) text += fmt::format("   {}: {}\n", key, real_text(*value++));
  }
  return text;
}

std::string file_of(const RigCamera& camera) { return file_stem(camera.name) + ".yaml"; }

// camN_calib, as VINS-Fusion has it, says of which file body_T_camN is.
std::string places_text(const std::vector<ForeignCamera>& rig) {
  std::string text = "%YAML:1.0\n---\n";
  for (std::size_t i = 0; i < rig.size(); ++i) {
    const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> first_from_camera =
        matrix_from_rigid3(rig[i].camera.camera_from_rig.inverse());
    text += fmt::format("cam{}_calib: {}\n", i, quoted(file_of(rig[i].camera)));
    text += opencv_matrix_text(fmt::format("body_T_cam{}", i), 4, 4,
                               {first_from_camera.data(), first_from_camera.data() + 16});
  }
  return text;
}

std::vector<NamedText> write(const ForeignFormat&, const std::vector<ForeignCamera>& rig) {
  std::vector<NamedText> files;
  for (const auto& [camera, lens] : rig) files.push_back({file_of(camera), camera_text(*lens, camera)});
  if (rig.size() > 1) files.push_back({"extrinsics.yaml", places_text(rig)});
  return files;
}

RigCamera camera_from(const ForeignFormat& format, const NamedText& file) {
  const YamlNode root = YamlNode::parse(file);
  const YamlNode model = root.at("model_type");
  const ForeignLens* lens = lens_named(format, model.text(), 0);
  if (lens == nullptr) model.fail("is " + in_quotes(model.text()) + "; known: " + known_lenses(format));
  std::vector<double> values;
  for (const Section& section : sections_of(lens->name)) {
    const YamlNode node = root.at(section.name);
    for (const char* key : section.keys) values.push_back(node.at(key).number());
  }
  const ImageSize size = image_size_from(root.at("image_width"), root.at("image_height"));
  const auto [camera, fault] = camera_from_values(*lens, size, values);
  if (!fault.empty()) root.at("projection_parameters").fail(fault);
  const auto name = root.find("camera_name");
  return {name ? name->text() : stem_of(file.name), camera, Rigid3{}};
}

bool is_places(const NamedText& file) { return file.text.find("body_T_cam") != std::string::npos; }

// The cameras in the order of their places, which name the file of each.
std::vector<RigCamera> placed(const NamedText& places, std::span<const NamedText> files, const ForeignFormat& format) {
  const YamlNode root = YamlNode::parse(places);
  std::vector<RigCamera> rig;
  for (std::size_t i = 0; root.find(fmt::format("body_T_cam{}", i)); ++i) {
    const YamlNode node = root.at(fmt::format("body_T_cam{}", i)), calib = root.at(fmt::format("cam{}_calib", i));
    const auto file = std::ranges::find_if(files, [&](const NamedText& other) {
      return &other != &places && stem_of(other.name) == stem_of(calib.text());
    });
    if (file == files.end()) calib.fail("names a file that was not given; name it too");
    const std::vector<double> data = node.at("data").numbers(16);
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(data.data());
    rig.push_back(camera_from(format, *file));
    rig.back().camera_from_rig = rigid3_from(node, matrix).inverse();
  }
  if (rig.empty()) root.at("body_T_cam0");
  return rig;
}

std::vector<RigCamera> read(const ForeignFormat& format, std::span<const NamedText> files) {
  const auto places = std::ranges::find_if(files, is_places);
  if (places != files.end()) return placed(*places, files, format);
  if (files.size() > 1) {
    throw Error(ErrorKind::kBadInput,
                "does not say where a camera stands; name a file with cam0_calib, body_T_cam0, ... too", files[0].name);
  }
  return {camera_from(format, files[0])};
}

bool recognises(std::string_view text) {
  return text.find("model_type:") != text.npos || text.find("body_T_cam") != text.npos;
}

}  // namespace

ForeignFormat camodocal_format() {
  return {.name = "camodocal",
          .what = "YAML of CamOdoCal and VINS-Fusion",
          .file = "",
          .holds_extrinsics = true,
          .lenses = {foreign_lens("PINHOLE", "brown_conrady", "k1 k2 p1 p2 fx fy cx cy"),
                     foreign_lens("PINHOLE", "pinhole", "0 0 0 0 fx fy cx cy"),
                     foreign_lens("KANNALA_BRANDT", "kannala_brandt", "k1 k2 k3 k4 fx fy cx cy"),
                     foreign_lens("MEI", "unified", "xi k1 k2 p1 p2 fx fy cx cy")},
          .recognises = recognises,
          .write = write,
          .read = read};
}

}  // namespace raybundle
