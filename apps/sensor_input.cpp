// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "sensor_input.hpp"

#include <fmt/format.h>

#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/io/hash.hpp"
#include "raybundle/scene/csv.hpp"

namespace raybundle::apps {

void declare_sensor_flags(CLI::App& verb, SensorFlags& flags) {
  flags.options = {
      verb.add_option("--nearest", flags.nearest_m, "least depth of a dot [m]")
          ->check(CLI::Range(0.01, 1000.0))
          ->capture_default_str(),
      verb.add_option("--farthest", flags.farthest_m, "greatest depth of a dot [m]")
          ->check(CLI::Range(0.01, 1000.0))
          ->capture_default_str(),
      verb.add_option("--tolerance", flags.tolerance_px,
                      "of a dot from its beam's curve [px]; what the calibration advises unless said, else 1")
          ->check(CLI::Range(0.05, 20.0))};
}

SensorTable table_from_calibration(const std::string& path, const SensorFlags& flags) {
  const CalibrationFile file = read_calibration(path);
  const auto& laser = file.calibration.laser;
  SensorRange range{flags.nearest_m, flags.farthest_m, SensorRange{}.tolerance_px};
  if (laser && laser->advice) range.tolerance_px = laser->advice->ambiguity.tolerance_px;
  if (flags.tolerance_px) range.tolerance_px = *flags.tolerance_px;
  const std::string origin = fmt::format("{} of SHA-256 {}", path, sha256_of_file(path));
  return sensor_table(file.calibration, flags.camera, range, origin);
}

SensorTable sensor_of(const std::string& path, const SensorFlags& flags) {
  if (!is_table(text_of_file(path))) return table_from_calibration(path, flags);
  for (const CLI::Option* option : flags.options) {
    if (option->count() == 0) continue;
    throw Error(ErrorKind::kBadInput,
                fmt::format("the table holds its range and tolerance itself; leave out {}, or export the table with it",
                            option->get_name()),
                path);
  }
  return read_table(path);
}

}  // namespace raybundle::apps
