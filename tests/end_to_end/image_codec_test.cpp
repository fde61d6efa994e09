// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "image_codec.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "media/media.hpp"
#include "program.hpp"
#include "real_data.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string text_of(const std::vector<unsigned char>& bytes) { return {bytes.begin(), bytes.end()}; }

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
      expect_same(apps::decoded_grey(text_of(bytes)), apps::media().decode_grey(text_of(bytes)), ending);
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
      const std::string bytes = bytes_of(entry.path());
      expect_same(apps::decoded_grey(bytes), apps::media().decode_grey(bytes), entry.path());
      ++count;
    }
  }
  EXPECT_GT(count, 100);
}

TEST(ImageCodec, WritesPngsThatReadBackAsTheyWere) {
  for (const cv::Mat& image : {picture(CV_8U, 255.0), picture(CV_16U, 65535.0), picture(CV_8UC3, 255.0)}) {
    expect_same(cv::imdecode(apps::png_from(image), cv::IMREAD_UNCHANGED), image, "whole");
    const cv::Mat part = image(cv::Rect(3, 2, 40, 30));  // whose rows do not follow one another
    expect_same(cv::imdecode(apps::png_from(part), cv::IMREAD_UNCHANGED), part, "part");
  }
}

TEST(ImageCodec, WritesJpegsAsOpencvDoes) {
  for (const cv::Mat& image : {picture(CV_8U, 255.0), picture(CV_8UC3, 255.0)}) {
    std::vector<unsigned char> expected;
    cv::imencode(".jpg", image, expected, {cv::IMWRITE_JPEG_QUALITY, 80});
    expect_same(cv::imdecode(apps::jpeg_from(image, 80), cv::IMREAD_UNCHANGED),
                cv::imdecode(expected, cv::IMREAD_UNCHANGED), "jpeg");
  }
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
