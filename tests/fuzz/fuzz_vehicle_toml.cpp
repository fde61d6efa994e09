// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "file_of.hpp"
#include "fuzz_reader.hpp"
#include "occupancy_input.hpp"
#include "stereo_cabin.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  fuzz::only_errors(data, size,
                    [](std::string_view text) { apps::read_stereo_cabin(fuzz::file_of("vehicle.toml", text)); });
  return fuzz::only_errors(data, size, [](std::string_view text) {
    const apps::InstalledSensor sensor = apps::read_installed_sensor(fuzz::file_of("vehicle.toml", text));
    fuzz::require(sensor.rays() >= 4, "a grid");
  });
}
