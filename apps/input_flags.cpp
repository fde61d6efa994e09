// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "input_flags.hpp"

#include <fmt/format.h>

#include <array>
#include <map>

#include "detect_dots.hpp"
#include "misnumbered_views.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/observation_tables.hpp"
#include "raybundle/scene/number.hpp"
#include "raybundle/scene/suggestion.hpp"
#include "raybundle/targets/board_file.hpp"
#include "repeated_views.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

[[noreturn]] void refuse(const std::string& message) { throw Error(ErrorKind::kBadInput, message); }

// NAME=VALUE of a camera that there is not would have no effect.
template <typename Cameras>
void require_named_cameras(const std::string& flag, const std::vector<std::string>& values, const Cameras& cameras) {
  std::vector<std::string> names;
  for (const auto& camera : cameras) names.push_back(camera.name);
  for (const std::string& value : values) {
    const std::size_t equals = value.find('=');
    const std::string name = value.substr(0, equals);
    if (equals == std::string::npos || std::ranges::find(names, name) != names.end()) continue;
    refuse(fmt::format("{} '{}' names a camera that does not exist.{}", flag, value, did_you_mean(name, names)));
  }
}

std::pair<std::string, std::string> name_and_value(const std::string& flag, const std::string& example) {
  const std::size_t equals = flag.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == flag.size()) {
    refuse(fmt::format("'{}' must be NAME=VALUE, as in {}", flag, example));
  }
  return {flag.substr(0, equals), flag.substr(equals + 1)};
}

std::map<std::string, ImageSize> sizes_of(const InputFlags& flags) {
  std::map<std::string, ImageSize> sizes;
  for (const std::string& flag : flags.sizes) {
    const auto [name, text] = name_and_value(flag, "--image-size left=1280x960");
    const auto [width, height] = two_numbers_from<int>(text, 'x').value_or(std::array{0, 0});
    if (width < 2 || height < 2 || width > 100000 || height > 100000) {
      refuse(fmt::format("'{}' must be WIDTHxHEIGHT in pixels, as in --image-size {}=1280x960", flag, name));
    }
    sizes[name] = {width, height};
  }
  return sizes;
}

void set_models(const std::vector<std::string>& flags, std::vector<DatasetCamera>& cameras) {
  for (const std::string& flag : flags) {
    const std::size_t equals = flag.find('=');
    const std::string model = flag.substr(equals == std::string::npos ? 0 : equals + 1);
    model_from_name(model, "--model");
    for (DatasetCamera& camera : cameras) {
      if (equals == std::string::npos || camera.name == flag.substr(0, equals)) camera.model = model;
    }
  }
  require_named_cameras("--model", flags, cameras);
}

bool is_json(const std::string& path) { return path.ends_with(".json"); }

bool is_vnl(const std::string& path) { return path.ends_with(".vnl"); }

// A flag without effect would be believed to have had one.
void refuse_idle_flags(const InputFlags& flags) {
  const bool is_table = !flags.observations.empty() && !is_json(flags.observations);
  if (!flags.sizes.empty() && !is_table) {
    refuse(
        "--image-size is for corners in a .csv or .vnl, while images and observations.json say their size themselves; "
        "leave it out");
  }
  if (!flags.cameras.empty() && !flags.observations.empty() && !is_vnl(flags.observations)) {
    refuse(fmt::format("--camera names images, but those of {} are not looked at; leave out --camera or --observations",
                       flags.observations));
  }
}

bool same_points(const Target& a, const Target& b) {
  constexpr double kRounding = 1e-9;  // [m], of a file's decimal numbers
  return std::ranges::equal(a.points, b.points, [](const TargetPoint& p, const TargetPoint& q) {
    return p.id == q.id && (p.x_in_target - q.x_in_target).norm() < kRounding;
  });
}

// observations.json holds its boards: another one that is given beside it would be ignored.
void require_boards_of_file(const Dataset& dataset, const CalibrationProblem& problem, const std::string& path) {
  for (const DatasetBoard& board : dataset.boards) {
    const Target given = target_of(board.board);
    if (std::ranges::any_of(problem.targets, [&](const Target& target) { return same_points(given, target); })) {
      continue;
    }
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("the corners are of another board than {}; leave that board out, or detect them again with it",
                    word_of(board.board)),
        path);
  }
}

