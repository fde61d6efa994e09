// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "image_files.hpp"

#include <fmt/format.h>
#include <glob.h>
#include <malloc.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string_view>

#include "image_codec.hpp"
#include "media/media.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/io/frame_names.hpp"
#include "terminal.hpp"
#include "tiff_orientation.hpp"

namespace raybundle::apps {
namespace {

// Of a pattern in a folder that is there, the folder is no pattern, whatever characters its name has.
std::string with_literal_folder(const std::string& pattern) {
  const std::filesystem::path path(pattern);
  std::error_code ignored;
  if (!std::filesystem::is_directory(path.parent_path(), ignored)) return pattern;
  std::string folder;
  for (const char c : path.parent_path().string()) {
    if (std::strchr("*?[]{},\\", c) != nullptr) folder += '\\';
    folder += c;
  }
  return (std::filesystem::path(folder) / path.filename()).string();
}

std::vector<std::string> glob_files(const std::string& pattern) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(pattern, ignored)) return {pattern};
  glob_t found{};
  std::vector<std::string> files;
  if (glob(with_literal_folder(pattern).c_str(), GLOB_TILDE | GLOB_BRACE, nullptr, &found) == 0) {
    for (std::size_t i = 0; i < found.gl_pathc; ++i) {
      const std::string path = found.gl_pathv[i];
      if (std::filesystem::is_regular_file(path, ignored)) files.push_back(path);
      if (!std::filesystem::exists(path, ignored))
        say_warning(path + " is left out: it links to a file that is not there");
      // Patterns as wide as left* take in folders as a matter of course, but not what is called as an image is.
      if (is_image(path) && std::filesystem::is_directory(path, ignored))
        say_warning(path + " is left out: it is a folder");
    }
  }
  globfree(&found);
  return files;
}

[[noreturn]] void refuse_empty(const std::string& pattern) {
  const std::filesystem::path folder = std::filesystem::path(pattern).parent_path();
  const std::string shown = folder.empty() ? "." : folder.string();
  std::error_code ignored;
  if (std::filesystem::is_directory(pattern, ignored)) {
    throw Error(ErrorKind::kIo, fmt::format("no image matches '{}': it is a folder; say which images in it, as in "
                                            "'{}'",
                                            pattern, (std::filesystem::path(pattern) / "*.jpg").string()));
  }
  if (pattern.find('\\') != std::string::npos) {
    throw Error(ErrorKind::kIo, "no image matches '" + pattern + "': write / for \\ in paths");
  }
  if (!std::filesystem::is_directory(shown, ignored)) {
    throw Error(ErrorKind::kIo, "no image matches '" + pattern + "': there is no folder " + shown);
  }
  std::string some;
  int count = 0;
  std::error_code failed;
  for (const auto& entry : std::filesystem::directory_iterator(shown, failed)) {
    if (entry.is_regular_file(ignored) && ++count <= 3)
      some += (some.empty() ? "" : ", ") + entry.path().filename().string();
  }
  if (failed) {
    throw Error(ErrorKind::kIo, fmt::format("no image matches '{}': the folder {} cannot be read: {}", pattern, shown,
                                            failed.message()));
  }
  throw Error(ErrorKind::kIo, fmt::format("no image matches '{}'; the folder holds {}", pattern,
                                          count == 0 ? "no files" : fmt::format("{} files such as {}", count, some)));
}

// Nothing when the file cannot be read.
std::optional<std::string> bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return std::nullopt;
  std::string bytes(static_cast<std::size_t>(std::max<std::streamoff>(0, file.tellg())), '\0');
  file.seekg(0);
  if (!file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) return std::nullopt;
  return bytes;
}

// OpenCV throws at some damaged files and says of others that they are empty; only lack of memory is no fault of
// theirs.
cv::Mat decoded(const std::string& bytes, std::string& reason) try {
  cv::Mat image;
  if (!bytes.empty() && bytes.size() <= std::numeric_limits<int>::max()) {
    image = decoded_grey(bytes);
  }
  if (image.empty()) reason = "not an image that can be decoded";
  return as_stored(bytes, image);
} catch (const cv::Exception& error) {
  if (error.code == cv::Error::StsNoMem) throw;
  reason = "the image file is damaged, or too large to be read";
  return {};
} catch (const Error& error) {  // costs the files that need OpenCV's readers, and no other ones
  reason = error.what();
  return {};
}

