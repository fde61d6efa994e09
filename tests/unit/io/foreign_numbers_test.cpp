// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// What each number of a lens means in the files of other programs. Our writer and our reader share one list of places,
// by which anything comes back; these texts are by the programs' own documentation. OpenCV: calib3d (projectPoints,
// fisheye) and ccalib (omnidir). ROS: sensor_msgs/CameraInfo, with OpenCV's order. Kalibr: wiki, "Supported models"; r1
// and r2 of radtan are OpenCV's p1 and p2. mrcal: "lens models"; the OPENCV family has OpenCV's order. COLMAP:
// sensor/models.h. Basalt: serialization/headers_serialization.h. CamOdoCal: camera_models/*Camera.cc.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "foreign_examples.hpp"

namespace raybundle::testing {
namespace {

// A file of one camera with fx 501, fy 502, cx 303 and cy 204, and the rest of its lens in our words.
struct Example {
  std::string format, lens, text, model, shape;
  double fy = 502;
};

Example opencv(const char* lens, const char* coefficients, const char* model, const char* shape,
               const char* more = "") {
  return {"opencv", lens,
          fmt::format("%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n{}"
                      "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
                      "   data: [ 501., 0., 303., 0., 502., 204., 0., 0., 1. ]\n"
                      "distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ {} ]\n",
                      more, coefficients),
          model, shape};
}

Example ros(const char* lens, const char* coefficients, const char* model, const char* shape) {
  return {"ros", lens,
          fmt::format("image_width: 640\nimage_height: 480\ncamera_name: head\n"
                      "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [501, 0, 303, 0, 502, 204, 0, 0, 1]\n"
                      "distortion_model: {}\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [{}]\n",
                      lens, coefficients),
          model, shape};
}

Example kalibr(const char* lens, const char* theirs, const char* intrinsics, const char* distortion,
               const char* coefficients, const char* model, const char* shape) {
  return {"kalibr", lens,
          fmt::format("cam0:\n  camera_model: {}\n  intrinsics: [{}]\n  distortion_model: {}\n"
                      "  distortion_coeffs: [{}]\n  resolution: [640, 480]\n",
                      theirs, intrinsics, distortion, coefficients),
          model, shape};
}

Example mrcal(const char* lens, const char* intrinsics, const char* model, const char* shape) {
  return {"mrcal", lens,
          fmt::format("{{\n    'lensmodel': '{}',\n    'intrinsics': [ {},],\n    'extrinsics': [ 0, 0, 0, 0, 0, 0,],\n"
                      "    'imagersize': [ 640, 480,],\n}}\n",
                      lens, intrinsics),
          model, shape};
}

// Pixels are counted from the corner of the first one.
Example colmap(const char* lens, const char* parameters, const char* model, const char* shape, double fy = 502) {
  return {
      "colmap", lens,  fmt::format("# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n1 {} 640 480 {}\n", lens, parameters),
      model,    shape, fy};
}

Example basalt(const char* lens, const char* intrinsics, const char* model, const char* shape) {
  return {"basalt", lens,
          fmt::format(R"({{"value0": {{
                            "T_imu_cam": [{{"px": 0, "py": 0, "pz": 0, "qx": 0, "qy": 0, "qz": 0, "qw": 1}}],
                            "intrinsics": [{{"camera_type": "{}", "intrinsics": {{{}}}}}],
                            "resolution": [[640, 480]]}}}})",
                      lens, intrinsics),
          model, shape};
}

Example camodocal(const char* lens, const char* sections, const char* model, const char* shape) {
  return {"camodocal", lens,
          fmt::format("%YAML:1.0\n---\nmodel_type: {}\ncamera_name: head\nimage_width: 640\nimage_height: 480\n{}",
                      lens, sections),
          model, shape};
}

