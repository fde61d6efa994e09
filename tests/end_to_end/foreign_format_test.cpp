// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/ccalib/omnidir.hpp>
#include <opencv2/core.hpp>

#if __has_include(<mrcal/mrcal.h>)
extern "C" {
#include <mrcal/mrcal.h>
}
#endif

#include "program.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/io/foreign_format.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kRoundTrip_px = 1e-9;

// OpenCV's stereo pairs.
fs::path calibration_with(const std::string& model) {
  const fs::path place = fresh_folder() / model;
  fs::create_directories(place);
  const fs::path images = real_data("opencv_stereo_chess");
  calibrate(place, {"--target", "chessboard:9x6:25mm", "--camera", "left=" + (images / "left*.jpg").string(),
                    "--camera", "right=" + (images / "right*.jpg").string(), "--model", model});
  return place / "out" / "calibration.json";
}

// A pair of a model's first two example lenses, in one of which no two coefficients are alike, turned against each other.
fs::path calibration_of_examples(const std::string& model) {
  const Camera start = start_camera(*model_named(model), {640, 480}, 400.0);
  CalibrationFile file;
  file.calibration.cameras = {{"left", start, {}}, {"right", start, {}}};
  with_model(start.model, [&]<CameraModel M>() {
    for (std::size_t i = 0; i < 2; ++i) {
      for (int k = 0; k < kShapeSize<M>; ++k) {
        file.calibration.cameras[i].camera.parameters[4 + k] = M::kExamples[i].shape[static_cast<std::size_t>(k)];
      }
    }
  });
  file.calibration.cameras[1].camera.parameters.head<4>() << 401.0, 402.0, 310.0, 245.0;
  file.calibration.cameras[1].camera_from_rig = {
      Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d(1, -2, 3).normalized())), {-0.1, 0.02, -0.03}};
  const fs::path calibration = fresh_folder() / "calibration.json";
  write_calibration(calibration, file);
  return calibration;
}

// Points in front of a pair, in the frame of its left camera [m].
std::vector<Eigen::Vector3d> points_before_the_pair() {
  std::vector<Eigen::Vector3d> points;
  for (const double x : {-0.2, 0.0, 0.25}) {
    for (const double y : {-0.15, 0.05, 0.2}) points.emplace_back(x, y, 1.2 + x - y);
  }
  return points;
}

// Where the calibration says that a camera sees them.
std::vector<Eigen::Vector2d> pixels_by(const fs::path& calibration, const std::string& camera) {
  const CalibrationFile file = read_calibration(calibration);
  const RigCamera& rig_camera = camera_named(file.calibration, camera);
  std::vector<Eigen::Vector2d> pixels;
  for (const Eigen::Vector3d& x_in_rig : points_before_the_pair()) {
    pixels.push_back(pixel_from_ray(rig_camera.camera, rig_camera.camera_from_rig * x_in_rig).value());
  }
  return pixels;
}

// As a user of OpenCV reads the files.
std::vector<Eigen::Vector2d> pixels_by_opencv(const fs::path& file) {
  cv::FileStorage storage(file.string(), cv::FileStorage::READ);
  cv::Mat camera, coefficients, rotation, place, turn;
  storage["camera_matrix"] >> camera;
  storage["distortion_coefficients"] >> coefficients;
  storage["R"] >> rotation;
  storage["T"] >> place;
  cv::Rodrigues(rotation, turn);
  std::vector<cv::Point3d> points;
  for (const Eigen::Vector3d& x : points_before_the_pair()) points.emplace_back(x.x(), x.y(), x.z());
  std::vector<cv::Point2d> projected;
  if (int(storage["fisheye_model"]) != 0) {
    cv::fisheye::projectPoints(points, projected, turn, place, camera, coefficients);
  } else if (!storage["xi"].empty()) {
    cv::omnidir::projectPoints(points, projected, turn, place, camera, double(storage["xi"]), coefficients);
  } else {
    cv::projectPoints(points, turn, place, camera, coefficients, projected);
  }
  std::vector<Eigen::Vector2d> pixels;
  for (const cv::Point2d& pixel : projected) pixels.emplace_back(pixel.x, pixel.y);
  return pixels;
}

using PixelsBy = std::vector<Eigen::Vector2d> (*)(const fs::path& file);

// What another program reads in the files of a pair shows it the same pixels.
void expect_same_pixels(const std::string& format, const char* ending, PixelsBy pixels_by_it,
                        const std::vector<std::string>& models) {
  for (const std::string& model : models) {
    const fs::path calibration = calibration_of_examples(model), folder = calibration.parent_path() / format;
    const ProgramRun run = raybundle_program({"export", calibration.string(), "--to", format, "-o", folder.string()});
    ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
    for (const std::string camera : {"left", "right"}) {
      const auto expected = pixels_by(calibration, camera), found = pixels_by_it(folder / (camera + ending));
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_LT((found[i] - expected[i]).norm(), kRoundTrip_px) << model << " " << camera;
      }
    }
  }
}

