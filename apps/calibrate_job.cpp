// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "calibrate_job.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <utility>
#include <variant>

#include "calibration_summary.hpp"
#include "given_values.hpp"
#include "judgement.hpp"
#include "output_folder.hpp"
#include "predicted_corners.hpp"
#include "previews.hpp"
#include "raybundle/bundle/parameters.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/io/hash.hpp"
#include "raybundle/io/report_file.hpp"
#include "report_page.hpp"
#include "survey_text.hpp"
#include "tag_size.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// What the dataset says, unless the job says otherwise.
CalibrateOptions merged_options(CalibrateOptions options, const CalibrateJob& job) {
  CalibrateOptions::for_each_option(
      options, [&]<typename T>(std::string_view name, const char*, const char*, T& value) {
        if (!job.options_given.contains(std::string(name))) return;
        CalibrateOptions::for_each_option(
            job.options, [&]<typename U>(std::string_view other, const char*, const char*, const U& given) {
              if constexpr (std::is_same_v<T, U>) {
                if (name == other) value = given;
              }
            });
      });
  check(options, "the command line");
  return options;
}

void require_models(const DetectedImages& images) {
  for (std::size_t c = 0; c < images.observations.models.size(); ++c) {
    if (images.observations.models[c]) continue;
    throw Error(ErrorKind::kBadInput,
                fmt::format("camera {} has no model; give --model, as in --model kannala_brandt for a fisheye",
                            images.observations.problem.cameras[c].name));
  }
}

// An example of a camera's frames: `left_a.jpg is frame left_a of camera left`.
std::string frame_example(const DetectedImages& images, int camera) {
  const auto file = std::ranges::find(images.files, camera, &ImageFile::camera);
  return fmt::format("{} is frame {} of camera {}", std::filesystem::path(file->path).filename().string(), file->frame,
                     images.observations.problem.cameras[camera].name);
}

// Whether a file that matched is no image: it keeps its whole name for a frame.
bool is_no_image(const std::string& frame, const std::string& path) {
  return frame == std::filesystem::path(path).filename().string();
}

// Cameras are linked by frames, which are told by the names of images: where these have nothing in common, more images
// would not help.
void require_shared_frames(const DetectedImages& images) {
  std::map<std::string, std::set<int>> cameras_of;  // by frame
  std::set<int> cameras, linked;
  for (const ImageFile& file : images.files) {
    if (file.video) return;  // frames of videos are counted, so that they always have some in common
    if (is_no_image(file.frame, file.path)) continue;
    cameras.insert(file.camera);
    cameras_of[file.frame].insert(file.camera);
  }
  for (const UnusedImage& image : images.unused) {  // some are no longer among the files, but had their number
    if (is_no_image(image.frame, image.image)) continue;
    const auto& all = images.observations.problem.cameras;
    const auto camera = std::ranges::find(all, image.camera, &ProblemCamera::name);
    cameras_of[image.frame].insert(static_cast<int>(camera - all.begin()));
  }
  for (const auto& [frame, sharing] : cameras_of) {
    if (sharing.size() > 1) linked.insert(sharing.begin(), sharing.end());
  }
  const auto alone = std::ranges::find_if(cameras, [&](int camera) { return !linked.contains(camera); });
  if (cameras.size() < 2 || alone == cameras.end()) return;
  const int other = *alone == *cameras.begin() ? *std::next(cameras.begin()) : *cameras.begin();
  throw Error(ErrorKind::kNotEnoughData,
              fmt::format("no image of camera {} has the number of an image of another camera: {}, {}; name the images "
                          "of one moment alike, as left01.jpg and right01.jpg",
                          images.observations.problem.cameras[*alone].name, frame_example(images, *alone),
                          frame_example(images, other)));
}

// One of the images that were left out for the most frequent reason.
const UnusedImage& usual_miss(const std::vector<UnusedImage>& unused) {
  std::map<std::string, int> count_of;
  for (const UnusedImage& image : unused) ++count_of[without_digits(image.reason)];
  return *std::ranges::max_element(unused, {},
                                   [&](const UnusedImage& image) { return count_of[without_digits(image.reason)]; });
}

// A failed solve for want of data is explained by what was left out, and by what the images show instead of the board:
// first of all where that is most of them.
CalibrationResult calibrate_explained(const CalibrationProblem& problem, const CalibrateOptions& options,
                                      const DetectedImages& images) try {
  return calibrate(problem, options);
} catch (const Error& error) {
  if (error.kind() != ErrorKind::kNotEnoughData || images.unused.empty()) throw;
  std::set<std::pair<int, int>> used;  // camera and frame: an image may show several boards
  for (const TargetView& view : problem.views) used.insert({view.camera, view.frame});
  const UnusedImage& miss = usual_miss(images.unused);
  std::string left_out =
      fmt::format("{} of {} {} are left out, such as {}: {}", images.unused.size(), images.unused.size() + used.size(),
                  images.files.empty() ? "views" : "images", miss.image, miss.reason);
  for (const std::string& hint : images.hints) {
    if (!without_digits(miss.reason).ends_with(without_digits(hint))) left_out += "; " + hint;
  }
  const bool most = images.unused.size() > used.size();
  throw Error(error.kind(), most ? left_out + "; for the rest, " + error.what() : error.what() + ("; " + left_out));
}

