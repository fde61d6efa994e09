// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "image_codec.hpp"

#include <spng.h>
#include <turbojpeg.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <new>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "media/media.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle::apps {
namespace {

constexpr std::string_view kJpeg = "\xff\xd8\xff";
constexpr std::string_view kPng = "\x89PNG\r\n\x1a\n";
constexpr std::uint64_t kMostPixels = 1u << 30;  // as OpenCV, which says what is wrong with larger ones

struct Release {
  void operator()(void* turbojpeg) const { tjDestroy(turbojpeg); }
  void operator()(spng_ctx* png) const { spng_ctx_free(png); }
  void operator()(unsigned char* of_turbojpeg) const { tjFree(of_turbojpeg); }
};
using Turbojpeg = std::unique_ptr<void, Release>;
using Png = std::unique_ptr<spng_ctx, Release>;

bool few_pixels(std::uint64_t width, std::uint64_t height) { return width * height <= kMostPixels; }

// Empty where turbojpeg has any doubt.
cv::Mat grey_of_jpeg(const std::string& bytes) {
  const auto* const data = reinterpret_cast<const unsigned char*>(bytes.data());
  const Turbojpeg decoder(tjInitDecompress());
  int width = 0, height = 0, subsampling = 0, colours = 0;
  if (tjDecompressHeader3(decoder.get(), data, bytes.size(), &width, &height, &subsampling, &colours) != 0) return {};
  if (colours == TJCS_CMYK || colours == TJCS_YCCK || !few_pixels(width, height)) return {};
  cv::Mat image(height, width, CV_8U);
  const int pitch = static_cast<int>(image.step);
  const bool decoded =
      tjDecompress2(decoder.get(), data, bytes.size(), image.data, width, pitch, height, TJPF_GRAY, 0) == 0;
  return decoded ? image : cv::Mat();
}

// Empty for other than grey values of 8 or 16 bits, and where spng has any doubt.
cv::Mat grey_of_png(const std::string& bytes) {
  const Png decoder(spng_ctx_new(0));
  if (spng_set_png_buffer(decoder.get(), bytes.data(), bytes.size()) != 0) return {};
  spng_ihdr header{};
  if (spng_get_ihdr(decoder.get(), &header) != 0 || header.color_type != SPNG_COLOR_TYPE_GRAYSCALE) return {};
  if (header.bit_depth < 8 || !few_pixels(header.width, header.height)) return {};
  cv::Mat image(static_cast<int>(header.height), static_cast<int>(header.width),
                header.bit_depth == 8 ? CV_8U : CV_16U);
  const bool decoded =
      spng_decode_image(decoder.get(), image.data, image.total() * image.elemSize(), SPNG_FMT_PNG, 0) == 0;
  return decoded ? image : cv::Mat();
}

}  // namespace

cv::Mat decoded_grey(const std::string& bytes) {
  cv::Mat image;
  if (bytes.starts_with(kJpeg)) image = grey_of_jpeg(bytes);
  if (bytes.starts_with(kPng)) image = grey_of_png(bytes);
  return image.empty() ? media().decode_grey(bytes) : image;
}

bool may_be_image(const std::string& path) {
  std::string head(kPng.size(), '\0');
  std::ifstream(path, std::ios::binary).read(head.data(), static_cast<std::streamsize>(head.size()));
  return head.starts_with(kJpeg) || head.starts_with(kPng) || media().may_be_image(path);
}

std::vector<unsigned char> png_from(const cv::Mat& image) {
  constexpr int kFast = 1;  // zlib's levels: smaller by a tenth takes several times as long
  cv::Mat pixels;           // row behind row; cvtColor() into the image itself would exchange the caller's colours
  if (image.channels() == 3) {
    cv::cvtColor(image, pixels, cv::COLOR_BGR2RGB);
  } else {
    pixels = image.isContinuous() ? image : image.clone();
  }
  const Png encoder(spng_ctx_new(SPNG_CTX_ENCODER));
  spng_ihdr header{};
  header.width = static_cast<std::uint32_t>(pixels.cols);
  header.height = static_cast<std::uint32_t>(pixels.rows);
  header.bit_depth = pixels.depth() == CV_16U ? 16 : 8;
  header.color_type = pixels.channels() == 3 ? SPNG_COLOR_TYPE_TRUECOLOR : SPNG_COLOR_TYPE_GRAYSCALE;
  spng_set_ihdr(encoder.get(), &header);
  spng_set_option(encoder.get(), SPNG_ENCODE_TO_BUFFER, 1);
  spng_set_option(encoder.get(), SPNG_IMG_COMPRESSION_LEVEL, kFast);
  spng_set_option(encoder.get(), SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_SUB);
  int error = spng_encode_image(encoder.get(), pixels.data, pixels.total() * pixels.elemSize(), SPNG_FMT_PNG,
                                SPNG_ENCODE_FINALIZE);
  std::size_t size = 0;
  const std::unique_ptr<void, decltype(&std::free)> bytes(
      error == 0 ? spng_get_png_buffer(encoder.get(), &size, &error) : nullptr, &std::free);
  if (error != 0) throw Error(ErrorKind::kIo, std::string("an image cannot be made a PNG: ") + spng_strerror(error));
  const auto* const begin = static_cast<const unsigned char*>(bytes.get());
  return {begin, begin + size};
}

std::vector<unsigned char> jpeg_from(const cv::Mat& image, int quality) {
  const bool grey = image.channels() == 1;
  const Turbojpeg encoder(tjInitCompress());
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int error = tjCompress2(encoder.get(), image.data, image.cols, static_cast<int>(image.step), image.rows,
                                grey ? TJPF_GRAY : TJPF_BGR, &bytes, &size, grey ? TJSAMP_GRAY : TJSAMP_420, quality,
                                TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, Release> owned(bytes);
  if (error != 0)
    throw Error(ErrorKind::kIo, std::string("an image cannot be made a JPEG: ") + tjGetErrorStr2(encoder.get()));
  return {bytes, bytes + size};
}

}  // namespace raybundle::apps