TEST(Exports, WhatOpenCvProjectsAlike) {
  expect_same_pixels("opencv", ".yml", pixels_by_opencv,
                     {"kannala_brandt", "brown_conrady", "rational", "thin_prism", "unified"});
}

#if __has_include(<mrcal/mrcal.h>)
std::vector<Eigen::Vector2d> pixels_by_mrcal(const fs::path& file) {
  mrcal_cameramodel_t* model = mrcal_read_cameramodel_file(file.c_str());
  if (model == nullptr) return {};
  EXPECT_EQ(model->imagersize[0], 640U);
  std::vector<Eigen::Vector2d> pixels;
  for (const Eigen::Vector3d& x : points_before_the_pair()) {
    mrcal_point3_t in_camera;
    mrcal_transform_point_rt(in_camera.xyz, nullptr, nullptr, model->rt_cam_ref, x.data());
    mrcal_point2_t pixel;
    EXPECT_TRUE(mrcal_project(&pixel, nullptr, nullptr, &in_camera, 1, &model->lensmodel, model->intrinsics));
    pixels.emplace_back(pixel.x, pixel.y);
  }
  mrcal_free_cameramodel(&model);
  return pixels;
}

TEST(Exports, WhatMrcalReadsAndProjectsAlike) {
  expect_same_pixels("mrcal", ".cameramodel", pixels_by_mrcal, {"brown_conrady", "rational", "thin_prism"});
}
#endif

TEST(Exports, EveryFormatComesBackAsTheSameRig) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  const fs::path calibration = calibration_with("kannala_brandt");
  const fs::path place = calibration.parent_path();
  for (const ForeignFormat& format : foreign_formats()) {
    SCOPED_TRACE(format.name);
    const fs::path files = place / format.name;
    const ProgramRun out = raybundle_program({"export", calibration.string(), "--to", std::string(format.name), "-o",
                                              files.string(), "--max-px", "1", "--json"});
    ASSERT_EQ(out.exit_code, 0) << out.err;
    const nlohmann::json told = nlohmann::json::parse(out.out);
    EXPECT_EQ(told["passed"], true);
    for (const auto& camera : told["cameras"]) {
      const bool fisheyes_are_there = format.name != "mrcal";
      EXPECT_EQ(camera["same_lens"], fisheyes_are_there);
      EXPECT_LT(camera["largest_px"], fisheyes_are_there ? kRoundTrip_px : 1.0);
      EXPECT_GT(camera["sigma_there_px"], 0.0);
    }
    const fs::path back = place / "back.json";
    const std::string input = format.holds_extrinsics ? files.string() : (files / "left.yaml").string();
    const ProgramRun in = raybundle_program({"import", input, "-o", back.string()});
    ASSERT_EQ(in.exit_code, 0) << in.err;
    EXPECT_THAT(in.out, HasSubstr("raybundle validate"));
    if (!format.holds_extrinsics) continue;
    const Calibration ours = read_calibration(calibration).calibration, theirs = read_calibration(back).calibration;
    ASSERT_EQ(theirs.cameras.size(), 2U);
    EXPECT_LE(motion_between(ours.cameras[1].camera_from_rig, theirs.cameras[1].camera_from_rig).norm(), 1e-12);
  }
}

TEST(Exports, NothingBeyondTheErrorThatIsAllowed) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  const fs::path calibration = calibration_with("kannala_brandt");
  const fs::path folder = calibration.parent_path() / "mrcal";
  const std::vector<std::string> words{"export", calibration.string(), "--to",   "mrcal",
                                       "-o",     folder.string(),      "--lens", "LENSMODEL_PINHOLE"};
  const ProgramRun run = raybundle_program(words);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.out, HasSubstr("FAIL  left: LENSMODEL_PINHOLE, the lens of mrcal, is up to"));
  EXPECT_THAT(run.out, Not(HasSubstr("wrote")));
  EXPECT_FALSE(fs::exists(folder));
  std::vector<std::string> allowed = words;
  allowed.insert(allowed.end(), {"--max-px", "500"});
  EXPECT_EQ(raybundle_program(allowed).exit_code, 0);
  EXPECT_TRUE(fs::exists(folder / "left.cameramodel"));
}

// cv::fisheye takes the arctangent of r / z: it mirrors what is behind the camera.
TEST(Exports, NoFisheyeFartherThanTheOtherProgramSees) {
  const fs::path place = fresh_folder();
  CalibrationFile file;
  Camera camera = start_camera(*model_named("kannala_brandt"), {640, 480}, 190.0);
  file.calibration.cameras = {{"wide", camera, {}}};
  write_calibration(place / "wide.json", file);
  const std::vector<std::string> words{"export", (place / "wide.json").string(), "--to",   "opencv",
                                       "-o",     (place / "cv").string(),        "--lens", "fisheye"};
  const ProgramRun run = raybundle_program(words);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.out, HasSubstr("FAIL  wide: fisheye, the lens of opencv, does not see"));
  std::vector<std::string> within = words;
  within.insert(within.end(), {"--within", "89"});
  EXPECT_EQ(raybundle_program(within).exit_code, 0);
}

