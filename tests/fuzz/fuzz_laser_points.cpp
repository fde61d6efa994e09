// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "file_of.hpp"
#include "fuzz_reader.hpp"
#include "occupancy_input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  return fuzz::only_errors(data, size, [](std::string_view text) {
    apps::InstalledSensor sensor;
    sensor.rows = sensor.columns = 11;
    const apps::PointFrame frame = apps::read_point_frame(fuzz::file_of("points.json", text), sensor);
    for (const ScenePoint& point : frame.points) fuzz::require(point.ray >= 0 && point.ray < 121, "a ray of the grid");
  });
}
