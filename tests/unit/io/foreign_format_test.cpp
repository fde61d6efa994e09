// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/foreign_format.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "foreign_examples.hpp"
#include "raybundle/geometry/rotation.hpp"

namespace raybundle::testing {
namespace {

using ::testing::HasSubstr;

class ForeignFormats : public ::testing::TestWithParam<ForeignFormat> {};

INSTANTIATE_TEST_SUITE_P(All, ForeignFormats, ::testing::ValuesIn(foreign_formats().begin(), foreign_formats().end()),
                         [](const auto& info) { return std::string(info.param.name); });

// Cameras that the format can hold, in the frame of the first of them.
std::vector<RigCamera> rig_for(const ForeignFormat& format) {
  std::vector<RigCamera> rig;
  for (const RigCamera& camera : camera_of_every_example()) {
    for (const ForeignLens& lens : format.lenses) {
      if (lens.model != camera.camera.model) continue;
      RigCamera held = camera;
      held.name += "_" + std::to_string(rig.size());
      const Camera start = start_camera(lens.model, held.camera.size, 1.0);
      for (const int i : parameters_without_place(lens)) held.camera.parameters[i] = start.parameters[i];
      if (lens.places.starts_with("f ")) held.camera.parameters[1] = held.camera.parameters[0];
      if (!holds(format, lens, held.camera)) continue;  // what the program itself refuses
      if (!rig.empty()) held.camera_from_rig = camera.camera_from_rig * rig[0].camera_from_rig.inverse();
      rig.push_back(held);
    }
  }
  rig[0].camera_from_rig = {};
  return rig;
}

TEST_P(ForeignFormats, BringBackEveryLensBitByBit) {
  const ForeignFormat& format = GetParam();
  for (const RigCamera& camera : rig_for(format)) {
    for (const ForeignLens& lens : format.lenses) {
      if (!holds(format, lens, camera.camera)) continue;
      SCOPED_TRACE(camera.name + " as " + std::string(lens.name));
      const std::vector<NamedText> files = texts_from_rig(format, {{camera, &lens}});
      const std::vector<RigCamera> back = rig_from_texts(format, files);
      ASSERT_EQ(back.size(), 1U);
      if (lens.places.find('0') == std::string_view::npos) {  // else it comes back as one of a wider family
        EXPECT_EQ(back[0].camera.model, camera.camera.model);
      }
      EXPECT_EQ(back[0].camera.size, camera.camera.size);
      const Eigen::Vector3d ray(0.3, -0.2, 1.0);
      const auto expected = pixel_from_ray(camera.camera, ray), found = pixel_from_ray(back[0].camera, ray);
      ASSERT_TRUE(expected && found);
      // Only COLMAP's half pixel, which is added and taken away, may cost a bit.
      EXPECT_LE((*found - *expected).norm(), format.name == "colmap" ? 1e-12 : 0.0) << files[0].text;
    }
  }
}

// Not only in the order of the alphabet, in which a folder is read.
TEST_P(ForeignFormats, BringBackThePlacesOfARig) {
  const ForeignFormat& format = GetParam();
  if (!format.holds_extrinsics) GTEST_SKIP() << format.name << " does not hold places";
  std::vector<RigCamera> rig = rig_for(format);
  for (std::size_t i = 0; i < rig.size(); ++i) rig[i].name = "z" + std::to_string(rig.size() - i);
  std::vector<NamedText> files = texts_of(format, rig);
  // These say which of them is the first; of the others the first file is.
  if (format.name == "camodocal" || format.name == "colmap") std::ranges::sort(files, {}, &NamedText::name);
  const std::vector<RigCamera> back = rig_from_texts(format, files);
  ASSERT_EQ(back.size(), rig.size());
  for (std::size_t i = 0; i < rig.size(); ++i) {
    if (format.name != "basalt") {
      EXPECT_EQ(back[i].name, rig[i].name);
    }
    EXPECT_LE(motion_between(rig[i].camera_from_rig, back[i].camera_from_rig).norm(), 1e-13) << rig[i].name;
  }
}

TEST_P(ForeignFormats, MeasureFromTheFirstCameraWhateverTheRigFrameIs) {
  const ForeignFormat& format = GetParam();
  if (!format.holds_extrinsics) GTEST_SKIP() << format.name << " does not hold places";
  std::vector<RigCamera> rig = rig_for(format);
  const std::vector<RigCamera> before = rig;
  for (RigCamera& camera : rig) camera.camera_from_rig = camera.camera_from_rig * awkward_rigid3(2.0);
  const std::vector<RigCamera> back = rig_from_texts(format, texts_of(format, rig));
  for (std::size_t i = 0; i < rig.size(); ++i) {
    EXPECT_LE(motion_between(before[i].camera_from_rig, back[i].camera_from_rig).norm(), 1e-13) << rig[i].name;
  }
}

TEST_P(ForeignFormats, HaveTheLensesThatModelsSayTheyAreCalledThere) {
  const ForeignFormat& format = GetParam();
  for (const std::string_view name : model_names()) {
    for (const ForeignName& foreign : foreign_names(*model_named(name))) {
      if (foreign.format.substr(0, foreign.format.find('_')) != format.name) continue;
      const auto is_it = [&](const ForeignLens& lens) {
        return lens.model == *model_named(name) && lens.name == foreign.name;
      };
      EXPECT_TRUE(std::ranges::any_of(format.lenses, is_it)) << name << " is " << foreign.name << " in " << format.name;
    }
  }
}

TEST_P(ForeignFormats, AreToldByWhatTheyWrite) {
  const ForeignFormat& format = GetParam();
  for (const NamedText& file : texts_of(format, rig_for(format))) {
    if (file.name.ends_with(".urdf")) continue;
    for (const ForeignFormat& other : foreign_formats()) {
      EXPECT_EQ(other.recognises(file.text), other.name == format.name) << file.name << " taken for " << other.name;
    }
  }
}

TEST_P(ForeignFormats, SayWhatIsWrongWithATextThatIsCutOff) {
  const ForeignFormat& format = GetParam();
  std::vector<NamedText> files = texts_of(format, {rig_for(format)[0]});
  const std::string whole = files[0].text;
  std::size_t refused = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    files[0].text = whole.substr(0, size);
    try {
      rig_from_texts(format, files);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kBadInput) << error.what();
      EXPECT_THAT(error.what(), HasSubstr(files[0].name));
      ++refused;
    }
  }
  EXPECT_GT(refused, whole.size() / 2);
}