// What went in beside the images.
std::vector<std::string> files_of(const CalibrateJob& job, const Dataset& dataset,
                                  const std::optional<SurveyInput>& survey) {
  std::vector<std::string> files{job.input.dataset, job.input.observations, job.start, job.gates.file};
  if (job.input.target.ends_with(".toml")) files.push_back(job.input.target);
  for (const DatasetBoard& board : dataset.boards) {
    if (const auto* set = std::get_if<PointSet>(&board.board)) files.push_back(set->file);
  }
  if (survey) files.insert(files.end(), {survey->landmarks, survey->sightings});
  std::erase(files, "");
  return files;
}

Provenance provenance_of(const CalibrateJob& job, const std::vector<std::string>& named,
                         const CalibrateOptions& options, const DetectedImages& images) {
  Provenance provenance;
  provenance.command = job.command;
  provenance.versions = {{"raybundle", RAYBUNDLE_VERSION}};
  CalibrateOptions::for_each_option(options, [&](std::string_view name, const char*, const char*, const auto& value) {
    if (name == "threads") return;  // the result does not depend on them, and its file is to be the same byte by byte
    provenance.options.emplace_back(name, fmt::format("{}", value));
  });
  std::ranges::copy(job.flags_given, std::back_inserter(provenance.options));
  for (const std::string& path : named) provenance.inputs.push_back({path, sha256_of_file(path)});
  std::vector<ImageFile> files = images.files;
  std::ranges::copy(images.laser_files, std::back_inserter(files));
  std::erase_if(files, [](const ImageFile& file) { return access(file.path.c_str(), R_OK) != 0; });  // told as left out
  for_each_index(files.size(), options.threads, [&](std::size_t i) {
    if (files[i].sha256.empty()) files[i].sha256 = sha256_of_file(files[i].path);
  });
  for (const ImageFile& file : files) provenance.inputs.push_back({file.path, file.sha256});
  return provenance;
}

double seconds_of(const CalibrationResult& result, std::string_view name) {
  double seconds = 0.0;
  for (const StageTime& stage : result.stages) seconds += stage.name == name ? stage.seconds : 0.0;
  return seconds;
}

// Seconds of the stages in the order of the work. `refine` is everything from the first solve to the last, but for what
// the last one reports: of stages that ran in both, the first time belongs to it.
std::vector<StageTime> stages_of(double detect_seconds, const CalibrationResult& first, const CalibrationResult& last,
                                 double refine_seconds, bool refined) {
  std::vector<StageTime> reported;
  for (const char* name : {"survey", "laser", "uncertainty"}) {
    const double seconds = seconds_of(last, name);
    if (seconds > 0.0) reported.push_back({name, seconds});
    if (refined) refine_seconds += seconds_of(first, name) - seconds;
  }
  std::vector<StageTime> stages{{"detect", detect_seconds},
                                {"start", seconds_of(first, "start")},
                                {"solve", seconds_of(first, "solve")},
                                {"refine", refine_seconds}};
  std::ranges::move(reported, std::back_inserter(stages));
  return stages;
}

// The current folder, where image paths start, as seen from another one.
std::string folder_from(const std::filesystem::path& folder) {
  std::error_code failed;
  return std::filesystem::relative(std::filesystem::current_path(), folder, failed).generic_string();
}

// How to test the calibration on images that it has not seen.
std::string next_command(const CalibrateJob& job, const CalibrationResult& result) {
  std::string command = "raybundle validate " + shell_word(job.output + "/calibration.json");
  if (!job.input.dataset.empty() && job.input.cameras.empty()) return command + " OTHER_DATASET.toml";
  if (!job.input.observations.empty() && job.input.target.empty()) return command + " --observations OTHER_FILE";
  if (!job.input.target.empty()) command += " --target " + shell_word(job.input.target);
  for (const RigCamera& camera : result.calibration.cameras) {
    command += fmt::format(" --camera {}='OTHER_IMAGES'", shell_word(camera.name));
  }
  return command;
}

// The three files, together; the stage `write` is what comes before the report has to be finished.
std::string write_all(const CalibrateJob& job, const CalibrationProblem& problem, CalibrationResult& result,
                      const ReportExtra& extra) {
  const double begin = now();
  const std::filesystem::path folder(job.output);
  const std::string calibration = text_from_calibration(calibration_file(problem, result, extra.provenance));
  result.stages.push_back({"write", now() - begin});
  ::malloc_trim(0);  // what the solve freed lies in small pieces between others, and the text needs a large one
  std::string report = text_from_report(problem, result, extra);
  const ReportFrame frame = report_frame(folder_from(folder));
  const std::vector<std::string_view> page{frame.before, report, frame.behind};
  write_results(
      folder,
      {{folder / "calibration.json", calibration}, {folder / "report.json", report}, {folder / "report.html", page}});
  return report;
}

