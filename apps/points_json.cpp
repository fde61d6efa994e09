// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "points_json.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"

namespace raybundle::apps {
namespace {

using nlohmann::json;

bool is_of(const json& file, const PointsFormat& format) {
  return file.is_object() && file.contains("format") && file["format"] == format.name;
}

}  // namespace

void read_points_json(const std::string& path, const PointsFormat& format,
                      const std::function<void(const json&)>& use) {
  const json file = json::parse(text_of_file(path), nullptr, false);
  const std::string again = fmt::format("`raybundle reconstruct {}`", format.sensor);
  if (file.is_discarded()) {
    throw Error(ErrorKind::kBadInput, "is not JSON, or not all of it; make it again with " + again, path);
  }
  for (const PointsFormat& other : {kLaserPoints, kStereoPoints}) {
    if (other.name == format.name || !is_of(file, other)) continue;
    throw Error(ErrorKind::kBadInput,
                fmt::format("holds points of {0}, but the base was learnt for {1}: learn one with --sensor {0}",
                            other.sensor, format.sensor),
                path);
  }
  if (!is_of(file, format) || !file.contains("version") || file["version"] != 1) {
    throw Error(ErrorKind::kBadInput, "is not what " + again + " of this version writes; make it again", path);
  }
  try {
    use(file);
  } catch (const json::exception&) {
    throw Error(ErrorKind::kBadInput, "lacks something that " + again + " writes, or holds it otherwise; make it again",
                path);
  }
}

}  // namespace raybundle::apps
