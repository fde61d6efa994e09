// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "foreign_files.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "raybundle/scene/csv.hpp"
#include "report_page.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

struct ReportFlags {
  std::string report;
  std::string output = "report.html";
  std::string images;
};

// A page that cannot be drawn is found out here, where it can be said in which file, and not in a browser.
void require_report(const std::string& text, const std::string& path) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (json.is_discarded()) {
    throw Error(ErrorKind::kBadInput, "this is no JSON, or it was cut off; run raybundle calibrate again", path);
  }
  if (!json.is_object() || !json.contains("format") || json["format"] != "raybundle report") {
    throw Error(ErrorKind::kBadInput, "this is no report of Raybundle; give the report.json of raybundle calibrate",
                path);
  }
  for (const char* key : {"cameras", "views", "poses", "targets", "set_aside", "stages", "provenance", "fates",
                          "observation_columns", "warnings"}) {
    if (!json.contains(key)) {
      throw Error(ErrorKind::kBadInput, fmt::format("the key '{}' is missing; run raybundle calibrate again", key),
                  path);
    }
  }
}

void run(const ReportFlags& flags) {
  require_other_file({flags.report}, flags.output);
  const std::string report = text_of_file(flags.report);
  require_report(report, flags.report);
  write_file_whole(flags.output, report_page(report, flags.images));
  fmt::print("wrote {}\n", flags.output);
}

}  // namespace

void add_report_verb(CLI::App& app) {
  auto flags = std::make_shared<ReportFlags>();
  CLI::App* verb = app.add_subcommand("report", "report.json -> report.html, one file that needs no network");
  verb->add_option("report", flags->report, "report.json")->required()->type_name("REPORT");
  verb->add_option("-o,--output", flags->output, "page to write")->type_name("FILE")->capture_default_str();
  verb->add_option("--images", flags->images,
                   "folder that the report's image paths start from, as seen from the page; default: its own")
      ->type_name("DIR");
  verb->footer("Example:\n  raybundle report out/report.json -o out/report.html");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
