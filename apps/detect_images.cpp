// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "detect_images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <functional>
#include <iterator>
#include <map>
#include <set>

#include "alike_boards.hpp"
#include "detection_cache.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/hash.hpp"

namespace raybundle::apps {
namespace {

constexpr const char* kNoBoard = "no board found";
constexpr std::size_t kFewestCorners = 4;

std::vector<Board> boards_of(const Dataset& dataset) {
  std::vector<Board> boards;
  for (const DatasetBoard& board : dataset.boards) boards.push_back(board.board);
  return boards;
}

// Nothing for a file that cannot be read: whoever reads it says why.
std::string key_of(ImageFile& file, const std::vector<Board>& boards) try {
  file.sha256 = sha256_of_file(file.path);
  return cache_key(file.sha256, boards);
} catch (const Error&) {
  return "";
}

// Detections of all frames of all files, from the cache where it has them. Aligned with files.
std::vector<std::vector<CachedFrame>> detect_files(const Dataset& dataset, const DetectOptions& options,
                                                   std::vector<ImageFile>& files,
                                                   std::vector<std::string>& unreadable) {
  const std::vector<Board> boards = boards_of(dataset);
  std::vector<std::vector<CachedFrame>> found(files.size());
  std::vector<std::string> keys(files.size());
  std::vector<ImageFile> todo;
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < files.size(); ++i) {
    std::optional<std::vector<CachedFrame>> cached;
    if (options.use_cache) keys[i] = key_of(files[i], boards);
    if (!keys[i].empty()) cached = read_cached(keys[i], boards);
    if (cached) {
      found[i] = std::move(*cached);
      if (!files[i].video && found[i].size() == 1) found[i][0].frame = files[i].frame;  // the name is not the content
    } else {
      todo.push_back(files[i]);
      index.push_back(i);
    }
  }
  // Kept as soon as a file is done: whoever interrupts a long run goes on from there.
  const auto keep = [&](std::size_t t) {
    if (!keys[index[t]].empty()) write_cached(keys[index[t]], found[index[t]]);
  };
  const std::vector<std::string> reasons = for_each_frame(
      todo, options.threads, "detecting",
      [&](std::size_t t, const cv::Mat& gray, const std::string& frame) {
        CachedFrame entry{frame, gray.cols, gray.rows, {}};
        for (const Board& board : boards) entry.boards.push_back(detect(board, gray));
        found[index[t]].push_back(std::move(entry));
      },
      keep);
  unreadable.assign(files.size(), "");
  for (std::size_t t = 0; t < todo.size(); ++t) unreadable[index[t]] = reasons[t];
  return found;
}

// The size that more than half of a camera's images have; none when it has no images.
ImageSize size_of_most(int camera, const std::string& name, const std::vector<ImageFile>& files,
                       const std::vector<std::vector<CachedFrame>>& found) {
  struct Alike {
    ImageSize size;
    std::string example;
    int count = 0;
  };
  std::vector<Alike> sizes;
  int images = 0;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (files[i].camera != camera) continue;
    for (const CachedFrame& frame : found[i]) {
      const ImageSize size{frame.width, frame.height};
      auto alike = std::ranges::find(sizes, size, &Alike::size);
      if (alike == sizes.end()) alike = sizes.insert(sizes.end(), {size, files[i].path});
      ++alike->count;
      ++images;
    }
  }
  if (sizes.empty()) return {};
  std::ranges::stable_sort(sizes, std::greater(), &Alike::count);
  if (2 * sizes[0].count > images) return sizes[0].size;
  throw Error(ErrorKind::kBadInput,
              fmt::format("camera {} has images of different sizes: {} is {}x{}, {} is {}x{}; give each its own camera",
                          name, sizes[0].example, sizes[0].size.width, sizes[0].size.height, sizes[1].example,
                          sizes[1].size.width, sizes[1].size.height));
}

int index_of(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<int>(std::ranges::find(names, name) - names.begin());
}

std::string describe_miss(const Detection& detection) {
  if (!detection.hint.empty()) return fmt::format("{}: {}", kNoBoard, detection.hint);
  if (!detection.observations.empty())
    return fmt::format("{}: only {} corners", kNoBoard, detection.observations.size());
  return kNoBoard;
}

std::vector<ImageFile> files_of(const Dataset& dataset) {
  std::vector<ImageFile> files;
  std::vector<std::string> names;
  for (int c = 0; c < static_cast<int>(dataset.cameras.size()); ++c) {
    const DatasetCamera& camera = dataset.cameras[c];
    std::ranges::copy(image_files(c, dataset.folder, camera.images), std::back_inserter(files));
    names.push_back(camera.name);
  }
  refuse_shared_images(files, names);
  return files;
}

