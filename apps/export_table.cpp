// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "export.hpp"
#include "foreign_files.hpp"
#include "output_folder.hpp"
#include "page_text.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/hash.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "sensor_input.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

struct TableFlags {
  std::string runtime;
  SensorFlags sensor;
};

// Of those that were measured, or of those that are foreseen only.
std::ptrdiff_t beams_of(const SensorTable& table, bool measured) {
  return std::ranges::count(table.beams, measured, &TableBeam::measured);
}

std::string summary(const SensorTable& table, const ExportRequest& request, std::size_t bytes) {
  std::string text =
      fmt::format("{}: {}, {}x{}, {} beams of {}x{}", request.output, table.camera, table.rays.size.width,
                  table.rays.size.height, beams_of(table, true), table.grid.columns, table.grid.rows);
  if (const auto foreseen = beams_of(table, false); foreseen > 0) text += fmt::format(" and {} foreseen", foreseen);
  return text + fmt::format(
                    ", from {} to {} m, within {:.2f} px\nrays every {} px, within {:.2f} µrad of the lens model; "
                    "serial {}; {} self-tests pass\nwrote {}, {} kB\nnext  raybundle reconstruct structured-light {} "
                    "IMAGE -o points\n",
                    table.range.nearest_m, table.range.farthest_m, table.range.tolerance_px, table.rays.step_px,
                    1e6 * table.rays.error_rad, table.serial, table.self_tests.size(), request.output,
                    (bytes + 500) / 1000, shell_word(request.output));
}

void print_json(const SensorTable& table, const ExportRequest& request, const std::string& bytes) {
  const nlohmann::ordered_json result{{"file", request.output},
                                      {"serial", table.serial},
                                      {"sha256", sha256_of_bytes(bytes)},
                                      {"camera", table.camera},
                                      {"beams", beams_of(table, true)},
                                      {"foreseen_beams", beams_of(table, false)},
                                      {"nearest_m", table.range.nearest_m},
                                      {"farthest_m", table.range.farthest_m},
                                      {"tolerance_px", table.range.tolerance_px},
                                      {"ray_step_px", table.rays.step_px},
                                      {"ray_error_rad", table.rays.error_rad},
                                      {"self_tests", table.self_tests.size()},
                                      {"bytes", bytes.size()}};
  fmt::print("{}\n", text_of_json(result, 2));
}

bool run(const TableFlags& flags, const ExportRequest& request) {
  if (flags.runtime.empty()) return false;
  if (request.output.empty()) throw Error(ErrorKind::kBadInput, "where to? Give -o FILE, as in -o sensor.rbsl");
  require_writable_file(request.output, "--output");
  require_other_file({request.calibration}, request.output);
  SensorFlags sensor = flags.sensor;
  sensor.camera = request.camera;
  const SensorTable made = table_from_calibration(request.calibration, sensor);
  const std::string bytes = bytes_from_table(made);
  const SensorTable table = table_from_bytes(bytes, request.output);  // what a device will do, self-test and all
  write_file_whole(request.output, bytes);
  request.json ? print_json(table, request, bytes) : fmt::print("{}", summary(table, request, bytes.size()));
  return true;
}

}  // namespace

Export add_table_export(CLI::App& verb) {
  auto flags = std::make_shared<TableFlags>();
  CLI::Option* runtime =
      verb.add_option("--runtime", flags->runtime, "table for a device")->check(CLI::IsMember({"structured-light"}));
  runtime->excludes(verb.get_option("--to"));
  declare_sensor_flags(verb, flags->sensor);
  for (CLI::Option* option : flags->sensor.options) option->needs(runtime);
  return [flags](const ExportRequest& request) { return run(*flags, request); };
}

}  // namespace raybundle::apps
