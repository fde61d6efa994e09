// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <sstream>

#include "program.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const char* kFolder = "opencv_stereo_chess";
constexpr double kNoise_px = 0.3;

std::vector<std::string> boards() {
  return {"--target", "chessboard:9x6:25mm", "--camera", "left=" + (real_data(kFolder) / "left*.jpg").string(),
          "--model",  "brown_conrady"};
}

// Towers 30 m to 3 km in front of a camera that looks north from 20 m up, where a calibration sees them. Written as
// towers.csv (east, north, up) and clicks.csv.
void write_survey(const fs::path& place, const fs::path& calibration) {
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  std::normal_distribution<double> noise(0.0, kNoise_px);
  std::string towers = "name,east,north,up,sigma\n", rays;
  for (int i = 0; i < 16; ++i) {
    const double range_m = 30.0 * std::pow(100.0, uniform(0, 1)), x = uniform(-0.5, 0.5), y = uniform(-0.35, 0.35);
    towers += fmt::format("tower{},{},{},{},0\n", i, range_m * x, range_m, 20.0 - range_m * y);
    rays += fmt::format("{},{},1\n", x, y);
  }
  const ProgramRun seen = raybundle_program({"project", calibration.string()}, rays);
  ASSERT_EQ(seen.exit_code, 0) << seen.err;
  std::istringstream pixels(seen.out);
  std::string clicks = "image,u,v,name\n";
  double u = 0.0, v = 0.0;
  char comma = 0;
  for (int i = 0; pixels >> u >> comma >> v; ++i) {
    clicks += fmt::format("skyline.jpg,{},{},tower{}\n", u + noise(random), v + noise(random), i);
  }
  write_text(place / "towers.csv", towers);
  write_text(place / "clicks.csv", clicks);
}

std::vector<std::string> survey_flags(const fs::path& place) {
  return {"--landmarks",      (place / "towers.csv").string(), "--sightings", (place / "clicks.csv").string(),
          "--sighting-sigma", fmt::format("{}", kNoise_px)};
}

TEST(Surveys, ACalibrationIsCheckedAndImprovedByLandmarks) {
  RAYBUNDLE_NEEDS_DATA(kFolder);
  const fs::path alone = fresh_folder() / "alone", together = fresh_folder() / "together";
  const nlohmann::json without = calibrate(alone, boards());
  write_survey(alone, alone / "out" / "calibration.json");

  std::vector<std::string> check{"survey", (alone / "out" / "calibration.json").string(), "--json"};
  for (const std::string& flag : survey_flags(alone)) check.push_back(flag);
  const ProgramRun checked = raybundle_program(check);
  ASSERT_EQ(checked.exit_code, 0) << checked.err;
  const nlohmann::json found = nlohmann::json::parse(checked.out);
  EXPECT_NEAR(found["rms_px"].get<double>(), kNoise_px * std::sqrt(2.0), 0.25 * kNoise_px * std::sqrt(2.0));
  check.insert(check.end(), {"--max-rms", "0.1"});
  EXPECT_EQ(raybundle_program(check).exit_code, 1);

  std::vector<std::string> arguments = boards();
  for (const std::string& flag : survey_flags(alone)) arguments.push_back(flag);
  const nlohmann::json with = calibrate(together, arguments);
  ASSERT_TRUE(with.contains("survey"));
  EXPECT_EQ(with["survey"]["images"].size(), 1u);
  EXPECT_EQ(with["survey"]["images"][0]["landmarks"].size(), 16u);
  EXPECT_LT(with["survey"]["drag_sigmas"].get<double>(), 2.5);  // they agree with the boards, to their sigmas
  const auto sigma = [](const nlohmann::json& report) { return report["cameras"][0]["sigmas"]["cx"].get<double>(); };
  EXPECT_LT(sigma(with), 1.02 * sigma(without));  // the factor of the residuals changes a little
  EXPECT_EQ(with["views"].size(), without["views"].size());
  EXPECT_EQ(with["provenance"]["inputs"].size(), without["provenance"]["inputs"].size() + 2);
}

// The camera of a sighting stands in its column: then nobody has to name it a second time.
TEST(Surveys, SightingsNameTheirCameras) {
  RAYBUNDLE_NEEDS_DATA(kFolder);
  const fs::path place = fresh_folder();
  std::vector<std::string> both = boards();
  both.insert(both.end(), {"--camera", "right=" + (real_data(kFolder) / "right*.jpg").string()});
  calibrate(place, both);
  write_text(place / "stars.csv", "name,azimuth,elevation,sigma\na,0,0,0.01\nb,10,0,0.01\nc,0,10,0.01\n");
  const auto survey = [&](const std::string& header, const std::string& camera, const std::string& other) {
    std::string clicks = header + "\n";
    for (const std::string& name : {camera, other}) {
      for (const char* click : {"342.6,235.2,a", "440,235,b", "342,140,c"})
        clicks += "night.jpg," + (click + name) + "\n";
    }
    write_text(place / "clicks.csv", clicks);
    return raybundle_program({"survey", (place / "out" / "calibration.json").string(), "--landmarks",
                              (place / "stars.csv").string(), "--sightings", (place / "clicks.csv").string(),
                              "--json"});
  };
  const ProgramRun named = survey("image,u,v,name,camera", ",right", ",left");
  ASSERT_EQ(named.exit_code, 0) << named.err;
  const nlohmann::json images = nlohmann::json::parse(named.out)["images"];
  ASSERT_EQ(images.size(), 2u);
  EXPECT_EQ(images[0]["camera"], "left");
  EXPECT_EQ(images[1]["camera"], "right");
  const ProgramRun half_named = survey("image,u,v,name,camera", ",right", ",");
  EXPECT_EQ(half_named.exit_code, 2);
  EXPECT_THAT(half_named.err, HasSubstr("which camera?"));
}

TEST(Surveys, WhatIsWrongIsNamed) {
  RAYBUNDLE_NEEDS_DATA(kFolder);
  const fs::path place = fresh_folder();
  calibrate(place, boards());
  write_survey(place, place / "out" / "calibration.json");
  const auto survey = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"survey", (place / "out" / "calibration.json").string()};
    for (const std::string& flag : survey_flags(place)) arguments.push_back(flag);
    arguments.insert(arguments.end(), more.begin(), more.end());
    return raybundle_program(arguments);
  };
  write_text(place / "towers.csv", "name,lat,lon,height,sigma\ntower0,43.5,1.4,210,0.1\n");
  const ProgramRun nowhere = survey({});
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_THAT(nowhere.err, HasSubstr("--origin"));
  const ProgramRun unstated = survey({"--origin", "43.5,1.4,200"});
  EXPECT_EQ(unstated.exit_code, 2);
  EXPECT_THAT(unstated.err, HasSubstr("--height ellipsoidal"));
  write_text(place / "towers.csv", "name,east,north,up,sigma\ntower0,1,2,3,0\n");
  const ProgramRun unknown = survey({});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("clicks.csv:3"));
  const ProgramRun half = raybundle_program({"calibrate", "--landmarks", (place / "towers.csv").string()});
  EXPECT_EQ(half.exit_code, 2);
  EXPECT_THAT(half.err, HasSubstr("--sightings"));
}

}  // namespace
}  // namespace raybundle::testing
