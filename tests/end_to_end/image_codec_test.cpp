// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "image_codec.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "image_files.hpp"
#include "media/media.hpp"
#include "page_text.hpp"
#include "png_filters.hpp"
#include "previews.hpp"
#include "program.hpp"
#include "real_data.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;

std::string text_from(const std::vector<unsigned char>& bytes) { return {bytes.begin(), bytes.end()}; }

cv::Mat by_opencv(const std::string& bytes) {
  return cv::imdecode(std::vector<char>(bytes.begin(), bytes.end()), cv::IMREAD_UNCHANGED);
}

void expect_same(const cv::Mat& image, const cv::Mat& expected, const std::string& what) {
  ASSERT_EQ(image.size(), expected.size()) << what;
  ASSERT_EQ(image.type(), expected.type()) << what;
  EXPECT_EQ(cv::norm(image, expected, cv::NORM_INF), 0.0) << what;
}

// A smooth picture with noise on it, in which every grey value may stand.
cv::Mat picture(int type, double brightest) {
  cv::Mat image(61, 83, type);
  cv::theRNG().state = 7;
  cv::randu(image, cv::Scalar::all(0.0), cv::Scalar::all(brightest + 1.0));
  cv::GaussianBlur(image, image, {5, 5}, 1.0);
  return image;
}

TEST(ImageCodec, ReadsWhatOpencvReads) {
  const cv::Mat grey = picture(CV_8U, 255.0), deep = picture(CV_16U, 65535.0), coloured = picture(CV_8UC3, 255.0);
  std::vector<std::pair<std::string, std::vector<int>>> kinds{{".png", {}},
                                                              {".jpg", {cv::IMWRITE_JPEG_QUALITY, 60}},
                                                              {".jpg", {cv::IMWRITE_JPEG_PROGRESSIVE, 1}},
                                                              {".bmp", {}},
                                                              {".tif", {}},
                                                              {".webp", {}}};
  for (const auto& [ending, options] : kinds) {
    for (const cv::Mat* image : {&grey, &deep, &coloured}) {
      if (image->depth() == CV_16U && ending != ".png" && ending != ".tif") continue;
      std::vector<unsigned char> bytes;
      ASSERT_TRUE(cv::imencode(ending, *image, bytes, options));
      expect_same(apps::decoded_grey(text_from(bytes)), apps::media().decode_grey(text_from(bytes)), ending);
    }
  }
}

TEST(ImageCodec, ReadsRealImagesAsOpencvDoes) {
  int count = 0;
  for (const char* set : {"sourishg_fisheye_stereo", "camodocal_fisheye", "ocam", "aprilgrid_rs", "boofcv_mono",
                          "opencv_stereo_chess", "euroc_april"}) {
    const fs::path place = real_data(set);
    if (!fs::exists(place)) GTEST_SKIP() << "no real images in " << place;
    for (const auto& entry : fs::recursive_directory_iterator(place)) {
      const std::string ending = entry.path().extension();
      if (ending != ".jpg" && ending != ".png") continue;
      const std::string bytes = text_of(entry.path());
      expect_same(apps::decoded_grey(bytes), apps::media().decode_grey(bytes), entry.path());
      ++count;
    }
  }
  EXPECT_GT(count, 100);
}

// Section 9.2 of the PNG specification, as it stands there.
int predicted_by_png(int filter, int left, int above, int corner) {
  const int p = left + above - corner;
  const int from_left = std::abs(p - left), from_above = std::abs(p - above), from_corner = std::abs(p - corner);
  const int nearest = from_left <= from_above && from_left <= from_corner ? left
                      : from_above <= from_corner                         ? above
                                                                          : corner;
  return std::array{0, left, above, (left + above) / 2, nearest}.at(filter);
}