const std::vector<Example>& examples() {
  static const std::vector<Example> all{
      opencv("plumb_bob", "0.1, 0.2, 0.3, 0.4", "brown_conrady", "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0"),
      opencv("plumb_bob", "0.1, 0.2, 0.3, 0.4, 0.5", "brown_conrady", "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0.5"),
      opencv("rational_polynomial", "0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8", "rational",
             "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0.5, k4 0.6, k5 0.7, k6 0.8"),
      opencv("thin_prism", "0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.1, 1.2, 1.3", "thin_prism",
             "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0.5, k4 0.6, k5 0.7, k6 0.8, s1 0.9, s2 1.1, s3 1.2, s4 1.3"),
      opencv("fisheye", "0.1, 0.2, 0.3, 0.4", "kannala_brandt", "k1 0.1, k2 0.2, k3 0.3, k4 0.4", "fisheye_model: 1\n"),
      opencv("omnidir", "0.1, 0.2, 0.3, 0.4", "unified", "xi 1.5, k1 0.1, k2 0.2, p1 0.3, p2 0.4", "xi: 1.5\n"),

      ros("plumb_bob", "0.1, 0.2, 0.3, 0.4, 0.5", "brown_conrady", "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0.5"),
      ros("rational_polynomial", "0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8", "rational",
          "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0.5, k4 0.6, k5 0.7, k6 0.8"),
      ros("equidistant", "0.1, 0.2, 0.3, 0.4", "kannala_brandt", "k1 0.1, k2 0.2, k3 0.3, k4 0.4"),

      kalibr("pinhole-none", "pinhole", "501.0, 502.0, 303.0, 204.0", "none", "", "pinhole", ""),
      kalibr("pinhole-radtan", "pinhole", "501.0, 502.0, 303.0, 204.0", "radtan", "0.1, 0.2, 0.3, 0.4", "brown_conrady",
             "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0"),
      kalibr("pinhole-equi", "pinhole", "501.0, 502.0, 303.0, 204.0", "equidistant", "0.1, 0.2, 0.3, 0.4",
             "kannala_brandt", "k1 0.1, k2 0.2, k3 0.3, k4 0.4"),
      kalibr("pinhole-fov", "pinhole", "501.0, 502.0, 303.0, 204.0", "fov", "0.9", "field_of_view", "w 0.9"),
      kalibr("omni-none", "omni", "1.5, 501.0, 502.0, 303.0, 204.0", "none", "", "unified",
             "xi 1.5, k1 0, k2 0, p1 0, p2 0"),
      kalibr("omni-radtan", "omni", "1.5, 501.0, 502.0, 303.0, 204.0", "radtan", "0.1, 0.2, 0.3, 0.4", "unified",
             "xi 1.5, k1 0.1, k2 0.2, p1 0.3, p2 0.4"),
      kalibr("eucm-none", "eucm", "0.6, 1.1, 501.0, 502.0, 303.0, 204.0", "none", "", "extended_unified",
             "alpha 0.6, beta 1.1"),
      kalibr("ds-none", "ds", "-0.2, 0.6, 501.0, 502.0, 303.0, 204.0", "none", "", "double_sphere",
             "xi -0.2, alpha 0.6"),

      mrcal("LENSMODEL_PINHOLE", "501, 502, 303, 204", "pinhole", ""),
      mrcal("LENSMODEL_OPENCV4", "501, 502, 303, 204, 0.1, 0.2, 0.3, 0.4", "brown_conrady",
            "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0"),
      mrcal("LENSMODEL_OPENCV5", "501, 502, 303, 204, 0.1, 0.2, 0.3, 0.4, 0.5", "brown_conrady",
            "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0.5"),
      mrcal("LENSMODEL_OPENCV8", "501, 502, 303, 204, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8", "rational",
            "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0.5, k4 0.6, k5 0.7, k6 0.8"),
      mrcal("LENSMODEL_OPENCV12", "501, 502, 303, 204, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.1, 1.2, 1.3",
            "thin_prism",
            "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0.5, k4 0.6, k5 0.7, k6 0.8, s1 0.9, s2 1.1, s3 1.2, s4 1.3"),

      colmap("SIMPLE_PINHOLE", "501 303.5 204.5", "pinhole", "", 501),
      colmap("PINHOLE", "501 502 303.5 204.5", "pinhole", ""),
      colmap("SIMPLE_RADIAL", "501 303.5 204.5 0.1", "brown_conrady", "k1 0.1, k2 0, p1 0, p2 0, k3 0", 501),
      colmap("RADIAL", "501 303.5 204.5 0.1 0.2", "brown_conrady", "k1 0.1, k2 0.2, p1 0, p2 0, k3 0", 501),
      colmap("OPENCV", "501 502 303.5 204.5 0.1 0.2 0.3 0.4", "brown_conrady", "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0"),
      colmap("FULL_OPENCV", "501 502 303.5 204.5 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8", "rational",
             "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0.5, k4 0.6, k5 0.7, k6 0.8"),
      colmap("SIMPLE_RADIAL_FISHEYE", "501 303.5 204.5 0.1", "kannala_brandt", "k1 0.1, k2 0, k3 0, k4 0", 501),
      colmap("RADIAL_FISHEYE", "501 303.5 204.5 0.1 0.2", "kannala_brandt", "k1 0.1, k2 0.2, k3 0, k4 0", 501),
      colmap("OPENCV_FISHEYE", "501 502 303.5 204.5 0.1 0.2 0.3 0.4", "kannala_brandt",
             "k1 0.1, k2 0.2, k3 0.3, k4 0.4"),
      colmap("FOV", "501 502 303.5 204.5 0.9", "field_of_view", "w 0.9"),
      colmap("EUCM", "501 502 303.5 204.5 0.6 1.1", "extended_unified", "alpha 0.6, beta 1.1"),

      basalt("pinhole", R"("fx": 501, "fy": 502, "cx": 303, "cy": 204)", "pinhole", ""),
      basalt("kb4", R"("k4": 0.4, "k3": 0.3, "k2": 0.2, "k1": 0.1, "fx": 501, "fy": 502, "cx": 303, "cy": 204)",
             "kannala_brandt", "k1 0.1, k2 0.2, k3 0.3, k4 0.4"),
      basalt("ds", R"("alpha": 0.6, "xi": -0.2, "fx": 501, "fy": 502, "cx": 303, "cy": 204)", "double_sphere",
             "xi -0.2, alpha 0.6"),
      basalt("eucm", R"("beta": 1.1, "alpha": 0.6, "fx": 501, "fy": 502, "cx": 303, "cy": 204)", "extended_unified",
             "alpha 0.6, beta 1.1"),
      basalt("ucm", R"("alpha": 0.6, "fx": 501, "fy": 502, "cx": 303, "cy": 204)", "extended_unified",
             "alpha 0.6, beta 1"),

      camodocal("PINHOLE",
                "distortion_parameters:\n   k1: 0.1\n   k2: 0.2\n   p1: 0.3\n   p2: 0.4\n"
                "projection_parameters:\n   fx: 501\n   fy: 502\n   cx: 303\n   cy: 204\n",
                "brown_conrady", "k1 0.1, k2 0.2, p1 0.3, p2 0.4, k3 0"),
      camodocal("KANNALA_BRANDT",
                "projection_parameters:\n   k2: 0.1\n   k3: 0.2\n   k4: 0.3\n   k5: 0.4\n"
                "   mu: 501\n   mv: 502\n   u0: 303\n   v0: 204\n",
                "kannala_brandt", "k1 0.1, k2 0.2, k3 0.3, k4 0.4"),
      camodocal("MEI",
                "mirror_parameters:\n   xi: 1.5\n"
                "distortion_parameters:\n   k1: 0.1\n   k2: 0.2\n   p1: 0.3\n   p2: 0.4\n"
                "projection_parameters:\n   gamma1: 501\n   gamma2: 502\n   u0: 303\n   v0: 204\n",
                "unified", "xi 1.5, k1 0.1, k2 0.2, p1 0.3, p2 0.4")};
  return all;
}

