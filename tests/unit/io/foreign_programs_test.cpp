// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Each program's own files: as it writes them, and as its readers want them.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdio>

#include "foreign_examples.hpp"

namespace raybundle::testing {
namespace {

using ::testing::HasSubstr;

TEST(Kalibr, WritesNumbersWithAPointAsItsReaderWants) {
  Camera camera = start_camera(*model_named("kannala_brandt"), {640, 480}, 800.0);
  camera.parameters[4] = 1e-5;
  const std::string text = texts_of(*foreign_format_named("kalibr"), {{"left", camera, {}}})[0].text;
  EXPECT_THAT(text, HasSubstr("intrinsics: [800.0, 800.0, 319.5, 239.5]"));
  EXPECT_THAT(text, HasSubstr("distortion_coeffs: [1.0e-05, 0.0, 0.0, 0.0]"));
  EXPECT_THAT(text, HasSubstr("resolution: [640, 480]"));
}

TEST(Kalibr, IsReadAsItWritesItself) {
  const auto rig = read_as("kalibr", with_text(R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.3, 0.09, 0.0002, -2.0e-05]
  distortion_model: radtan
  intrinsics: [458.5, 457.25, 367.25, 248.375]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.11]
  - [0.0, 1.0, 0.0, 0.002]
  - [0.0, 0.0, 1.0, -0.001]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: ds
  distortion_coeffs: []
  distortion_model: none
  intrinsics: [-0.2, 0.55, 300.5, 301.0, 375.5, 240.25]
  resolution: [752, 480]
  rostopic: /cam1/image_raw
)"));
  ASSERT_EQ(rig.size(), 2U);
  EXPECT_EQ(model_name(rig[0].camera.model), "brown_conrady");
  EXPECT_EQ(rig[0].camera.parameters,
            (Eigen::VectorXd(9) << 458.5, 457.25, 367.25, 248.375, -0.3, 0.09, 0.0002, -2e-5, 0).finished());
  EXPECT_EQ(model_name(rig[1].camera.model), "double_sphere");
  EXPECT_EQ(rig[1].camera.parameters, (Eigen::VectorXd(6) << 300.5, 301, 375.5, 240.25, -0.2, 0.55).finished());
  EXPECT_EQ(rig[1].camera_from_rig.translation, Eigen::Vector3d(-0.11, 0.002, -0.001));
}

TEST(Kalibr, NamesTheLineOfAMistake) {
  const std::string good = texts_of(*foreign_format_named("kalibr"),
                                    {{"left", start_camera(*model_named("kannala_brandt"), {640, 480}, 800.0), {}}})[0]
                               .text;
  const auto message = [&](const char* from, const char* to) {
    return message_of([&] { read_as("kalibr", with_text(replaced(good, from, to), "chain.yaml")); });
  };
  EXPECT_THAT(message("equidistant", "equal"), HasSubstr("chain.yaml:2: cam0.camera_model"));
  EXPECT_THAT(message("640, 480", "640"), HasSubstr("chain.yaml:6: cam0.resolution has 1 numbers"));
  EXPECT_THAT(message("319.5", "nan"), HasSubstr("chain.yaml:3: cam0.intrinsics"));
  EXPECT_THAT(message("  camera_model: pinhole\n", ""), HasSubstr("cam0.camera_model is missing"));
  EXPECT_THAT(message("[800.0,", "[-800.0,"), HasSubstr("focal length that is not positive"));
}

TEST(Kalibr, RefusesATransformByColumns) {
  const Camera camera = start_camera(*model_named("pinhole"), {640, 480}, 800.0);
  const std::vector<RigCamera> rig{{"left", camera, {}}, {"right", camera, {{}, {-0.1, 0.0, 0.0}}}};
  std::string text = texts_of(*foreign_format_named("kalibr"), rig)[0].text;
  text = replaced(text, "- [1.0, 0.0, 0.0, -0.1]", "- [1.0, 0.0, 0.0, 0.0]");
  text = replaced(text, "- [0.0, 0.0, 0.0, 1.0]", "- [-0.1, 0.0, 0.0, 1.0]");
  EXPECT_THAT(message_of([&] { read_as("kalibr", with_text(text, "chain.yaml")); }),
              ::testing::MatchesRegex("chain.yaml:[0-9]+: cam1.T_cn_cnm1 is not a transform by rows.*transposed.*"));
}

TEST(Ros, TakesAFileWithoutAModelForPlumbBobAsRosDoes) {
  const auto rig = read_as(
      "ros", with_text("image_width: 640\nimage_height: 480\ncamera_name: head\n"
                       "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [500, 0, 320, 0, 510, 240, 0, 0, 1]\n"
                       "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.3, 0.1, 0.001, -0.002, 0]\n"));
  EXPECT_EQ(rig[0].name, "head");
  EXPECT_EQ(model_name(rig[0].camera.model), "brown_conrady");
  EXPECT_EQ(rig[0].camera.parameters,
            (Eigen::VectorXd(9) << 500, 510, 320, 240, -0.3, 0.1, 0.001, -0.002, 0).finished());
}

TEST(Ros, RefusesACameraMatrixByColumns) {
  const std::string text = texts_of(*foreign_format_named("ros"),
                                    {{"left", start_camera(*model_named("pinhole"), {640, 480}, 300.0), {}}})[0]
                               .text;
  const auto message = [&](const char* from, const char* to) {
    return message_of([&] { read_as("ros", with_text(replaced(text, from, to))); });
  };
  EXPECT_THAT(message("[300.0, 0.0, 319.5, 0.0, 300.0, 239.5, 0.0, 0.0, 1.0]",
                      "[300.0, 0.0, 0.0, 0.0, 300.0, 0.0, 319.5, 239.5, 1.0]"),
              HasSubstr("camera_matrix.data is not fx 0 cx, 0 fy cy, 0 0 1 by rows; is it transposed?"));
  EXPECT_THAT(message("239.5, 0.0, 0.0, 1.0]", "239.5, 0.0, 0.0, 0.0]"), HasSubstr("camera_matrix.data is not"));
}

// URDF: the pose of a camera in the first one, roll, pitch and yaw about fixed axes.
TEST(Ros, TellsThePlaceOfTheSecondCamera) {
  const Camera camera = start_camera(*model_named("pinhole"), {640, 480}, 800.0);
  const std::vector<RigCamera> rig{{"left", camera, {}}, {"right", camera, awkward_rigid3(3)}};
  const std::vector<NamedText> files = texts_of(*foreign_format_named("ros"), rig);
  ASSERT_EQ(files.back().name, "rig.urdf");
  const std::string& text = files.back().text;
  double x, y, z, roll, pitch, yaw;
  ASSERT_EQ(std::sscanf(text.c_str() + text.find("xyz="), "xyz=\"%lf %lf %lf\" rpy=\"%lf %lf %lf\"", &x, &y, &z, &roll,
                        &pitch, &yaw),
            6);
  Rigid3 first_from_second;
  first_from_second.rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
  first_from_second.translation = {x, y, z};
  EXPECT_LE(motion_between(first_from_second.inverse(), rig[1].camera_from_rig).norm(), 1e-13);
}

TEST(Mrcal, IsReadWithTheWholeSolveBehindTheLens) {
  const auto rig = read_as("mrcal", with_text(R"(# generated by somebody
{
    'lensmodel':  'LENSMODEL_OPENCV4',

    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....
    'intrinsics': [ 1761.5, 1761.25, 1965.5, 1087.5, -0.01, 0.002, -0.0003, 4e-05,],

    # extrinsics are rt_fromref
    'extrinsics': [ 0, 0, 0, 0, 0, 0,],

    'imagersize': [ 4000, 2200,],

    'icam_intrinsics': 0,

    'optimization_inputs': b'P)h>@6aWAK2mk;8Apigf{}#[,:|~`^_001yZ003wJ4',

}
)",
                                              "folder/camera-0.cameramodel"));
  EXPECT_EQ(rig[0].name, "camera-0");
  EXPECT_EQ(rig[0].camera.size, (ImageSize{4000, 2200}));
  EXPECT_EQ(rig[0].camera.parameters,
            (Eigen::VectorXd(9) << 1761.5, 1761.25, 1965.5, 1087.5, -0.01, 0.002, -0.0003, 4e-5, 0).finished());
}