Target named_target(const DatasetBoard& board) {
  Target target = target_of(board.board);
  target.name = board.name;
  return target;
}

// The laser's anchor names its view by number, and the numbers change.
void leave_out_bad_views(DetectedImages& images) {
  CalibrationProblem& problem = images.observations.problem;
  std::optional<TargetView> anchored;
  if (problem.laser && problem.laser->anchor) anchored = problem.views.at(problem.laser->anchor->view);
  leave_out_repeated_views(images);
  leave_out_misnumbered_views(images);
  if (!anchored) return;
  const auto found = std::ranges::find_if(problem.views, [&](const TargetView& view) {
    return view.camera == anchored->camera && view.frame == anchored->frame && view.target == anchored->target;
  });
  if (found == problem.views.end()) refuse("the laser's anchor is in a view that is left out; name a dot in another");
  problem.laser->anchor->view = static_cast<int>(found - problem.views.begin());
}

}  // namespace

void add_input_flags(CLI::App& verb, InputFlags& flags) {
  verb.add_option("dataset", flags.dataset, "dataset.toml: boards, cameras, images")->type_name("DATASET.toml");
  verb.add_option("--target", flags.target, "the board, as chessboard:9x6:25mm, or its TOML file")->type_name("BOARD");
  verb.add_option("--camera", flags.cameras, "a camera and its images, as left='left*.jpg'; repeat for each")
      ->type_name("NAME=IMAGES")
      ->allow_extra_args(false);
  verb.add_option("--observations", flags.observations, "corners found before: observations.json, .csv or .vnl")
      ->type_name("FILE");
  verb.add_option("--image-size", flags.sizes, "of a camera whose corners stand in a .csv or .vnl, as left=1280x960")
      ->type_name("NAME=WxH")
      ->allow_extra_args(false);
  verb.add_option("--threads", flags.threads, "worker threads; results do not depend on them")
      ->check(CLI::Range(1, kMostThreads))
      ->default_str(fmt::format("{}", CalibrateOptions{}.threads))
      ->type_name("INT");
  verb.add_flag("!--no-cache", flags.use_cache, "detect again even when the images have been seen before");
}

void add_model_flags(CLI::App& verb, InputFlags& flags) {
  verb.add_option("--model", flags.models, "camera model of all cameras, or NAME=MODEL of one")
      ->type_name("MODEL")
      ->allow_extra_args(false);
  verb.add_option("--anchor", flags.anchor, "one laser dot whose beam is known, as left/12:320.5,240=5,5")
      ->type_name("CAMERA/FRAME:U,V=ROW,COLUMN");
}

DetectOptions detect_options(const InputFlags& flags, const Dataset& dataset) {
  return {dataset.options.threads, flags.use_cache};
}