std::string shape_of(const Camera& camera) {
  const std::vector<std::string_view> names = parameter_names(camera.model);
  std::vector<std::string> shape;
  for (std::size_t i = 4; i < names.size(); ++i) {
    shape.push_back(fmt::format("{} {}", names[i], camera.parameters[static_cast<Eigen::Index>(i)]));
  }
  return fmt::format("{}", fmt::join(shape, ", "));
}

TEST(ForeignNumbers, MeanWhatTheProgramsDocument) {
  for (const Example& example : examples()) {
    SCOPED_TRACE(example.format + " " + example.lens);
    const std::vector<RigCamera> rig = read_as(example.format.c_str(), with_text(example.text));
    ASSERT_EQ(rig.size(), 1U);
    const Camera& camera = rig[0].camera;
    EXPECT_EQ(camera.parameters.head<4>(), Eigen::Vector4d(501, example.fy, 303, 204));
    EXPECT_EQ(model_name(camera.model), example.model);
    EXPECT_EQ(shape_of(camera), example.shape);
  }
}

TEST(ForeignNumbers, AreKnownOfEveryLens) {
  for (const ForeignFormat& format : foreign_formats()) {
    for (const ForeignLens& lens : format.lenses) {
      const auto is_of_it = [&](const Example& each) { return each.format == format.name && each.lens == lens.name; };
      EXPECT_TRUE(std::ranges::any_of(examples(), is_of_it)) << format.name << " " << lens.name;
    }
  }
}

}  // namespace
}  // namespace raybundle::testing