TEST_P(ForeignFormats, RefuseALensThatTheyDoNotHave) {
  const ForeignFormat& format = GetParam();
  for (const RigCamera& camera : camera_of_every_example()) {
    if (lens_for(format, camera.camera) != nullptr) continue;
    EXPECT_THAT(message_of([&] { texts_of(format, {camera}); }), HasSubstr(camera.name));
  }
}

TEST(ForeignRig, GetsNumbersForNamesThatAreTheSame) {
  const Camera camera = start_camera(*model_named("pinhole"), {640, 480}, 800.0);
  std::vector<NamedText> files = texts_of(*foreign_format_named("opencv"), {{"left", camera, {}}});
  files.push_back(files[0]);
  const std::vector<RigCamera> rig = read_as("opencv", files);
  EXPECT_EQ(rig[0].name, "cam0");
  EXPECT_EQ(rig[1].name, "cam1");
}

TEST(ForeignRig, OfNoCameraIsRefused) {
  const std::string empty = R"({"value0": {"T_imu_cam": [], "intrinsics": [], "resolution": []}})";
  EXPECT_THAT(message_of([&] { read_as("basalt", with_text(empty)); }), HasSubstr("has no camera"));
}

TEST(ForeignRig, DoesNotWriteTwoCamerasIntoOneFile) {
  const Camera camera = start_camera(*model_named("pinhole"), {640, 480}, 800.0);
  for (const ForeignFormat& format : foreign_formats()) {
    if (!format.file.empty() || format.name == "colmap") continue;
    const std::vector<RigCamera> rig{{"a/b", camera, {}}, {"a_b", camera, awkward_rigid3(1)}};
    EXPECT_THAT(message_of([&] { texts_of(format, rig); }), HasSubstr("two files would be called")) << format.name;
  }
}

TEST(ForeignYaml, RefusesKeysThatStandTwiceAndAliasesWithoutEnd) {
  const std::string good = texts_of(*foreign_format_named("kalibr"),
                                    {{"left", start_camera(*model_named("pinhole"), {640, 480}, 300.0), {}}})[0]
                               .text;
  EXPECT_THAT(message_of([&] { read_as("kalibr", with_text(good + "  resolution: [1, 1]\n")); }),
              HasSubstr("stands twice"));
  EXPECT_THAT(message_of([&] { read_as("mrcal", with_text("4, 0.0]\n{\n 'lensmodel': 'LENSMODEL_OPENCV8',\n")); }),
              HasSubstr("file"));  // and it ends
  std::string bomb = "cam0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 9; ++i) {
    bomb += fmt::format("k{0}: &a{0} [*a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}]\n", i, i - 1);
  }
  EXPECT_THAT(message_of([&] { read_as("kalibr", with_text(bomb)); }), HasSubstr("too many values"));
}

}  // namespace
}  // namespace raybundle::testing