Dataset dataset_of(const InputFlags& flags, bool need_models) {
  Dataset dataset;
  if (is_image(flags.dataset)) {
    refuse(
        fmt::format("{} is an image where a dataset.toml may stand; put the pattern of --camera in quotes, as in "
                    "--camera left='left*.jpg'",
                    flags.dataset));
  }
  refuse_idle_flags(flags);
  if (!flags.dataset.empty()) dataset = read_dataset(flags.dataset);
  if (flags.threads) dataset.options.threads = *flags.threads;
  if (!flags.target.empty()) dataset.boards = {{"board", board_from_word_or_toml(flags.target)}};
  if (!flags.cameras.empty()) {
    if (dataset.laser) say_warning("[laser] of " + flags.dataset + " is not used, as --camera replaces its images");
    dataset.laser.reset();  // its images are named beside those of the cameras
    dataset.folder.clear();
    const std::vector<DatasetCamera> described = std::move(dataset.cameras);
    dataset.cameras.clear();
    for (const std::string& flag : flags.cameras) {
      DatasetCamera camera = camera_from_flag(flag, "");
      const auto same = std::ranges::find(described, camera.name, &DatasetCamera::name);
      if (same != described.end()) camera.model = same->model;
      dataset.cameras.push_back(std::move(camera));
    }
  }
  if (!flags.observations.empty()) {
    if (is_image(flags.observations)) {
      refuse(
          fmt::format("{} is an image, not a file of corners; give images with --camera, as in --camera "
                      "left='left*.jpg'",
                      flags.observations));
    }
    if (dataset.laser) {
      refuse(
          "the file of --observations says what is known of the laser, and so does [laser] of the dataset; leave one "
          "of them out");
    }
    if (!is_json(flags.observations) && dataset.boards.empty()) {
      refuse("corners without a board: give --target, as in --target chessboard:9x6:25mm");
    }
    if (flags.observations.ends_with(".csv")) {
      for (const auto& [name, size] : sizes_of(flags)) dataset.cameras.push_back({name, {}, "", {}});
    }
    return dataset;  // observe() sets the models, when the cameras are known
  }
  if (dataset.boards.empty())
    refuse("which board? Give a dataset.toml or --target, as in --target chessboard:9x6:25mm");
  if (dataset.cameras.empty()) refuse("which images? Give a dataset.toml or --camera, as in --camera left='left*.jpg'");
  set_models(flags.models, dataset.cameras);
  for (const DatasetCamera& camera : dataset.cameras) {
    if (need_models && camera.model.empty()) {
      refuse(
          fmt::format("camera {} has no model; give --model, as in --model kannala_brandt for a fisheye or --model "
                      "brown_conrady for an ordinary lens",
                      camera.name));
    }
  }
  return dataset;
}

DetectedImages observe(const InputFlags& flags, const Dataset& dataset) {
  if (flags.observations.empty()) {
    DetectedImages images = detect_images(dataset, detect_options(flags, dataset));
    if (dataset.laser) add_dots(dataset, detect_options(flags, dataset), images);
    if (!flags.anchor.empty()) set_anchor(anchor_from_flag(flags.anchor), images.observations.problem);
    leave_out_bad_views(images);
    return images;
  }
  DetectedImages images;
  ObservationsFile& file = images.observations;
  if (is_json(flags.observations)) {
    file = read_observations(flags.observations);
    require_boards_of_file(dataset, file.problem, flags.observations);
  } else if (is_vnl(flags.observations)) {
    const std::map<std::string, ImageSize> sizes = sizes_of(flags);
    std::vector<VnlCamera> cameras;
    for (const DatasetCamera& camera : dataset.cameras) {
      const auto size = sizes.find(camera.name);
      if (size == sizes.end()) refuse(fmt::format("give --image-size {}=WIDTHxHEIGHT", camera.name));
      cameras.push_back({camera.name, camera.images, size->second});
    }
    if (cameras.empty()) refuse("which images belong to which camera? Give --camera, as in --camera left='left*.jpg'");
    file.problem = read_observations_vnl(flags.observations, named_target(dataset.boards.front()), cameras);
  } else {
    file.problem = read_observations_csv(flags.observations, named_target(dataset.boards.front()), sizes_of(flags));
  }
  require_named_cameras("--model", flags.models, file.problem.cameras);
  require_named_cameras("--image-size", flags.sizes, file.problem.cameras);
  if (!flags.anchor.empty()) set_anchor(anchor_from_flag(flags.anchor), file.problem);
  file.models.resize(file.problem.cameras.size());
  for (std::size_t c = 0; c < file.problem.cameras.size(); ++c) {
    std::vector<DatasetCamera> one{{file.problem.cameras[c].name, {}, "", {}}};
    const auto described = std::ranges::find(dataset.cameras, one[0].name, &DatasetCamera::name);
    if (described != dataset.cameras.end()) one[0].model = described->model;
    for (const std::string& flag : flags.models) {
      if (flag.find('=') == std::string::npos || flag.starts_with(one[0].name + "=")) set_models({flag}, one);
    }
    if (!one[0].model.empty()) file.models[c] = model_from_name(one[0].model, "--model");
    if (file.models[c]) file.problem.cameras[c].model = *file.models[c];
  }
  leave_out_bad_views(images);
  if (!is_json(flags.observations)) warn_of_mirrored_views(dataset.boards.front().board, file.problem);
  return images;
}

}  // namespace raybundle::apps