TEST(ImageCodec, UndoesEveryFilterOfPngsAtEverySize) {
  cv::RNG random(5);
  for (const int width : {1, 2, 7, 8, 9, 15, 40}) {
    for (const int height : {1, 3, 8, 21}) {
      std::vector<std::uint8_t> filtered;
      cv::Mat expected(height, width, CV_8U), image(height, width, CV_8U);
      for (int y = 0; y < height; ++y) {
        const int filter = random.uniform(0, 5);
        filtered.push_back(static_cast<std::uint8_t>(filter));
        const auto at = [&](int column, int row) -> int {
          return column < 0 || row < 0 ? 0 : static_cast<int>(expected.at<std::uint8_t>(row, column));
        };
        for (int x = 0; x < width; ++x) {
          filtered.push_back(static_cast<std::uint8_t>(random.uniform(0, 256)));
          const int predicted = predicted_by_png(filter, at(x - 1, y), at(x, y - 1), at(x - 1, y - 1));
          expected.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(filtered.back() + predicted);
        }
      }
      ASSERT_TRUE(apps::undo_png_filters(filtered.data(), image));
      expect_same(image, expected, std::to_string(width) + "x" + std::to_string(height));
      filtered[0] = 5;
      EXPECT_FALSE(apps::undo_png_filters(filtered.data(), image));
    }
  }
}

// A camera's JPEG holds a thumbnail, which ends before the image begins; some programs append to a PNG.
TEST(ImageCodec, KnowsWhatIsCutOff) {
  const cv::Mat image = picture(CV_8U, 255.0);
  const std::string jpeg = apps::jpeg_from(image), png = apps::png_from(image);
  const std::string thumbnail = "Exif\xff\xd9" + std::string(70, 'x'),
                    size{'\0', static_cast<char>(thumbnail.size() + 2)};
  const std::string photo = jpeg.substr(0, 2) + "\xff\xe1" + size + thumbnail + jpeg.substr(2);
  for (const std::string& whole : {jpeg, photo, png}) {
    EXPECT_FALSE(apps::is_cut_off(whole));
    EXPECT_FALSE(apps::is_cut_off(whole + std::string(500, '\0')));
    for (const std::size_t size_left : {whole.size() - 3, whole.size() / 2, std::size_t{12}, std::size_t{8}}) {
      EXPECT_TRUE(apps::is_cut_off(whole.substr(0, size_left))) << size_left;
    }
  }
  expect_same(apps::decoded_grey(photo), by_opencv(jpeg), "with a thumbnail");
}

TEST(ImageCodec, WritesPngsThatReadBackAsTheyWere) {
  for (const cv::Mat& image : {picture(CV_8U, 255.0), picture(CV_16U, 65535.0), picture(CV_8UC3, 255.0)}) {
    expect_same(by_opencv(apps::png_from(image)), image, "whole");
    const cv::Mat part = image(cv::Rect(3, 2, 40, 30));  // whose rows do not follow one another
    expect_same(by_opencv(apps::png_from(part)), part, "part");
  }
}

TEST(ImageCodec, WritesJpegsAsOpencvDoes) {
  for (const cv::Mat& image : {picture(CV_8U, 255.0), picture(CV_8UC3, 255.0)}) {
    std::vector<unsigned char> expected;
    cv::imencode(".jpg", image, expected, {cv::IMWRITE_JPEG_QUALITY, 80});
    expect_same(by_opencv(apps::jpeg_from(image, 80)), cv::imdecode(expected, cv::IMREAD_UNCHANGED), "jpeg");
  }
}

