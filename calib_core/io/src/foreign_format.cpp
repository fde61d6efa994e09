// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/foreign_format.hpp"

#include <algorithm>
#include <set>

#include "formats/format_list.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"

namespace raybundle {

std::span<const ForeignFormat> foreign_formats() {
  static const std::vector<ForeignFormat> kFormats{opencv_format(), ros_format(),    kalibr_format(),   mrcal_format(),
                                                   colmap_format(), basalt_format(), camodocal_format()};
  return kFormats;
}

const ForeignFormat* foreign_format_named(std::string_view name) {
  const auto found = std::ranges::find(foreign_formats(), name, &ForeignFormat::name);
  return found == foreign_formats().end() ? nullptr : &*found;
}

std::vector<NamedText> texts_from_rig(const ForeignFormat& format, const std::vector<RigCamera>& rig) {
  for (const RigCamera& camera : rig) {
    if (lens_for(format, camera.camera) == nullptr) {
      throw Error(ErrorKind::kBadInput,
                  std::string(format.name) + " has no lens like this " + std::string(model_name(camera.camera.model)) +
                      " one; convert it first",
                  camera.name);
    }
    if (format.file.empty() && camera.name.find('/') != std::string::npos) {
      throw Error(ErrorKind::kBadInput, "the name cannot be that of a file; rename the camera", camera.name);
    }
  }
  return format.write(format, rig);
}

std::vector<RigCamera> rig_from_texts(const ForeignFormat& format, std::span<const NamedText> files) {
  if (files.empty()) throw Error(ErrorKind::kBadInput, "there is no file to read");
  std::vector<RigCamera> rig = format.read(format, files);
  std::set<std::string> names;
  const Rigid3 reference_from_first = rig.at(0).camera_from_rig.inverse();
  for (RigCamera& camera : rig) {
    if (!names.insert(camera.name).second) {
      throw Error(ErrorKind::kBadInput, "two cameras are called " + in_quotes(camera.name) + "; rename one",
                  files[0].name);
    }
    camera.camera_from_rig = camera.camera_from_rig * reference_from_first;
  }
  rig[0].camera_from_rig = {};
  return rig;
}

}  // namespace raybundle