// Of the boards that the data set describes: a file of corners knows points only.
void warn_of_tag_sizes(const Dataset& dataset, const CalibrationProblem& problem, CalibrationResult& result) {
  for (const DatasetBoard& board : dataset.boards) {
    const auto* grid = std::get_if<AprilGrid>(&board.board);
    const auto target = std::ranges::find(problem.targets, board.name, &Target::name);
    if (grid == nullptr || target == problem.targets.end()) continue;
    const int index = static_cast<int>(target - problem.targets.begin());
    std::string warning = tag_size_warning(*grid, index, problem, result);
    if (!warning.empty()) result.warnings.push_back(std::move(warning));
  }
}

std::vector<std::string> camera_names(const auto& cameras) {
  std::vector<std::string> names;
  for (const auto& camera : cameras) names.push_back(camera.name);
  return names;
}

// The C library sees large blocks come and go, and soon puts them between small ones, where they leave holes: with the
// corners of thousands of views a twentieth of all memory.
void keep_large_blocks_apart() {
  constexpr int kLargeBlock = 1 << 20;  // [bytes]
  mallopt(M_MMAP_THRESHOLD, kLargeBlock);
}

}  // namespace

void run_calibration(const CalibrateJob& job) {
  keep_large_blocks_apart();
  Dataset dataset = dataset_of(job.input, true);
  const CalibrateOptions options = merged_options(dataset.options, job);
  require_writable(job.output);
  const std::vector<Requirement> requirements = requirements_of(job.gates);
  if (!dataset.cameras.empty()) {
    check_requirements(requirements, camera_names(dataset.cameras), dataset.laser.has_value());
  }

  DetectedImages images = observe(job.input, dataset);
  require_models(images);
  require_views(images);
  require_shared_frames(images);
  CalibrationProblem& problem = images.observations.problem;
  check_requirements(requirements, camera_names(problem.cameras), problem.laser.has_value());
  problem.rules = dataset.rules;
  problem.rules.insert(problem.rules.end(), job.rules.begin(), job.rules.end());
  parameter_blocks(problem);  // refuses rules that match nothing, before any asks for its value
  warn_of_void_rules(problem);
  if (!job.start.empty()) take_start(job.start, problem);
  const std::optional<SurveyInput> survey = job.survey.landmarks.empty() ? dataset.survey : job.survey;
  if (survey) problem.survey = read_survey(*survey);

  const CalibrationResult first = calibrate_explained(problem, options, images);
  CalibrationResult result = first;
  for (const std::string& hint : images.hints) say_warning(hint);
  const double refine_begin = now();
  bool refined = false;
  if (job.predict_corners && !images.files.empty()) {
    refined = add_predicted_corners(dataset, result, images, detect_options(job.input, dataset)) > 0;
    if (refined) result = calibrate(problem, options);
  }
  result.stages = stages_of(images.seconds, first, result, now() - refine_begin, refined);

  warn_of_tag_sizes(dataset, problem, result);
  const double check_begin = now();
  const CheckFindings checked = run_extra_checks(job.checks, problem, result, options);
  std::ranges::copy(checked.warnings, std::back_inserter(result.warnings));
  if (!checked.sections.empty()) result.stages.push_back({"check", now() - check_begin});
  const double judge_begin = now();
  Judgements judgements;
  ReportExtra extra{images.unused, {}, {}};
  ReportSection pictures;
  const std::vector<std::string> named = files_of(job, dataset, survey);
  const std::function<void()> parts[] = {// each with work that cannot be shared: beside each other they fill it
                                         [&] {
                                           judgements = judge(problem, result, requirements, options.threads);
                                           extra.sections = sections_of(judgements, result);
                                         },
                                         [&] { pictures = pictures_section(problem, result, options.threads); },
                                         [&] { extra.provenance = provenance_of(job, named, options, images); }};
  for_each_index(std::size(parts), options.threads, [&](std::size_t i) { parts[i](); });
  extra.sections.push_back(std::move(pictures));
  if (result.survey) extra.sections.push_back({"survey", json_from_survey(*result.survey).dump()});
  std::ranges::copy(checked.sections, std::back_inserter(extra.sections));
  result.stages.push_back({"judge", now() - judge_begin});
  const std::string report = write_all(job, problem, result, extra);
  const bool failed = judgements.verdict.grade == Grade::kFail;
  if (job.json) {
    std::puts(report.c_str());  // without the copy that formatting makes
    if (failed) throw GateFailed{};
    return;
  }
  fmt::print("{}{}{}", summary_text(problem, result, images.unused), text_of(judgements), checked.text);
  fmt::print("\nwrote {0}/calibration.json, {0}/report.json\nlook  {0}/report.html\n", job.output);
  fmt::print("next  {}\n", job.next.empty() ? next_command(job, result) : job.next);
  if (failed) throw GateFailed{};
}

}  // namespace raybundle::apps