TEST(Exports, NeverOverWhatTheyRead) {
  const fs::path place = fresh_folder();
  CalibrationFile file;
  file.calibration.cameras = {{"one", start_camera(*model_named("kannala_brandt"), {640, 480}, 400.0), {}}};
  write_calibration(place / "one.json", file);
  const std::string before = text_of(place / "one.json"), path = (place / "one.json").string();
  EXPECT_EQ(raybundle_program({"export", path, "--to", "kalibr", "-o", path}).exit_code, 2);
  EXPECT_EQ(text_of(place / "one.json"), before);
  const std::string chain = (place / "chain.yaml").string();
  EXPECT_EQ(raybundle_program({"export", path, "--to", "kalibr", "-o", chain}).exit_code, 0);
  const std::string exported = text_of(chain);
  EXPECT_EQ(raybundle_program({"import", chain, "-o", chain}).exit_code, 2);
  EXPECT_EQ(text_of(chain), exported);
}

TEST(Exports, OneCameraOfARig) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  const fs::path calibration = calibration_with("kannala_brandt");
  const fs::path folder = calibration.parent_path() / "ros";
  const ProgramRun run =
      raybundle_program({"export", calibration.string(), "--to", "ros", "--camera", "right", "-o", folder.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(fs::exists(folder / "right.yaml"));
  EXPECT_FALSE(fs::exists(folder / "left.yaml"));
  EXPECT_FALSE(fs::exists(folder / "rig.urdf"));
}

TEST(Exports, SayWhatIsMissing) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  const std::string calibration = calibration_with("kannala_brandt").string();
  const std::string file = calibration + "_file";
  const auto error = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"export", calibration});
    const ProgramRun run = raybundle_program(words);
    EXPECT_EQ(run.exit_code, 2) << run.out;
    return run.err;
  };
  EXPECT_THAT(error({"--to", "opencv"}), HasSubstr("-o FOLDER, as in -o opencv"));
  EXPECT_THAT(error({"--to", "kalibr"}), HasSubstr("-o FILE, as in -o camchain.yaml"));
  EXPECT_THAT(error({"-o", file}), HasSubstr("--to FORMAT"));
  EXPECT_THAT(error({"--to", "kalibr", "-o", file, "--lens", "pinhole-equis"}),
              HasSubstr("Did you mean \"pinhole-equi\"?"));
}

TEST(Imports, WhatValidateAndCompareTake) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  const fs::path calibration = calibration_with("rational");
  const fs::path place = calibration.parent_path();
  ASSERT_EQ(
      raybundle_program({"export", calibration.string(), "--to", "opencv", "-o", (place / "cv").string()}).exit_code,
      0);
  const std::string imported = (place / "imported.json").string();
  ASSERT_EQ(
      raybundle_program({"import", (place / "cv/left.yml").string(), (place / "cv/right.yml").string(), "-o", imported})
          .exit_code,
      0);
  const ProgramRun compared = raybundle_program({"compare", calibration.string(), imported, "--max-px", "1e-6"});
  EXPECT_EQ(compared.exit_code, 0) << compared.out << compared.err;
  const fs::path images = real_data("opencv_stereo_chess");
  const std::vector<std::string> words{"validate", imported,
                                       "--target", "chessboard:9x6:25mm",
                                       "--camera", "left=" + (images / "left0*.jpg").string(),
                                       "--camera", "right=" + (images / "right0*.jpg").string()};
  const ProgramRun without_limit = raybundle_program(words);
  EXPECT_THAT(without_limit.err, HasSubstr("give --max-rms"));
  std::vector<std::string> with_limit = words;
  with_limit.insert(with_limit.end(), {"--max-rms", "0.5"});
  const ProgramRun validated = raybundle_program(with_limit);
  EXPECT_EQ(validated.exit_code, 0) << validated.out << validated.err;
}

TEST(Imports, SayWhatTheyCannotRead) {
  const fs::path place = fresh_folder();
  const std::string output = (place / "out.json").string();
  const auto error = [&](const std::string& text) {
    write_text(place / "theirs.yaml", text);
    const ProgramRun run = raybundle_program({"import", (place / "theirs.yaml").string(), "-o", output});
    EXPECT_EQ(run.exit_code, 2) << run.out;
    EXPECT_FALSE(fs::exists(output));
    return run.err;
  };
  EXPECT_THAT(error("hello"), HasSubstr("no format that is known here"));
  EXPECT_THAT(error("cam0:\n  distortion_model: [\n"), HasSubstr("not valid YAML"));
  EXPECT_THAT(error("cam0:\n  camera_model: pinhole\n  distortion_model: radtan\n"),
              HasSubstr("cam0.intrinsics is missing"));
  EXPECT_THAT(error("\"raybundle calibration\""), HasSubstr("already"));
}

}  // namespace
}  // namespace raybundle::testing
