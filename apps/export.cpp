// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "export.hpp"

#include <memory>
#include <vector>

#include "raybundle/geometry/error.hpp"
#include "verbs.hpp"

namespace raybundle::apps {

void add_export_verb(CLI::App& app) {
  auto request = std::make_shared<ExportRequest>();
  auto exports = std::make_shared<std::vector<Export>>();
  CLI::App* verb = app.add_subcommand("export", "calibration -> what a device or another program reads");
  verb->add_option("calibration", request->calibration, "calibration.json")->required()->type_name("CALIBRATION");
  verb->add_option("-o,--output", request->output, "file or folder to write")->type_name("PATH");
  verb->add_option("--camera", request->camera,
                   "which camera; the first one of a table, all of another program's files")
      ->type_name("NAME");
  verb->add_flag("--json", request->json, "print the result as JSON");
  for (auto add : kExports) exports->push_back(add(*verb));
  verb->footer(
      "Examples:\n"
      "  raybundle export out/calibration.json --to kalibr -o camchain.yaml\n"
      "  raybundle export out/calibration.json --to opencv -o opencv\n"
      "  raybundle export out/calibration.json --runtime structured-light -o sensor.rbsl\n\n"
      "  sensor.rbsl: camera, 640x480, 120 beams of 11x11 and 1 foreseen, from 0.15 to 1.5 m, within 0.40 px\n"
      "  rays every 8 px, within 0.23 µrad of the lens model; serial 5f0c1d6e0a3b9c47; 119 self-tests pass\n"
      "  wrote sensor.rbsl, 160 kB\n"
      "  next  raybundle reconstruct structured-light sensor.rbsl IMAGE -o points");
  verb->callback([request, exports] {
    bool any = false;
    for (const Export& does : *exports) any |= does(*request);
    if (!any)
      throw Error(
          ErrorKind::kBadInput,
          "what is to be exported? Say --to FORMAT -o PATH, --runtime structured-light -o FILE, or --rectification DIR");
  });
}

}  // namespace raybundle::apps
