// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/calibration_file.hpp"

#include <bit>
#include <filesystem>
#include <limits>

#include "fresh_folder.hpp"
#include "io_examples.hpp"

namespace raybundle::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// Same bits: stricter than ==, which takes -0 for 0.
bool same_bits(const auto& a, const auto& b) {
  if (a.size() != b.size()) return false;
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    if (std::bit_cast<std::uint64_t>(a.data()[i]) != std::bit_cast<std::uint64_t>(b.data()[i])) return false;
  }
  return true;
}

std::string read_message(const std::string& text) {
  return message_of([&] { calibration_from_text(text, "c.json"); });
}

TEST(CalibrationFile, SaveAndLoadIsTheIdentityForEveryExampleOfEveryModel) {
  const CalibrationFile saved = full_calibration();
  const CalibrationFile loaded = calibration_from_text(text_from_calibration(saved), "c.json");
  ASSERT_EQ(loaded.calibration.cameras.size(), saved.calibration.cameras.size());
  for (std::size_t i = 0; i < saved.calibration.cameras.size(); ++i) {
    const RigCamera& a = saved.calibration.cameras[i];
    const RigCamera& b = loaded.calibration.cameras[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.camera.model, b.camera.model) << a.name;
    EXPECT_EQ(a.camera.size, b.camera.size) << a.name;
    EXPECT_TRUE(same_bits(a.camera.parameters, b.camera.parameters)) << a.name;
    EXPECT_TRUE(same_bits(a.camera_from_rig.rotation.coeffs(), b.camera_from_rig.rotation.coeffs())) << a.name;
    EXPECT_TRUE(same_bits(a.camera_from_rig.translation, b.camera_from_rig.translation)) << a.name;
    EXPECT_EQ(saved.summaries[i].rms_px, loaded.summaries[i].rms_px);
    EXPECT_EQ(saved.summaries[i].corners_outlier, loaded.summaries[i].corners_outlier);
  }
  EXPECT_EQ(saved.calibration.covariance.names, loaded.calibration.covariance.names);
  EXPECT_TRUE(same_bits(saved.calibration.covariance.matrix, loaded.calibration.covariance.matrix));
  EXPECT_EQ(saved.rms_px, loaded.rms_px);
  EXPECT_EQ(saved.variance_factor, loaded.variance_factor);
  // What has been compared above and everything else that the text holds: targets, shape, symmetries, provenance.
  EXPECT_EQ(text_from_calibration(saved), text_from_calibration(loaded));
}

TEST(CalibrationFile, BeamsKeepTheirBits) {
  const LaserPattern saved = small_pattern();
  const LaserPattern loaded =
      *calibration_from_text(text_from_calibration(full_calibration()), "c.json").calibration.laser;
  EXPECT_EQ(std::tie(saved.grid.rows, saved.grid.columns), std::tie(loaded.grid.rows, loaded.grid.columns));
  ASSERT_EQ(saved.beams.size(), loaded.beams.size());
  for (std::size_t i = 0; i < saved.beams.size(); ++i) {
    const LaserBeam &a = saved.beams[i], &b = loaded.beams[i];
    EXPECT_EQ(std::tie(a.row, a.column, a.hits, a.nearest_hit_m, a.farthest_hit_m),
              std::tie(b.row, b.column, b.hits, b.nearest_hit_m, b.farthest_hit_m));
    EXPECT_TRUE(same_bits(a.line.point, b.line.point));
    EXPECT_TRUE(same_bits(a.line.direction, b.line.direction));
    EXPECT_TRUE(same_bits(a.covariance, b.covariance));
  }
  EXPECT_EQ(saved.zero_order_row, loaded.zero_order_row);
  EXPECT_EQ(saved.grating->wavelength_scale, loaded.grating->wavelength_scale);
  EXPECT_TRUE(same_bits(saved.grating->rig_from_projector.translation, loaded.grating->rig_from_projector.translation));
  CalibrationFile without = full_calibration();
  without.calibration.laser.reset();
  EXPECT_FALSE(calibration_from_text(text_from_calibration(without), "c.json").calibration.laser);
}

