// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "image_files.hpp"

#include <gmock/gmock.h>

#include <array>
#include <opencv2/imgcodecs.hpp>

#include "program.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// A PNG of a few bytes whose header asks for 60000 x 60000 pixels, which OpenCV answers with an exception.
TEST(ReadsImages, AndSaysWhyAHeaderOfTooManyPixelsIsNone) {
  constexpr std::array<unsigned char, 74> kBytes{
      0x89, 'P',  'N',  'G',  0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 'I',  'H',  'D',  'R',  0x00, 0x00, 0xea,
      0x60, 0x00, 0x00, 0xea, 0x60, 0x08, 0x00, 0x00, 0x00, 0x00, 0xa5, 0xb9, 0x2a, 0x9e, 0x00, 0x00, 0x00, 0x11, 'I',
      'D',  'A',  'T',  0x78, 0x9c, 0x63, 0x60, 0x18, 0x05, 0xa3, 0x60, 0x14, 0x0c, 0x77, 0x00, 0x00, 0x03, 0xe8, 0x00,
      0x01, 0xb3, 0xa6, 0xd3, 0x46, 0x00, 0x00, 0x00, 0x00, 'I',  'E',  'N',  'D',  0xae, 0x42, 0x60, 0x82};
  const fs::path file = fresh_folder() / "left28.png";
  write_text(file, {kBytes.begin(), kBytes.end()});
  std::string reason;
  EXPECT_TRUE(apps::read_gray(file.string(), reason).empty());
  EXPECT_EQ(reason, "the image file is damaged, or too large to be read");
}

TEST(ReadsImages, OfFloatingPoint) {
  const std::string file = (fresh_folder() / "left1.tiff").string();
  const auto read_of = [&](float black, float grey, float white) {
    const cv::Mat_<float> image = (cv::Mat_<float>(1, 3) << black, grey, white);
    cv::imwrite(file, image);
    const cv::Mat_<int> read = apps::read_gray(file);
    return std::vector<int>(read.begin(), read.end());
  };
  EXPECT_THAT(read_of(0.0F, 0.4F, 1.0F), ElementsAre(0, 102, 255));
  EXPECT_THAT(read_of(0.0F, 102.0F, 255.0F), ElementsAre(0, 102, 255));
  EXPECT_THAT(read_of(0.0F, 1020.0F, 4095.0F), ElementsAre(0, 1020, 4095));
}

// Brackets, braces and stars are characters of names, too.
TEST(FindsImages, WhosePathsLookLikePatterns) {
  const fs::path folder = fresh_folder() / "na me [1] {a,b} ü";
  fs::create_directories(folder);
  for (const char* name : {"left[01].jpg", "left[02].jpg"}) write_text(folder / name, "");
  const auto found = [&](const char* name) { return apps::matching_files(folder.string(), {name}); };
  EXPECT_THAT(found("left[02].jpg"), ElementsAre((folder / "left[02].jpg").string()));
  EXPECT_EQ(found("left*.jpg").size(), 2U);
  EXPECT_EQ(found("{left,right}?0[12]?.jpg").size(), 2U);
}

TEST(FindsImages, AndNamesALinkToNothing) {
  const fs::path folder = fresh_folder();
  write_text(folder / "left1.jpg", "");
  fs::create_symlink(folder / "nowhere", folder / "left2.jpg");
  ::testing::internal::CaptureStderr();
  EXPECT_THAT(apps::matching_files(folder.string(), {"left*"}), ElementsAre((folder / "left1.jpg").string()));
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("left2.jpg is left out: it links to a file"));
}

TEST(FindsImages, AndNamesAFolderThatIsCalledAsAnImage) {
  const fs::path folder = fresh_folder();
  write_text(folder / "left1.jpg", "");
  fs::create_directories(folder / "left2.jpg");
  fs::create_directories(folder / "left_old");
  ::testing::internal::CaptureStderr();
  EXPECT_THAT(apps::matching_files(folder.string(), {"left*"}), ElementsAre((folder / "left1.jpg").string()));
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, HasSubstr("left2.jpg is left out: it is a folder"));
  EXPECT_THAT(said, ::testing::Not(HasSubstr("left_old")));
}

TEST(FindsImages, OfAFolderAsAPatternInIt) {
  const std::string folder = fresh_folder().string();
  for (const std::string& written : {folder, folder + "/"}) {
    try {
      apps::matching_files("", {written});
      ADD_FAILURE() << written << " was taken";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("as in '" + folder + "/*.jpg'"));
    }
  }
}

TEST(ACameraWithoutAReadableImage, DoesNotCostTheOthersTheirs) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  const fs::path folder = fresh_folder();
  const std::string whole = text_of(real_data("opencv_stereo_chess") / "right01.jpg");
  write_text(folder / "right01.jpg", whole.substr(0, whole.size() / 3));
  const std::vector<std::string> images{
      "--target", "chessboard:9x6:25mm",
      "--camera", "right=" + (folder / "right*.jpg").string(),
      "--camera", "left=" + (real_data("opencv_stereo_chess") / "left*.jpg").string()};
  const auto with_images = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), images.begin(), images.end());
    return raybundle_program(arguments);
  };
  const ProgramRun run = with_images({"calibrate", "--model", "brown_conrady", "-o", (folder / "out").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("camera right is left out: none of its images can be used"));
  const std::string calibration = (folder / "out" / "calibration.json").string();
  EXPECT_THAT(text_of(calibration), Not(HasSubstr("\"right\"")));
  // But nobody is to take it for checked.
  const ProgramRun checked = with_images({"validate", calibration});
  EXPECT_NE(checked.exit_code, 0);
  EXPECT_THAT(checked.err, HasSubstr("camera right"));
}

}  // namespace
}  // namespace raybundle::testing