TEST(OpenCv, ReadsTheCoefficientsByTheirNumber) {
  const auto text = [](const char* coefficients, const char* more = "") {
    return std::string("%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n") + more +
           "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 500., 0., 320., 0., 500., 240., 0., 0., 1. ]\n"
           "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   data: [" +
           coefficients + "]\n";
  };
  const auto model_of = [&](const char* coefficients, const char* more = "") {
    return model_name(read_as("opencv", with_text(text(coefficients, more)))[0].camera.model);
  };
  EXPECT_EQ(model_of("1, 2, 3, 4"), "brown_conrady");
  EXPECT_EQ(model_of("1, 2, 3, 4, 5"), "brown_conrady");
  EXPECT_EQ(model_of("1, 2, 3, 4, 5, 6, 7, 8"), "rational");
  EXPECT_EQ(model_of("1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12"), "thin_prism");
  EXPECT_EQ(model_of("1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 0, 0"), "thin_prism");
  EXPECT_EQ(model_of("1, 2, 3, 4", "fisheye_model: 1\n"), "kannala_brandt");
  EXPECT_EQ(model_of("1, 2, 3, 4", "xi: 1.5\n"), "unified");
  EXPECT_THAT(message_of([&] { model_of("1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 0.1, 0"); }),
              HasSubstr("coefficient that no lens here has"));
  EXPECT_THAT(message_of([&] { model_of("1, 2, 3, 4, 5, 6"); }), HasSubstr("10 numbers where"));
  EXPECT_THAT(message_of([&] {
                read_as("opencv", with_text(replaced(text("1, 2, 3, 4"), "500., 0., 320.", "500., 0.1, 320.")));
              }),
              HasSubstr("skew"));
  EXPECT_THAT(message_of([&] {
                read_as("opencv", with_text(replaced(text("1, 2, 3, 4"), "500., 0., 320., 0., 500., 240., 0., 0.,",
                                                     "500., 0., 0., 0., 500., 0., 320., 240.,")));
              }),
              HasSubstr("file:9: camera_matrix.data is not fx 0 cx, 0 fy cy, 0 0 1 by rows; is it transposed?"));
}