// Boards, frames and cameras.
ObservationsFile observations_without_views(const Dataset& dataset, const std::vector<ImageFile>& files,
                                            const std::vector<std::vector<CachedFrame>>& found) {
  ObservationsFile observations;
  CalibrationProblem& problem = observations.problem;
  for (const DatasetBoard& board : dataset.boards) {
    problem.targets.push_back(target_of(board.board));
    problem.targets.back().name = board.name;
  }
  std::set<std::string> frame_names;
  for (const auto& frames : found) {
    for (const CachedFrame& frame : frames) frame_names.insert(frame.frame);
  }
  problem.frames.assign(frame_names.begin(), frame_names.end());
  sort_by_number(problem.frames);
  for (const DatasetCamera& camera : dataset.cameras) {
    std::optional<ModelId> model;
    if (!camera.model.empty()) model = model_from_name(camera.model, "camera " + camera.name);
    observations.models.push_back(model);
    problem.cameras.push_back({camera.name, model.value_or(ModelId{}), {}, {}, {}});
  }
  for (std::size_t c = 0; c < dataset.cameras.size(); ++c) {
    problem.cameras[c].size = size_of_most(static_cast<int>(c), dataset.cameras[c].name, files, found);
  }
  return observations;
}

// The boards that were found in one image of a file, or why none was.
void add_views(const ImageFile& file, const CachedFrame& frame, DetectedImages& images,
               std::map<std::string, std::string>& hints) {
  CalibrationProblem& problem = images.observations.problem;
  bool any = false;
  for (std::size_t b = 0; b < frame.boards.size(); ++b) {
    const Detection& detection = frame.boards[b];
    if (!detection.hint.empty()) hints.emplace(without_digits(detection.hint), detection.hint);
    const bool may_be_another = frame.boards.size() > 1;  // of the data set's
    if (!detection.seen_size.empty() && !may_be_another) ++images.seen_sizes[detection.seen_size];
    if (detection.observations.size() < kFewestCorners) continue;
    any = true;
    problem.views.push_back(
        {file.camera, index_of(problem.frames, frame.frame), static_cast<int>(b), detection.observations, file.path});
  }
  if (any) return;
  images.unused.push_back(
      {problem.cameras[file.camera].name, frame.frame, file.path, describe_miss(frame.boards.front())});
}

}  // namespace

std::string without_digits(std::string text) {
  std::erase_if(text, [](unsigned char c) { return std::isdigit(c) != 0; });
  return text;
}

DetectedImages detect_images(const Dataset& dataset, const DetectOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  refuse_alike_boards(dataset.boards);
  DetectedImages images;
  images.files = files_of(dataset);
  std::vector<std::string> unreadable;
  const std::vector<std::vector<CachedFrame>> found = detect_files(dataset, options, images.files, unreadable);
  images.observations = observations_without_views(dataset, images.files, found);
  const std::vector<ProblemCamera>& cameras = images.observations.problem.cameras;
  std::map<std::string, std::string> hints;  // by their words: those that differ in a count only are one
  for (std::size_t i = 0; i < images.files.size(); ++i) {
    const ImageFile& file = images.files[i];
    const ProblemCamera& camera = cameras[file.camera];
    if (!unreadable[i].empty()) images.unused.push_back({camera.name, file.frame, file.path, unreadable[i]});
    for (const CachedFrame& frame : found[i]) {
      if (camera.size == ImageSize{frame.width, frame.height}) {
        add_views(file, frame, images, hints);
      } else {
        images.unused.push_back({camera.name, frame.frame, file.path,
                                 fmt::format("is {}x{}, but most images of its camera are {}x{}", frame.width,
                                             frame.height, camera.size.width, camera.size.height)});
      }
    }
  }
  for (const auto& [words, hint] : hints) images.hints.push_back(hint);
  images.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return images;
}

void require_views(const DetectedImages& images) {
  const std::size_t views = images.observations.problem.views.size();
  const auto often = std::ranges::max_element(images.seen_sizes, {}, [](const auto& entry) { return entry.second; });
  const std::size_t others = often == images.seen_sizes.end() ? 0 : static_cast<std::size_t>(often->second);
  // In a board that was not asked for, or its reflection, one that was may be found now and then.
  const bool now_and_then = views < images.unused.size() && 2 * others >= views;
  if (others > 0 && (others >= views || now_and_then)) {
    throw Error(
        ErrorKind::kNotEnoughData,
        fmt::format("{} inner corners of a chessboard are seen in {} of {} images, which is not the board asked "
                    "for; did you count squares, or miss a row? chessboard:{}:SQUARE would fit",
                    often->first, often->second, images.files.size(), often->first));
  }
  if (views > 0) return;
  if (images.files.empty()) {
    throw Error(ErrorKind::kNotEnoughData, "the file of --observations holds no corner of the board");
  }
  const auto unreadable = std::ranges::count_if(
      images.unused, [](const UnusedImage& image) { return !image.reason.starts_with(kNoBoard); });
  const std::size_t looked_at = images.unused.size();  // frames of videos, too
  std::string message = looked_at == 1 ? "no board was found in the image"
                                       : fmt::format("no board was found in any of {} images", looked_at);
  if (unreadable > 0) {
    const auto first = std::ranges::find_if(
        images.unused, [](const UnusedImage& image) { return !image.reason.starts_with(kNoBoard); });
    message += fmt::format("; {} of them cannot be used, such as {}: {}", unreadable, first->image, first->reason);
  }
  for (const std::string& hint : images.hints) message += "; " + hint;
  if (images.hints.empty() && unreadable < static_cast<std::ptrdiff_t>(images.unused.size())) {
    message += "; are the board's kind and its size right (a chessboard counts inner corners)?";
  }
  throw Error(ErrorKind::kNotEnoughData, message);
}

}  // namespace raybundle::apps
