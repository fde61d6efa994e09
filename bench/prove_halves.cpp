// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Odd against even frames of real image sets, by the program: the difference map of projections at infinity has to stay
// within twice the summed sigmas over 90 % of the image that both halves covered, or the verdict has to name what is at
// fault: "model error" with the model that mends it, or the ties of cameras that agree when they are calibrated alone.
// usage: prove_halves [folder of real data]
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "kalibr_corners.hpp"
#include "real_data.hpp"

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Set {
  const char* name;
  const char* folder;  // of the images or corners
  std::string flags;   // @ stands for the folder
};

std::string quoted(const std::string& text) { return "'" + text + "'"; }

// Corners that others detected, as a table of ours.
fs::path table_of_kalibr_corners(const fs::path& folder, const fs::path& scratch) {
  fs::path file = scratch / "corners.csv";
  std::ofstream table(file);
  table << "camera,frame,point_id,u,v\n";
  for (const std::string camera : {"cam0", "cam1"}) {
    table << raybundle::testing::csv_of_kalibr_corners(folder / camera, camera);
  }
  return file;
}

// report.json of a run of the program; null when it fails.
json report_of(const std::string& flags, const fs::path& scratch) {
  const std::string command = quoted(RAYBUNDLE_PROGRAM) + " calibrate " + flags + " --cross-validate -o " +
                              quoted((scratch / "out").string()) + " >/dev/null 2>&1";
  if (std::system(command.c_str()) != 0) {
    std::printf("  `%s` failed\n", command.c_str());
    return {};
  }
  std::ifstream file(scratch / "out" / "report.json");
  return json::parse(file);
}

void print_shares(const json& found, const char* sigmas) {
  if (!found.contains(sigmas)) return;
  for (const json& projection : found.at(sigmas).at("projections")) {
    std::printf("  %-6s sigmas %-11s within over %5.1f %% of the covered image, %.3f px apart rms, %.3f px at most\n",
                projection.at("camera").get<std::string>().c_str(), sigmas,
                100.0 * projection.at("share_within").get<double>(), projection.at("rms_px").get<double>(),
                projection.at("largest_px").get<double>());
  }
}

bool prove(const Set& set, const fs::path& data, const fs::path& scratch) {
  std::printf("%s\n", set.name);
  const fs::path folder = data / set.folder;
  if (!fs::is_directory(folder)) {
    std::printf("  %s is not there: MISSED\n", folder.c_str());
    return false;
  }
  std::string flags = set.flags;
  const std::string place =
      std::string(set.name) == "euroc_april" ? table_of_kalibr_corners(folder, scratch).string() : folder.string();
  for (std::size_t at = flags.find('@'); at != std::string::npos; at = flags.find('@', at + place.size())) {
    flags.replace(at, 1, place);
  }
  const json report = report_of(flags, scratch);
  if (report.is_null()) return false;
  const json& found = report.at("cross_validation");
  print_shares(found, "by_corners");
  print_shares(found, "by_frames");
  const std::string verdict = found.at("verdict"), words = found.at("words");
  std::printf("  %s\n", words.c_str());
  const bool agree = verdict == "agree" || verdict == "agree_by_frames";
  const bool mended = verdict == "model_error" && words.find(" mends camera") != std::string::npos &&
                      words.find("no model of the list") == std::string::npos;
  const bool holds = agree || mended || verdict == "ties_disagree";
  std::printf("  %s: %s\n", verdict.c_str(), holds ? "holds" : "MISSED");
  return holds;
}

}  // namespace

int main(int argc, char** argv) {
  const fs::path data = argc > 1 ? fs::path(argv[1]) : raybundle::testing::real_data();
  const fs::path scratch = fs::temp_directory_path() / "raybundle_prove_halves";
  fs::create_directories(scratch);
  const Set sets[] = {
      {"camodocal", "camodocal_fisheye/images",
       "--target chessboard:9x6:120mm --camera front='@/*.png' --model kannala_brandt"},
      {"sourishg", "sourishg_fisheye_stereo/imgs",
       "--target chessboard:9x6:24.23mm --camera left='@/left*.jpg' --camera right='@/right*.jpg' --model "
       "kannala_brandt"},
      {"euroc_april", "euroc_april/cam_april",
       "--observations '@' --image-size cam0=752x480 --image-size cam1=752x480 --target aprilgrid:6x6:88mm:0.3 --model "
       "brown_conrady"}};
  bool holds = true;
  for (const Set& set : sets) holds = prove(set, data, scratch) && holds;
  fs::remove_all(scratch);
  return holds ? 0 : 1;
}
