// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>

#include "name_list.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/frame_names.hpp"
#include "raybundle/io/observation_tables.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/number.hpp"
#include "raybundle/scene/wildcard.hpp"

namespace raybundle {
namespace {

constexpr double kMaxLevel = 30;  // 2^30 pixels is no observation any more

// A file under way: where it stands, and what its fourth column means.
struct Vnl {
  std::string name;
  int line = 0;
  bool last_is_weight = false;
};

// The lines of one image.
struct VnlImage {
  std::string path;
  int line = 0;  // its first
  std::size_t rows = 0;
  std::vector<Observation> observations;  // point_id holds the row
  std::string camera;                     // that has taken it
};

[[noreturn]] void fail_at(const Vnl& vnl, const std::string& message) {
  throw Error(ErrorKind::kBadInput, message, vnl.name + ":" + std::to_string(vnl.line));
}

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  std::vector<std::string_view> words;
  for (std::size_t begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    if (words.size() > 5) break;  // one too many is enough to complain
    begin = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

// `# filename x y level`; the fourth may be missing or be called weight. Other comments are passed over.
void read_comment(std::string_view line, Vnl& vnl) {
  const std::vector<std::string_view> words = words_of(line.substr(line.find('#') + 1));
  if (words.empty() || words[0] != "filename") return;
  const bool ok = words.size() >= 3 && words.size() <= 4 && words[1] == "x" && words[2] == "y" &&
                  (words.size() == 3 || words[3] == "level" || words[3] == "weight");
  if (!ok) fail_at(vnl, "the columns must be `filename x y level` (or weight); correct the header");
  vnl.last_is_weight = words.size() == 4 && words[3] == "weight";
}

double finite_number(std::string_view word, const char* name, const Vnl& vnl) {
  const std::optional<double> value = number_from<double>(word);
  if (!value || !std::isfinite(*value)) {
    fail_at(vnl, std::string(name) + " is " + in_quotes(word) + ", which is neither a number nor -; correct it");
  }
  return *value;
}

// Nothing for a point that was not found.
std::optional<Observation> observation_from(const std::vector<std::string_view>& words, const Vnl& vnl) {
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i] == "-") return std::nullopt;
  }
  Observation observation;
  observation.pixel = {finite_number(words[1], "x", vnl), finite_number(words[2], "y", vnl)};
  if (observation.pixel.x() < 0 || observation.pixel.y() < 0) return std::nullopt;
  if (words.size() < 4) return observation;
  const double last = finite_number(words[3], vnl.last_is_weight ? "weight" : "level", vnl);
  if (last < 0 || (vnl.last_is_weight && last == 0)) return std::nullopt;
  observation.sigma_px = vnl.last_is_weight ? 1.0 / last : std::exp2(std::min(std::floor(last), kMaxLevel));
  if (!std::isfinite(observation.sigma_px)) fail_at(vnl, "the weight is too small; leave the point out with -");
  return observation;
}

std::vector<VnlImage> images_from(std::string_view text, Vnl& vnl) {
  std::vector<VnlImage> images;
  for (vnl.line = 1; !text.empty(); ++vnl.line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::vector<std::string_view> words = words_of(line);
    if (words.empty()) continue;
    if (words[0].starts_with('#')) {
      read_comment(line, vnl);
      continue;
    }
    if (words.size() < 3 || words.size() > 4) {
      fail_at(vnl, "this line has " + std::to_string(words.size()) +
                       " words where `filename x y [level]` is expected; correct it");
    }
    if (images.empty() || images.back().path != words[0])
      images.push_back({std::string(words[0]), vnl.line, 0, {}, {}});
    VnlImage& image = images.back();
    if (std::optional<Observation> observation = observation_from(words, vnl)) {
      observation->point_id = static_cast<int>(image.rows);
      image.observations.push_back(*observation);
    }
    ++image.rows;
  }
  return images;
}

bool fits(const VnlImage& image, const std::string& pattern) {
  const bool whole_path = pattern.find('/') != std::string::npos;
  return matches_pattern(whole_path ? image.path : std::filesystem::path(image.path).filename().string(), pattern);
}

// One line stands for an image without a board; otherwise every point of the board has its line.
TargetView view_from(VnlImage& image, const Target& target, const Vnl& vnl) {
  if (image.rows != target.points.size()) {
    throw Error(ErrorKind::kBadInput,
                "image " + in_quotes(image.path) + " has " + std::to_string(image.rows) + " lines, but the board has " +
                    std::to_string(target.points.size()) + " points; correct the board size",
                vnl.name + ":" + std::to_string(image.line));
  }
  TargetView view;
  view.observations = std::move(image.observations);
  for (Observation& observation : view.observations) observation.point_id = target.points[observation.point_id].id;
  view.image = image.path;
  return view;
}

void add_camera(const VnlCamera& camera, std::vector<VnlImage>& images, const Target& target, const Vnl& vnl,
                NameList& frames, CalibrationProblem& problem) {
  for (const std::string& pattern : camera.images) {
    if (std::ranges::any_of(images, [&](const VnlImage& image) { return fits(image, pattern); })) continue;
    throw Error(ErrorKind::kBadInput,
                "no image matches " + in_quotes(pattern) + " of camera " + in_quotes(camera.name) +
                    "; the first image of the file is " + in_quotes(images.front().path),
                vnl.name);
  }
  std::vector<std::string> paths;
  std::vector<VnlImage*> chosen;
  for (VnlImage& image : images) {
    const auto fits_image = [&](const std::string& pattern) { return fits(image, pattern); };
    if (std::ranges::none_of(camera.images, fits_image)) continue;
    if (!image.camera.empty()) {
      throw Error(ErrorKind::kBadInput,
                  "image " + in_quotes(image.path) + " matches both camera " + in_quotes(image.camera) +
                      " and camera " + in_quotes(camera.name) + "; make the patterns narrower",
                  vnl.name);
    }
    image.camera = camera.name;
    paths.push_back(image.path);
    chosen.push_back(&image);
  }
  const std::vector<std::string> names = frame_names(paths);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i]->rows <= 1) continue;
    TargetView view = view_from(*chosen[i], target, vnl);
    view.camera = static_cast<int>(problem.cameras.size());
    view.frame = frames.index_of(names[i]);
    if (!view.observations.empty()) problem.views.push_back(std::move(view));
  }
  problem.cameras.push_back({camera.name, ModelId{}, camera.size, std::nullopt, std::nullopt});
}

}  // namespace

CalibrationProblem observations_from_vnl_text(std::string_view text, const std::string& name, const Target& target,
                                              const std::vector<VnlCamera>& cameras) {
  Vnl vnl{name};
  std::vector<VnlImage> images = images_from(text, vnl);
  if (images.empty()) throw Error(ErrorKind::kBadInput, "there are no corners in the file", name);
  CalibrationProblem problem;
  problem.targets = {target};
  NameList frames;
  for (const VnlCamera& camera : cameras) add_camera(camera, images, target, vnl, frames, problem);
  problem.frames = frames.names();
  check_as_part_of(name, problem);
  return problem;
}

CalibrationProblem read_observations_vnl(const std::filesystem::path& path, const Target& target,
                                         const std::vector<VnlCamera>& cameras) {
  return observations_from_vnl_text(text_of_file(path), path.string(), target, cameras);
}

}  // namespace raybundle
