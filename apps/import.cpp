// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "foreign_files.hpp"
#include "output_folder.hpp"
#include "page_text.hpp"
#include "raybundle/camera/injectivity.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/io/hash.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

struct ImportFlags {
  std::vector<std::string> files, names;
  std::string from, output;
  bool json = false;
};

// Their own names, or those that are given.
void rename(std::vector<RigCamera>& rig, const std::vector<std::string>& names) {
  if (names.empty()) return;
  if (names.size() != rig.size()) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("there are {} names for {} cameras; give one for each", names.size(), rig.size()),
                "--names");
  }
  for (std::size_t i = 0; i < rig.size(); ++i) rig[i].name = names[i];
}

CalibrationFile calibration_from(const ImportFlags& flags, const ForeignFiles& read) {
  CalibrationFile file;
  file.calibration.cameras = rig_from_texts(*read.format, read.files);
  rename(file.calibration.cameras, flags.names);
  file.provenance.command = "raybundle import";
  for (const NamedText& text : read.files) file.provenance.inputs.push_back({text.name, sha256_of_bytes(text.text)});
  file.provenance.options = {{"from", std::string(read.format->name)}};
  file.provenance.versions = {{"raybundle", RAYBUNDLE_VERSION}};
  return file;
}

std::string table_of(const Calibration& calibration) {
  std::vector<std::vector<std::string>> rows{{"camera", "lens", "image", "focal [px]", "place [m]"}};
  for (const RigCamera& camera : calibration.cameras) {
    // No -0 for the first camera.
    const Eigen::Vector3d place = camera.camera_from_rig.inverse().translation.array() + 0.0;
    rows.push_back({camera.name, std::string(model_name(camera.camera.model)),
                    fmt::format("{}x{}", camera.camera.size.width, camera.camera.size.height),
                    fmt::format("{:.2f}", focal_on_axis_px(camera.camera)),
                    fmt::format("{:.4f} {:.4f} {:.4f}", place.x(), place.y(), place.z())});
  }
  return text_table(rows);
}

void run(const ImportFlags& flags) {
  require_writable_file(flags.output, "--output");
  const ForeignFiles read = read_foreign_files(flags.files, flags.from);
  for (const NamedText& file : read.files) require_other_file({file.name}, flags.output);
  const CalibrationFile file = calibration_from(flags, read);
  for (const RigCamera& camera : file.calibration.cameras) {
    const InjectivityReport report = check_injectivity(camera.camera);
    if (report.one_to_one()) continue;
    say_warning(fmt::format("{}: {:.1f} % of the image have no ray, from pixel ({:.0f}, {:.0f}) outwards", camera.name,
                            100.0 * (1.0 - report.covered_fraction), report.first_offender->x(),
                            report.first_offender->y()));
  }
  write_calibration(flags.output, file);
  if (flags.json) {
    nlohmann::ordered_json json{{"file", flags.output}, {"from", read.format->name}};
    for (const RigCamera& camera : file.calibration.cameras) {
      json["cameras"].push_back({{"name", camera.name}, {"model", model_name(camera.camera.model)}});
    }
    fmt::print("{}\n", text_of_json(json, 2));
    return;
  }
  fmt::print(
      "{}wrote {} from {}: without sigmas, boards or residuals, which those files do not have\n"
      "next  raybundle validate {} --max-rms 0.5 --target BOARD",
      table_of(file.calibration), flags.output, read.format->what, shell_word(flags.output));
  for (const RigCamera& camera : file.calibration.cameras) fmt::print(" --camera {}='IMAGES'", shell_word(camera.name));
  fmt::print("\n");
}

}  // namespace

void add_import_verb(CLI::App& app) {
  auto flags = std::make_shared<ImportFlags>();
  CLI::App* verb = app.add_subcommand("import", "another program's calibration -> calibration.json");
  verb->add_option("files", flags->files, "its files, or the folder with them; the first camera defines the rig")
      ->required()
      ->type_name("FILE");
  verb->add_option("--from", flags->from, "format, unless the files tell: " + formats_help())
      ->type_name("FORMAT")
      ->check(CLI::IsMember(format_names()));
  verb->add_option("--names", flags->names, "of the cameras, in their order, where the files have others")
      ->type_name("NAME");
  verb->add_option("-o,--output", flags->output, "calibration.json to write")->required()->type_name("FILE");
  verb->add_flag("--json", flags->json, "print the result as JSON");
  verb->footer(
      "Example:\n"
      "  raybundle import camchain.yaml -o kalibr.json\n"
      "  raybundle compare out/calibration.json kalibr.json");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