TEST(CalibrationFile, RandomNumbersKeepTheirBits) {
  std::mt19937_64 random(3);
  CalibrationFile file;
  RigCamera camera{"left", start_camera(*model_named("kannala_brandt"), {640, 480}, 300), {}};
  file.calibration.cameras = {camera};
  file.calibration.covariance.names = std::vector<std::string>(40, "p");
  Eigen::MatrixXd matrix(40, 40);
  for (double& value : matrix.reshaped()) {
    do value = std::bit_cast<double>(random());
    while (!std::isfinite(value));
  }
  file.calibration.covariance.matrix = matrix.triangularView<Eigen::Lower>();
  file.calibration.covariance.matrix.triangularView<Eigen::StrictlyUpper>() = matrix.transpose();
  file.calibration.covariance.matrix.diagonal() = matrix.diagonal().cwiseAbs();
  const CalibrationFile loaded = calibration_from_text(text_from_calibration(file), "c.json");
  EXPECT_TRUE(same_bits(file.calibration.covariance.matrix, loaded.calibration.covariance.matrix));
}

TEST(CalibrationFile, HoldsTheNamesThatOthersScriptAgainst) {
  const std::string text = text_from_calibration(full_calibration());
  for (const char* name : {"\"cameras\"", "\"name\"", "\"model\"", "\"width\"", "\"height\"", "\"parameters\"",
                           "\"fx\"", "\"camera_from_rig\"", "\"rotation_xyzw\"", "\"translation_m\"", "\"sigmas\""}) {
    EXPECT_THAT(text, HasSubstr(name));
  }
}

TEST(CalibrationFile, WritesWholeFilesOnly) {
  const auto path = fresh_folder() / "calibration.json";
  write_calibration(path, full_calibration());
  CalibrationFile broken = full_calibration();
  broken.calibration.cameras[0].camera.parameters[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message_of([&] { write_calibration(path, broken); }), HasSubstr("not finite; nothing was written"));
  broken = full_calibration();
  broken.rms_px = std::numeric_limits<double>::infinity();
  EXPECT_THAT(message_of([&] { write_calibration(path, broken); }),
              HasSubstr("'residuals' holds a number that is not"));
  EXPECT_EQ(text_from_calibration(read_calibration(path)), text_from_calibration(full_calibration()));
  std::filesystem::remove(path);
  EXPECT_THAT(message_of([&] { read_calibration(path); }, ErrorKind::kIo), HasSubstr("there is no such file"));
}

TEST(CalibrationFile, RefusesToWriteWhatCannotBeReadBack) {
  CalibrationFile file = full_calibration();
  file.calibration.covariance.names.pop_back();
  EXPECT_THAT(message_of([&] { text_from_calibration(file); }), HasSubstr("names differ in size"));
  file = full_calibration();
  file.summaries.pop_back();
  EXPECT_THAT(message_of([&] { text_from_calibration(file); }), HasSubstr("residual summaries for"));
  EXPECT_THAT(message_of([&] { text_from_calibration({}); }), HasSubstr("there is no camera"));
  file = full_calibration();
  file.calibration.cameras.push_back(file.calibration.cameras.front());
  file.summaries.clear();
  EXPECT_THAT(message_of([&] { text_from_calibration(file); }), HasSubstr("two cameras are called"));
  file.calibration.cameras.back().name.clear();
  EXPECT_THAT(message_of([&] { text_from_calibration(file); }), HasSubstr("no name"));
}

TEST(CalibrationFile, WritesNoBeamThatTheReaderRefuses) {
  using Change = void (*)(std::vector<LaserBeam>&);
  const std::pair<Change, const char*> changes[] = {
      {[](std::vector<LaserBeam>& beams) { beams[0].row = 2; }, "beams[0].row is 2"},
      {[](std::vector<LaserBeam>& beams) { std::swap(beams[0], beams[1]); }, "beams[1] stands after a beam of"},
      {[](std::vector<LaserBeam>& beams) { beams[1] = beams[0]; }, "beams[1] stands after a beam of the same"},
      {[](std::vector<LaserBeam>& beams) { beams[0].line.direction *= 1.01; }, "direction is no unit vector"},
      {[](std::vector<LaserBeam>& beams) { beams[0].covariance(0, 2) *= 1.0 + 1e-15; }, "is not symmetric"},
      {[](std::vector<LaserBeam>& beams) { beams[0].covariance(0, 0) = -1e-7; }, "has a negative variance"},
      {[](std::vector<LaserBeam>& beams) { beams[0].hits = -1; }, "beams[0].hits is -1"}};
  for (const auto& [change, complaint] : changes) {
    CalibrationFile file = full_calibration();
    change(file.calibration.laser->beams);
    EXPECT_THAT(message_of([&] { text_from_calibration(file); }),
                ::testing::AllOf(HasSubstr(complaint), HasSubstr("; nothing was written")));
  }
  CalibrationFile nearly = full_calibration();
  nearly.calibration.laser->beams[0].line.direction *= 1.0 + 1e-9;  // which is mended
  EXPECT_NO_THROW(calibration_from_text(text_from_calibration(nearly), "c.json"));
}

