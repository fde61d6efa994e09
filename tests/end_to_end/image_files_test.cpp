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

// Cameras of 10 and 12 bits fill the lower ones; what belongs together is scaled alike.
TEST(ReadsImages, OfMoreThan8BitsByTheBrightestPixelSoFar) {
  apps::EightBits bits;
  const auto scaled = [&bits](int left, int right) {
    cv::Mat a(1, 1, CV_16U, cv::Scalar(left)), b(1, 1, CV_16U, cv::Scalar(right)), none;
    bits.take({&a, &b, &none});
    return std::vector<int>{a.at<std::uint8_t>(0), b.at<std::uint8_t>(0)};
  };
  EXPECT_THAT(scaled(1023, 0), ElementsAre(255, 0));
  EXPECT_THAT(scaled(4095, 819), ElementsAre(255, 51));
  EXPECT_THAT(scaled(13107, 65535), ElementsAre(51, 255));
  EXPECT_THAT(scaled(1023, 257), ElementsAre(4, 1));  // darker, not of fewer bits
}

std::string little_endian(std::uint32_t value, int size) {
  std::string bytes;
  for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> 8 * i & 0xFF);
  return bytes;
}

// Three columns and two rows of grey values, without compression. Source: TIFF revision 6.0, section 4.
std::string tiff_of(const std::string& pixels, std::uint32_t orientation) {
  constexpr std::uint32_t kShort = 3, kLong = 4, kPixelsAt = 8 + 2 + 10 * 12 + 4;
  std::string text = "II*" + std::string(1, '\0') + little_endian(8, 4) + little_endian(10, 2);
  const auto entry = [&](std::uint32_t tag, std::uint32_t type, std::uint32_t value) {
    text += little_endian(tag, 2) + little_endian(type, 2) + little_endian(1, 4) + little_endian(value, 4);
  };
  entry(256, kShort, 3);         // width
  entry(257, kShort, 2);         // height
  entry(258, kShort, 8);         // bits
  entry(259, kShort, 1);         // not compressed
  entry(262, kShort, 1);         // black is zero
  entry(273, kLong, kPixelsAt);  // the strip
  entry(274, kShort, orientation);
  entry(277, kShort, 1);  // samples of a pixel
  entry(278, kShort, 2);  // rows of the strip
  entry(279, kLong, 6);   // its bytes
  return text + little_endian(0, 4) + pixels;
}

// A lens does not turn with the camera. OpenCV turns TIFFs even when it is asked not to.
TEST(ReadsImages, AsTheyAreStoredWhateverTheirOrientation) {
  const fs::path file = fresh_folder() / "left1.tif";
  for (std::uint32_t orientation = 1; orientation <= 8; ++orientation) {
    write_text(file, tiff_of("abcdef", orientation));
    const cv::Mat_<int> read = apps::read_gray(file.string());
    ASSERT_EQ(read.size(), cv::Size(3, 2)) << orientation;
    EXPECT_THAT(std::vector<int>(read.begin(), read.end()), ElementsAre('a', 'b', 'c', 'd', 'e', 'f')) << orientation;
  }
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
  const std::string calibration = (folder / "out" / "calibration.json").string();
  const ProgramRun run =
      with_images({"calibrate", "--model", "brown_conrady", "--fix", "right.k3=0", "-o", (folder / "out").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("right01.jpg: the image file is truncated"));
  EXPECT_THAT(text_of(calibration), Not(HasSubstr("\"right\"")));
  // But nobody is to take it for checked.
  const std::string both = (folder / "both").string();
  ASSERT_EQ(raybundle_program({"calibrate", "--target", "chessboard:9x6:25mm", "--camera", images[5], "--camera",
                               "right=" + (real_data("opencv_stereo_chess") / "right*.jpg").string(), "--model",
                               "brown_conrady", "-o", both})
                .exit_code,
            0);
  const ProgramRun checked = with_images({"validate", both + "/calibration.json"});
  EXPECT_EQ(checked.exit_code, 1) << checked.err;
  EXPECT_THAT(checked.out, HasSubstr("FAIL  right"));
  // What was seen goes through a file as well.
  const std::string observations = (folder / "observations.json").string();
  EXPECT_EQ(with_images({"detect", "-o", observations}).exit_code, 0);
  const ProgramRun again = raybundle_program(
      {"calibrate", "--observations", observations, "--model", "brown_conrady", "-o", (folder / "again").string()});
  EXPECT_EQ(again.exit_code, 0) << again.err;
}

}  // namespace
}  // namespace raybundle::testing
