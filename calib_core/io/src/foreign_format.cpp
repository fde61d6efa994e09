// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/foreign_format.hpp"

#include <algorithm>
#include <functional>
#include <set>

#include "formats/foreign_lens.hpp"
#include "formats/format_list.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"

namespace raybundle {
namespace {

// Makes the first camera's frame that of the rig. `camera_of` is where an entry has its RigCamera.
template <typename Entry, typename CameraOf>
void measure_from_first(std::vector<Entry>& rig, CameraOf camera_of) {
  if (rig.empty()) return;
  const Rigid3 reference_from_first = std::invoke(camera_of, rig[0]).camera_from_rig.inverse();
  for (Entry& entry : rig) {
    RigCamera& camera = std::invoke(camera_of, entry);
    camera.camera_from_rig = camera.camera_from_rig * reference_from_first;
  }
  std::invoke(camera_of, rig[0]).camera_from_rig = {};
}

}  // namespace

std::span<const ForeignFormat> foreign_formats() {
  static const std::vector<ForeignFormat> kFormats{opencv_format(), ros_format(),    kalibr_format(),   mrcal_format(),
                                                   colmap_format(), basalt_format(), camodocal_format()};
  return kFormats;
}

const ForeignFormat* foreign_format_named(std::string_view name) {
  const auto found = std::ranges::find(foreign_formats(), name, &ForeignFormat::name);
  return found == foreign_formats().end() ? nullptr : &*found;
}

std::vector<NamedText> texts_from_rig(const ForeignFormat& format, std::vector<ForeignCamera> rig) {
  for (ForeignCamera& camera : rig) {
    if (camera.lens == nullptr) camera.lens = lens_for(format, camera.camera.camera);
    if (camera.lens == nullptr || !holds(format, *camera.lens, camera.camera.camera)) {
      throw Error(ErrorKind::kBadInput,
                  std::string(format.name) + " has no lens like this " +
                      std::string(model_name(camera.camera.camera.model)) + " one; convert it first",
                  camera.camera.name);
    }
  }
  measure_from_first(rig, &ForeignCamera::camera);
  std::vector<NamedText> files = format.write(format, rig);
  std::set<std::string> names;
  for (const NamedText& file : files) {
    if (names.insert(file.name).second) continue;
    throw Error(ErrorKind::kBadInput, "two files would be called " + in_quotes(file.name) + "; rename a camera");
  }
  return files;
}

std::vector<RigCamera> rig_from_texts(const ForeignFormat& format, std::span<const NamedText> files) {
  if (files.empty()) throw Error(ErrorKind::kBadInput, "there is no file to read");
  std::vector<RigCamera> rig = format.read(format, files);
  if (rig.empty()) throw Error(ErrorKind::kBadInput, "has no camera", files[0].name);
  std::set<std::string> names;
  for (const RigCamera& camera : rig) names.insert(camera.name);
  for (std::size_t i = 0; i < rig.size(); ++i) {
    if (names.size() < rig.size() || names.contains("")) rig[i].name = numbered_camera(i);
  }
  measure_from_first(rig, std::identity{});
  return rig;
}

}  // namespace raybundle