// What one image gives back the next one takes. Otherwise the C library hands it to the system and asks for it again,
// page by page, which costs as much as a tenth of finding a board.
void keep_freed_memory() {
  constexpr int kLargeBlock = 64 << 20, kSpare = 256 << 20;  // [bytes]
  mallopt(M_MMAP_THRESHOLD, kLargeBlock);
  mallopt(M_TRIM_THRESHOLD, kSpare);
}

// The same grey values in 8 or 16 bits; those of floating point may run to 1, as is the custom, or to what integers do.
cv::Mat in_whole_numbers(const cv::Mat& image) {
  if (image.depth() == CV_8U || image.depth() == CV_16U) return image;
  double most = 0.0;
  cv::minMaxLoc(image, nullptr, &most);
  const bool to_one = most <= 1.0 && image.depth() >= CV_32F;
  cv::Mat whole;
  image.convertTo(whole, most > 255.0 ? CV_16U : CV_8U, to_one ? 255.0 : 1.0);
  return whole;
}

bool ends_with_one_of(std::initializer_list<const char*> endings, const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::ranges::find(endings, ending) != endings.end();
}

bool may_be_read(const std::string& path) { return is_video(path) || may_be_image(path); }

// A file that is no image, as a list of lenses beside them, has no number and must not cost the images theirs: it keeps
// its whole name, and whoever reads it says why it is left out.
std::vector<ImageFile> files_of_camera(int camera, const std::vector<std::string>& paths) {
  std::vector<std::string> readable;
  std::ranges::copy_if(paths, std::back_inserter(readable), may_be_read);
  const std::vector<std::string> names = frame_names(readable);
  std::map<std::string, std::string> path_of_frame;
  std::vector<ImageFile> files;
  std::size_t next = 0;  // of the readable ones
  for (const std::string& path : paths) {
    if (next == readable.size() || path != readable[next]) {
      files.push_back({camera, path, std::filesystem::path(path).filename().string(), false});
      continue;
    }
    const std::string& name = names[next++];
    const bool video = is_video(path);
    if (video && paths.size() > 1) {
      throw Error(ErrorKind::kBadInput,
                  fmt::format("is a video among {} files of one camera, which has one video or images", paths.size()),
                  path);
    }
    const auto [before, is_new] = path_of_frame.insert({name, path});
    if (!is_new) {
      throw Error(ErrorKind::kBadInput, fmt::format("{} and {} would both be frame {}; narrow the image pattern",
                                                    before->second, path, name));
    }
    files.push_back({camera, path, video ? "" : name, video});
  }
  return files;
}

}  // namespace