TEST(Colmap, CountsPixelsFromTheCornerOfTheFirst) {
  Camera camera = start_camera(*model_named("pinhole"), {640, 480}, 800.0);
  const std::string text = texts_of(*foreign_format_named("colmap"), {{"left", camera, {}}})[0].text;
  EXPECT_THAT(text, HasSubstr("1 PINHOLE 640 480 800 800 320 240\n"));
  const auto rig = read_as(
      "colmap", with_text("# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n1 SIMPLE_RADIAL 640 480 700 320 240 -0.05\n"));
  EXPECT_EQ(rig[0].camera.parameters, (Eigen::VectorXd(9) << 700, 700, 319.5, 239.5, -0.05, 0, 0, 0, 0).finished());
}

TEST(Basalt, ReadsTheUnifiedCameraAsAnExtendedOne) {
  Camera camera = start_camera(*model_named("extended_unified"), {640, 480}, 300.0);
  camera.parameters.tail<2>() << 0.6, 1.0;
  std::string text = texts_of(*foreign_format_named("basalt"), {{"left", camera, {}}})[0].text;
  text = replaced(text, "\"eucm\"", "\"ucm\"");
  EXPECT_EQ(read_as("basalt", with_text(text))[0].camera.parameters, camera.parameters);
}

TEST(Camodocal, CountsTheFisheyesCoefficientsFromTwo) {
  Camera camera = start_camera(*model_named("kannala_brandt"), {640, 480}, 300.0);
  camera.parameters.tail<4>() << 0.1, 0.2, 0.3, 0.4;
  const std::string text = texts_of(*foreign_format_named("camodocal"), {{"left", camera, {}}})[0].text;
  EXPECT_THAT(text, HasSubstr("   k2: 0.1\n   k3: 0.2\n   k4: 0.3\n   k5: 0.4\n   mu: 300.0\n"));
}

TEST(Camodocal, IsReadByTheOrderOfItsPlacesAsVinsFusionWritesThem) {
  const Camera camera = start_camera(*model_named("pinhole"), {640, 480}, 800.0);
  const Rigid3 beside{Eigen::Quaterniond::Identity(), {-0.1, 0.0, 0.0}};
  const std::vector<NamedText> files =
      texts_of(*foreign_format_named("camodocal"), {{"right", camera, {}}, {"left", camera, beside}});
  ASSERT_EQ(files.size(), 3U);
  const std::vector<RigCamera> back = read_as("camodocal", {files[1], files[2], files[0]});
  EXPECT_EQ(back[0].name, "right");
  EXPECT_EQ(back[1].camera_from_rig.translation, beside.translation);
  EXPECT_THAT(message_of([&] {
                read_as("camodocal", {files[0], files[2]});
              }),
              HasSubstr("names a file that was not given"));
  EXPECT_THAT(message_of([&] { read_as("camodocal", {files[0], files[1]}); }), HasSubstr("does not say where"));
}