TEST(CalibrationFile, AShortQuaternionIsMended) {
  CalibrationFile file = full_calibration();
  file.calibration.cameras.resize(1);
  file.summaries.clear();
  file.calibration.cameras[0].camera_from_rig.rotation = Eigen::Quaterniond(M_SQRT1_2, M_SQRT1_2, 0, 0);
  std::string text = text_from_calibration(file);
  const std::size_t begin = text.find('[', text.find("\"rotation_xyzw\": [")), end = text.find(']', begin);
  text.replace(begin, end - begin, "[0.7071, 0, 0, 0.7071");
  const Rigid3 read = calibration_from_text(text, "c.json").calibration.cameras[0].camera_from_rig;
  EXPECT_NEAR(read.rotation.norm(), 1.0, 1e-15);
}

TEST(CalibrationFile, ASelfTestThatWasTakenOutIsMissed) {
  std::string text = text_from_calibration(full_calibration());
  text.replace(text.find("\"self_test\""), text.find("\"provenance\"") - text.find("\"self_test\""),
               "\"self_test\": [], ");
  EXPECT_THAT(read_message(text), HasSubstr("self_test has nothing of camera"));
}

TEST(CalibrationFile, AKeyStandsOnce) {
  const std::string text =
      replaced(text_from_calibration(full_calibration()), "\"cx\": 639.5", "\"cx\": 1, \"cx\": 639.5");
  EXPECT_THAT(read_message(text), HasSubstr("the key 'cx' stands twice"));
}

TEST(CalibrationFile, SelfTestFindsAnEdit) {
  const std::string text = text_from_calibration(full_calibration());
  const std::string edited = replaced(text, "\"cx\": 639.5", "\"cx\": 639.5001");
  EXPECT_THAT(read_message(edited), StartsWith("c.json:"));
  EXPECT_THAT(read_message(edited), HasSubstr("self_test[0] of camera"));
  EXPECT_THAT(read_message(edited), HasSubstr("the file was edited or made by another version; write it again"));
  const std::string moved = replaced(text, "\"translation_m\": [0.1428", "\"translation_m\": [0.1429");
  EXPECT_THAT(read_message(moved), HasSubstr("the file was edited"));
}