bool is_image(const std::string& path) {
  return ends_with_one_of({".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".bmp", ".tif", ".tiff", ".webp"}, path);
}

bool is_video(const std::string& path) { return ends_with_one_of({".mp4", ".avi", ".mkv", ".mov", ".webm"}, path); }

bool may_be_image(const std::string& path) {
  std::string head(kLongestSignature, '\0');
  std::ifstream(path, std::ios::binary).read(head.data(), kLongestSignature);
  if (is_jpeg(head) || is_png(head)) return true;
  if (is_dicom(head)) return false;
  try {
    return media().may_be_image(path);
  } catch (const Error&) {  // reading it will say so
    return is_image(path);
  }
}

void sort_by_number(std::vector<std::string>& files) {
  std::ranges::sort(files, [](const std::string& a, const std::string& b) {
    const int order = strverscmp(a.c_str(), b.c_str());
    return order != 0 ? order < 0 : a < b;
  });
}

std::vector<std::string> matching_files(const std::string& folder, const std::vector<std::string>& patterns) {
  std::vector<std::string> files;
  for (const std::string& pattern : patterns) {
    const std::string whole = (std::filesystem::path(folder) / pattern).string();
    const std::vector<std::string> found = glob_files(whole);
    if (found.empty()) refuse_empty(whole);
    files.insert(files.end(), found.begin(), found.end());
  }
  sort_by_number(files);
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

std::vector<ImageFile> image_files(int camera, const std::string& folder, const std::vector<std::string>& patterns) {
  return files_of_camera(camera, matching_files(folder, patterns));
}

std::vector<ImageFile> images_in_folder(int camera, const std::string& folder) {
  std::vector<std::string> paths = glob_files((std::filesystem::path(folder) / "*").string());
  std::erase_if(paths, [](const std::string& path) { return !is_image(path) && !is_video(path); });
  if (paths.empty()) throw Error(ErrorKind::kIo, "holds no images and no video", folder);
  sort_by_number(paths);
  return files_of_camera(camera, paths);
}

void warn_of_other_moment(const std::string& a, const std::string& b) {
  if (!numbered_apart(a, b)) return;
  say_warning(
      fmt::format("{} and {} are taken for one moment, as they were named together, but their numbers differ; "
                  "are they a pair?",
                  a, b));
}

void refuse_shared_images(const std::vector<ImageFile>& files, const std::vector<std::string>& cameras) {
  std::map<std::string, int> camera_of;
  for (const ImageFile& file : files) {
    const int other = camera_of.emplace(file.path, file.camera).first->second;
    if (other == file.camera) continue;
    throw Error(ErrorKind::kBadInput,
                fmt::format("is given to camera {} and to camera {}; narrow the pattern of one", cameras[other],
                            cameras[file.camera]),
                file.path);
  }
}

cv::Mat read_gray(const std::string& path, std::string& reason) {
  std::optional<std::string> bytes = bytes_of(path);
  if (!bytes) {
    reason = "the image file cannot be read; check its permissions";
    return {};
  }
  if (is_cut_off(*bytes)) {
    reason = "the image file is truncated";
    return {};
  }
  cv::Mat image = decoded(*bytes, reason);
  return image.empty() ? image : in_whole_numbers(image);
}

cv::Mat read_gray(const std::string& path) {
  std::string reason;
  cv::Mat image = read_gray(path, reason);
  if (image.empty()) throw Error(ErrorKind::kIo, reason, path);
  return image;
}

void EightBits::take(std::initializer_list<cv::Mat*> images) {
  for (const cv::Mat* image : images) {
    if (image->empty() || image->depth() == CV_8U) continue;
    double most = 0.0;
    cv::minMaxLoc(*image, nullptr, &most);
    brightest_ = std::max(brightest_, most);
  }
  const double full = brightest_ < 1024.0 ? 1023.0 : brightest_ < 4096.0 ? 4095.0 : 65535.0;
  for (cv::Mat* image : images) {
    if (!image->empty() && image->depth() != CV_8U) image->convertTo(*image, CV_8U, 255.0 / full);
  }
}

std::string for_each_frame(const ImageFile& file,
                           const std::function<void(const cv::Mat& gray, const std::string& frame)>& use) {
  std::string reason;
  if (!file.video) {
    const cv::Mat gray = read_gray(file.path, reason);
    if (!gray.empty()) use(gray, file.frame);
    return reason;
  }
  const std::unique_ptr<VideoReader> video = media().open_video(file.path);
  int count = 0;
  for (cv::Mat grey = video->next(); !grey.empty(); grey = video->next()) use(grey, std::to_string(count++));
  return count == 0 ? kNoVideo : "";
}

std::vector<std::string> for_each_frame(
    const std::vector<ImageFile>& files, int threads, const std::string& what,
    const std::function<void(std::size_t file, const cv::Mat& gray, const std::string& frame)>& use,
    const std::function<void(std::size_t file)>& done) {
  std::vector<std::string> reasons(files.size());
  Progress progress(what, static_cast<int>(files.size()));
  std::mutex guard;
  keep_freed_memory();
  if (threads > 1) cv::setNumThreads(1);  // one image a thread: OpenCV's own threads would only be in the way
  for_each_index(files.size(), threads, [&](std::size_t i) {
    reasons[i] = for_each_frame(files[i], [&](const cv::Mat& gray, const std::string& frame) { use(i, gray, frame); });
    const std::scoped_lock lock(guard);
    if (reasons[i].empty() && done) done(i);
    progress.advance();
  });
  return reasons;
}

}  // namespace raybundle::apps