// JPEGs and PNGs that are cut or bent, of one bit or with a transparent colour: as OpenCV takes them.
TEST(ImageCodec, ReadsWhatIsDamagedOrRareAsOpencvDoes) {
  std::vector<unsigned char> png, jpeg, one_bit;
  cv::imencode(".png", picture(CV_8U, 255.0), png);
  cv::imencode(".jpg", picture(CV_8U, 255.0), jpeg);
  cv::imencode(".png", picture(CV_8U, 255.0), one_bit, {cv::IMWRITE_PNG_BILEVEL, 1});
  std::vector<std::string> files{text_from(one_bit)};
  for (const std::string& whole : {text_from(png), text_from(jpeg)}) {
    files.push_back(whole.substr(0, whole.size() / 2));
    for (std::size_t at = 20; at < whole.size(); at += whole.size() / 20) {
      files.push_back(whole);
      files.back()[at] = static_cast<char>(files.back()[at] ^ 0x10);
    }
  }
  for (std::size_t i = 0; i < files.size(); ++i) {
    cv::Mat expected;
    try {
      expected = apps::media().decode_grey(files[i]);
    } catch (const cv::Exception&) {
      EXPECT_THROW(apps::decoded_grey(files[i]), cv::Exception) << i;
      continue;
    }
    if (expected.empty()) {
      EXPECT_TRUE(apps::decoded_grey(files[i]).empty()) << i;
    } else {
      expect_same(apps::decoded_grey(files[i]), expected, std::to_string(i));
    }
  }
}

// What is wrong with an image is said in one sentence of ours, which names the file.
TEST(ImageCodec, LetsNoLibrarySpeakOfADamagedPng) {
  for (const int type : {CV_8U, CV_8UC3}) {
    std::vector<unsigned char> png;
    cv::imencode(".png", picture(type, 255.0), png);
    std::string damaged = text_from(png);
    damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 0x10);
    ::testing::internal::CaptureStderr();
    EXPECT_TRUE(apps::decoded_grey(damaged).empty());
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  }
}

// OpenCV's decoder of DICOM aborts at this one.
TEST(ImageCodec, RefusesDicomWithTheWayOut) {
  const fs::path file = fresh_folder() / "scan.png";
  write_text(file, std::string(128, '\0') + "DICM\x02\x02\x02");
  EXPECT_FALSE(apps::may_be_image(file));
  std::string reason;
  EXPECT_TRUE(apps::read_gray(file, reason).empty());
  EXPECT_THAT(reason, ::testing::HasSubstr("convert it to PNG"));
}

TEST(Pictures, OfDeepImagesShowWhatTheyShow) {
  const fs::path file = fresh_folder() / "deep.png";
  cv::imwrite(file.string(), cv::Mat(60, 80, CV_16U, cv::Scalar(512)));  // the middle of ten bits
  CalibrationProblem problem;
  problem.cameras.resize(1);
  problem.cameras[0].name = "camera";
  problem.cameras[0].size = {80, 60};
  problem.frames = {"0"};
  problem.views.resize(1);
  problem.views[0].image = file.string();
  CalibrationResult result;
  result.calibration.cameras.resize(1);
  result.calibration.cameras[0].name = "camera";
  result.calibration.cameras[0].camera.size = {80, 60};
  result.views.resize(1);
  const auto pictures = nlohmann::json::parse(apps::pictures_section(problem, result, 2).json);
  ASSERT_EQ(pictures.size(), 1U);
  EXPECT_THAT(pictures[0]["jpeg"], apps::base64(apps::jpeg_from(cv::Mat(60, 80, CV_8U, cv::Scalar(128)), 72)));
}

TEST(ImageCodec, KnowsImagesByWhatTheyHold) {
  const fs::path folder = fresh_folder();
  cv::imwrite((folder / "a.png").string(), picture(CV_8U, 255.0));
  cv::imwrite((folder / "a.bmp").string(), picture(CV_8U, 255.0));
  fs::rename(folder / "a.png", folder / "a.txt");
  write_text(folder / "b.png", "not an image");
  EXPECT_TRUE(apps::may_be_image(folder / "a.txt"));
  EXPECT_TRUE(apps::may_be_image(folder / "a.bmp"));
  EXPECT_FALSE(apps::may_be_image(folder / "b.png"));
}

}  // namespace
}  // namespace raybundle::testing