TEST(CalibrationFile, EveryComplaintNamesLineAndKey) {
  const std::string text = text_from_calibration(full_calibration());
  struct Case {
    std::string from, to, message;
  };
  const Case cases[] = {
      {"\"version\": 1,", "\"version\": 99,", "c.json:3: version is 99, and this program reads version 1; write the"},
      {"\"raybundle calibration\"", "\"raybundle report\"", "c.json:2: format is 'raybundle report' where"},
      {"\"fx\":", "\"fxx\":", "parameters.fxx is not a key that belongs here. Did you mean \"fx\"?"},
      {"\"width\":", "\"widht\":", "cameras[0].width is missing; add it"},
      {"\"width\": 1280", "\"width\": -3", "cameras[0].width is -3; it must be a whole number from 1 to"},
      {"\"width\": 1280", "\"width\": 99999999999999999999", "where a whole number from 1 to 1000000 is expected"},
      {"\"width\": 1280", "\"width\": 18446744073709551615", "cameras[0].width is 18446744073709551615; it must be"},
      {"\"width\": 1280", "\"width\": 1.5", "cameras[0].width is a number, where a whole number"},
      {"\"width\": 1280", "\"width\": \"1280\"", "cameras[0].width is a text, where a whole number"},
      {"\"fx\": 333.3333333333333", "\"fx\": null", "parameters.fx is null, where a number is expected"},
      {"\"rotation_xyzw\": [", "\"rotation_xyzw\": [1, ", "rotation_xyzw has 5 entries where 4 are expected"},
      {"\"lower_triangle\": [", "\"lower_triangle\": [ [1],", "covariance.lower_triangle has 4 entries where 3"},
      {"\"cameras\": [", "\"cameras\": [], \"old\": [", "c.json:18: cameras is empty; a calibration has at least one"},
      {"\"targets\": [", "\"targets\": 3, \"old\": [", "targets is a number, where an array is expected"},
      {"[11,10,9", "[11,11,9", "targets[0].symmetries[0] is not a reordering of the ids"},
      {"[1,0.0333", "[0,0.0333", "targets[0].points[1] has id 0 after 0; sort the points by id"},
      {"\"direction\":[0.0", "\"direction\":[1.0", "laser.beams[0].direction is no unit vector"},
      {"\"row\":0", "\"row\":7", "laser.beams[0].row is 7; it must be a whole number from 0 to 1"},
      {"\"column\":2", "\"column\":0", "laser.beams[1] stands after a beam of the same or a later row and column"},
      {"\"covariance\":[[1e-07", "\"covariance\":[[-1", "laser.beams[0].covariance[0] has a negative variance"},
      {"\"covariance\":[[1e-07", "\"covariance\":[[1e-30", "laser.beams[0].covariance is no covariance"},
      {"\"camera\":\"", "\"camera\":\"not", "self_test[0].camera 'not"},
      {"\"provenance\": {", "\"provenance\": {,", "this is not valid JSON, the mistake is at the end of"},
  };
  for (const Case& c : cases) {
    const std::string message = read_message(replaced(text, c.from, c.to));
    EXPECT_THAT(message, HasSubstr(c.message));
    EXPECT_THAT(message, ::testing::MatchesRegex("c.json:[0-9]+: .*")) << message;
  }
  const std::string model = "\"" + std::string(model_names()[0]) + "\"";
  EXPECT_THAT(read_message(replaced(text, "\"model\": " + model, "\"model\": \"kannala_brant\"")),
              HasSubstr("cameras[0].model 'kannala_brant' is not a camera model that this version knows. Did you mean "
                        "\"kannala_brandt\"?"));
}

TEST(CalibrationFile, SyntaxErrorsNameTheirLine) {
  EXPECT_THAT(read_message("{\n \"format\": \"raybundle calibration\",\n oops }"), StartsWith("c.json:3: this is not"));
  EXPECT_THAT(read_message("{\n\"a\":\n1e999}"), StartsWith("c.json:3: this is not valid JSON"));
  EXPECT_THAT(read_message("{\n\"a\": NaN}"), StartsWith("c.json:2: this is not valid JSON"));
  EXPECT_THAT(read_message("{\"a\": [1,\n2"), StartsWith("c.json:2: the JSON text ends too early"));
  EXPECT_THAT(read_message(std::string("\xff\xd8\xff\xe0\0\x10JFIF", 10)),
              StartsWith("c.json:1: this is not JSON, and no"));
  EXPECT_THAT(read_message(""), StartsWith("c.json:1: the JSON text ends too early"));
  EXPECT_THAT(read_message("[]"), StartsWith("c.json:1: the whole text is an array, where an object is expected"));
  EXPECT_THAT(read_message(std::string(1'000'000, '[')), StartsWith("c.json:1: the JSON text ends too early"));
}

// A camera that could not be calibrated has a summary in the result, but no place in the file.
TEST(CalibrationFile, LeavesOutCamerasThatWereNotCalibrated) {
  CalibrationProblem problem;
  problem.cameras.resize(2);
  problem.cameras[0].name = "lost";
  problem.cameras[1].name = "found";
  CalibrationResult result;
  result.cameras.resize(2);
  result.cameras[1].rms_px = 0.25;
  result.calibration.cameras.resize(1);
  result.calibration.cameras[0].name = "found";
  const CalibrationFile file = calibration_file(problem, result);
  ASSERT_EQ(file.summaries.size(), 1u);
  EXPECT_EQ(file.summaries[0].rms_px, 0.25);
}

}  // namespace
}  // namespace raybundle::testing