TEST(Camodocal, RefusesATransformByColumns) {
  const Camera camera = start_camera(*model_named("pinhole"), {640, 480}, 800.0);
  std::vector<NamedText> files =
      texts_of(*foreign_format_named("camodocal"), {{"left", camera, {}}, {"right", camera, {{}, {-0.1, 0.0, 0.0}}}});
  std::string& places = files.back().text;
  places = replaced(places, "[1.0, 0.0, 0.0, 0.1,", "[1.0, 0.0, 0.0, 0.0,");
  places.replace(places.rfind("0.0, 0.0, 0.0, 1.0]"), 3, "0.1");
  EXPECT_THAT(message_of([&] { read_as("camodocal", files); }), HasSubstr("body_T_cam1 is not a transform by rows"));
}

TEST(Colmap, GoesByIdsAndByTheValueOfTheReference) {
  const Camera wide = start_camera(*model_named("pinhole"), {640, 480}, 300.0);
  const Camera narrow = start_camera(*model_named("pinhole"), {640, 480}, 800.0);
  std::vector<NamedText> files =
      texts_of(*foreign_format_named("colmap"), {{"left", wide, {}}, {"right", narrow, awkward_rigid3(2)}});
  const std::size_t second = files[0].text.find("\n1 ") + 1, third = files[0].text.find("\n2 ") + 1;
  files[0].text =
      files[0].text.substr(0, second) + files[0].text.substr(third) + files[0].text.substr(second, third - second);
  const std::vector<RigCamera> back = read_as("colmap", files);
  EXPECT_EQ(back[0].name, "left");
  EXPECT_EQ(back[0].camera.parameters, wide.parameters);
  files[0].text = replaced(files[0].text, " 300 300 ", " 301 301 ");
  EXPECT_THAT(message_of([&] { read_as("colmap", files); }), HasSubstr("put both in the same order"));
  files[1].text = replaced(files[1].text, "\"ref_sensor\": true", "\"ref_sensor\": false");
  EXPECT_THAT(message_of([&] { read_as("colmap", files); }), HasSubstr("same order"));
}

// Values that Kalibr's reader ends at.
TEST(Kalibr, IsNotGivenWhatItRefuses) {
  const ForeignFormat& kalibr = *foreign_format_named("kalibr");
  Camera sphere = start_camera(*model_named("unified"), {640, 480}, 300.0);
  EXPECT_NE(lens_for(kalibr, sphere), nullptr);
  sphere.parameters[4] = -0.2;
  EXPECT_EQ(lens_for(kalibr, sphere), nullptr);
  Camera aside = start_camera(*model_named("kannala_brandt"), {640, 480}, 300.0);
  aside.parameters[2] = -3.0;
  EXPECT_EQ(lens_for(kalibr, aside), nullptr);
  EXPECT_EQ(lens_for(kalibr, start_camera(*model_named("pinhole"), {640, 480}, 300.0))->name, "pinhole-radtan");
}

TEST(Kalibr, IsReadWithPlacesOnABodyAsOpenVinsWritesThem) {
  const auto camera = [](const std::string& key, const std::string& x_m, const std::string& topic) {
    return key + R"(:
  T_imu_cam:
    - [1.0, 0.0, 0.0, )" +
           x_m + R"(]
    - [0.0, 1.0, 0.0, 0.0]
    - [0.0, 0.0, 1.0, 0.0]
    - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]
  distortion_model: equidistant
  intrinsics: [300.0, 300.0, 320.0, 240.0]
  resolution: [640, 480]
  rostopic: )" +
           topic + "\n";
  };
  const auto rig = read_as("kalibr", with_text("%YAML:1.0\n\n" + camera("cam0", "0.5", "/left/image_raw") +
                                               camera("cam1", "0.6", "/right/image_raw")));
  ASSERT_EQ(rig.size(), 2U);
  EXPECT_EQ(rig[1].name, "right");
  EXPECT_NEAR(rig[1].camera_from_rig.translation.x(), -0.1, 1e-12);
}

TEST(Ros, RefusesTheKeyThatItsOwnLoadersIgnore) {
  const std::string text = texts_of(*foreign_format_named("ros"),
                                    {{"left", start_camera(*model_named("kannala_brandt"), {640, 480}, 300.0), {}}})[0]
                               .text;
  EXPECT_THAT(message_of([&] {
                read_as("ros", with_text(replaced(text, "distortion_model: equidistant", "camera_model: fisheye")));
              }),
              HasSubstr("takes such a file for plumb_bob"));
}

}  // namespace
}  // namespace raybundle::testing
