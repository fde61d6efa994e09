// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// mrcal's .cameramodel for each camera: a Python dictionary, which YAML's flow style reads as well. Source:
// mrcal/cameramodel.py; extrinsics are a rotation vector and a translation, camera from reference.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "foreign_lens.hpp"
#include "format_list.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/rotation.hpp"
#include "raybundle/scene/csv.hpp"
#include "yaml_node.hpp"

namespace raybundle {
namespace {

constexpr const char* kEnding = ".cameramodel";

std::vector<NamedText> write(const ForeignFormat&, const std::vector<ForeignCamera>& rig) {
  std::vector<NamedText> files;
  for (const auto& [camera, lens] : rig) {
    const Eigen::Vector3d r = vector_from_rotation(camera.camera_from_rig.rotation.toRotationMatrix());
    const Eigen::Vector3d& t = camera.camera_from_rig.translation;
    files.push_back({file_stem(camera.name) + kEnding,
                     fmt::format("{{\n    'lensmodel': '{}',\n    'intrinsics': {},\n    'extrinsics': {},\n"
                                 "    'imagersize': [{}, {}],\n}}\n",
                                 lens->name, list_text(values_of(*lens, camera.camera)),
                                 list_text({r.x(), r.y(), r.z(), t.x(), t.y(), t.z()}), camera.camera.size.width,
                                 camera.camera.size.height)});
  }
  return files;
}

// Without values like b'...': the whole solve, in base 85, which no camera needs and which is no YAML.
std::string without_bytes(const std::string& text) {
  std::string rest;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t found = text.find(" b'", begin);
    if (found == text.npos) return rest += text.substr(begin);
    rest += text.substr(begin, found - begin) + " ''";
    const std::size_t end = text.find('\'', found + 3);
    begin = end == text.npos ? text.size() : end + 1;
  }
  return rest;
}

RigCamera camera_from(const ForeignFormat& format, const NamedText& file) {
  const YamlNode root = YamlNode::parse({file.name, without_bytes(file.text)});
  const YamlNode model = root.at("lensmodel");
  const YamlNode intrinsics = root.at("intrinsics");
  const std::vector<double> values = intrinsics.numbers();
  const ForeignLens* lens = lens_named(format, model.text(), values.size());
  if (lens == nullptr) model.fail("is " + in_quotes(model.text()) + "; known: " + known_lenses(format));
  const auto [camera, fault] = camera_from_values(*lens, image_size_from(root.at("imagersize")), values);
  if (!fault.empty()) intrinsics.fail("of " + model.text() + " " + fault);
  const auto place = root.find_first({"rt_cam_ref", "extrinsics"});
  const std::vector<double> rt = (place ? *place : root.at("extrinsics")).numbers(6);
  return {stem_of(file.name),
          camera,
          {Eigen::Quaterniond(rotation_from_vector({rt[0], rt[1], rt[2]})), {rt[3], rt[4], rt[5]}}};
}

std::vector<RigCamera> read(const ForeignFormat& format, std::span<const NamedText> files) {
  std::vector<RigCamera> rig;
  for (const NamedText& file : files) rig.push_back(camera_from(format, file));
  return rig;
}

bool recognises(std::string_view text) { return text.find("LENSMODEL_") != text.npos; }

}  // namespace

ForeignFormat mrcal_format() {
  return {
      .name = "mrcal",
      .what = ".cameramodel of mrcal",
      .file = "",
      .holds_extrinsics = true,
      .lenses = {foreign_lens("LENSMODEL_PINHOLE", "pinhole", "fx fy cx cy"),
                 foreign_lens("LENSMODEL_OPENCV5", "brown_conrady", "fx fy cx cy k1 k2 p1 p2 k3"),
                 foreign_lens("LENSMODEL_OPENCV4", "brown_conrady", "fx fy cx cy k1 k2 p1 p2"),
                 foreign_lens("LENSMODEL_OPENCV8", "rational", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"),
                 foreign_lens("LENSMODEL_OPENCV12", "thin_prism", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4")},
      .recognises = recognises,
      .write = write,
      .read = read};
}

}  // namespace raybundle
