// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "calibrate_job.hpp"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>

#include "calibration_summary.hpp"
#include "predicted_corners.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/io/hash.hpp"
#include "raybundle/io/report_file.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "report_page.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// Found out before the work, not after it.
void require_writable(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) {
    const std::filesystem::path probe = std::filesystem::path(folder) / ".raybundle-probe";
    write_file_whole(probe, "");
    std::filesystem::remove(probe, error);
    return;
  }
  throw Error(ErrorKind::kIo,
              fmt::format("the output folder {} cannot be made: {}; choose another with -o", folder, error.message()));
}

void take_start(const std::string& path, CalibrationProblem& problem) {
  const CalibrationFile start = read_calibration(path);
  for (ProblemCamera& camera : problem.cameras) {
    const RigCamera& known = camera_named(start.calibration, camera.name);
    if (known.camera.model != camera.model) {
      throw Error(ErrorKind::kBadInput, fmt::format("camera {} is a {} in {}, but --model says {}", camera.name,
                                                    model_name(known.camera.model), path, model_name(camera.model)));
    }
    camera.parameters = known.camera.parameters;
    camera.camera_from_rig = known.camera_from_rig;
  }
}

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

// A failed solve for want of data is explained by what the images show instead of the board.
CalibrationResult calibrate_explained(const CalibrationProblem& problem, const CalibrateOptions& options,
                                      const DetectedImages& images) try {
  return calibrate(problem, options);
} catch (const Error& error) {
  if (error.kind() != ErrorKind::kNotEnoughData || images.unused.empty()) throw;
  std::string message = error.what();
  message += fmt::format("; {} of {} images show no usable board", images.unused.size(), images.files.size());
  for (const std::string& hint : images.hints) message += "; " + hint;
  throw Error(error.kind(), message);
}

Provenance provenance_of(const CalibrateJob& job, const CalibrateOptions& options, const DetectedImages& images) {
  Provenance provenance;
  provenance.command = job.command;
  provenance.versions = {{"raybundle", RAYBUNDLE_VERSION}};
  CalibrateOptions::for_each_option(options, [&](const char* name, const char*, const char*, const auto& value) {
    provenance.options.emplace_back(name, fmt::format("{}", value));
  });
  if (!job.input.dataset.empty()) provenance.inputs.push_back({job.input.dataset, sha256_of_file(job.input.dataset)});
  if (!job.input.observations.empty()) {
    provenance.inputs.push_back({job.input.observations, sha256_of_file(job.input.observations)});
  }
  for (const ImageFile& file : images.files) provenance.inputs.push_back({file.path, sha256_of_file(file.path)});
  return provenance;
}

// Seconds of the stages in the order of the work; the second solve, with the predicted corners, counts as `refine`.
std::vector<StageTime> stages_of(double detect_seconds, const CalibrationResult& first, double refine_seconds) {
  std::vector<StageTime> stages{{"detect", detect_seconds}};
  for (const char* name : {"start", "solve"}) {
    for (const StageTime& stage : first.stages) {
      if (stage.name == name) stages.push_back(stage);
    }
  }
  stages.push_back({"refine", refine_seconds});
  for (const StageTime& stage : first.stages) {
    if (stage.name == "uncertainty") stages.push_back(stage);
  }
  return stages;
}

// The current folder, where image paths start, as seen from another one.
std::string folder_from(const std::filesystem::path& folder) {
  std::error_code failed;
  return std::filesystem::relative(std::filesystem::current_path(), folder, failed).generic_string();
}

// Without a start there is nothing that a parameter could be kept at, but what the search happened to find.
void require_values(const std::vector<ParameterRule>& rules, const std::string& start) {
  for (const ParameterRule& rule : rules) {
    if (rule.kind == ParameterRule::Kind::kFree || rule.value || !start.empty()) continue;
    throw Error(ErrorKind::kBadInput,
                fmt::format("'{0}' is to be kept, but at which value? Write {0}=VALUE, or give --start CALIBRATION",
                            rule.pattern));
  }
}

// How to test the calibration on images that it has not seen.
std::string next_command(const CalibrateJob& job, const CalibrationResult& result) {
  std::string command = fmt::format("raybundle validate {}/calibration.json", job.output);
  if (!job.input.target.empty()) command += " --target " + job.input.target;
  for (const RigCamera& camera : result.calibration.cameras) {
    command += fmt::format(" --camera {}='OTHER_IMAGES'", camera.name);
  }
  return command;
}

}  // namespace

void run_calibration(const CalibrateJob& job) {
  Dataset dataset = dataset_of(job.input, true);
  CalibrateOptions options = merged_options(dataset.options, job);
  options.threads = job.input.detect.threads;
  require_writable(job.output);

  DetectedImages images = observe(job.input, dataset);
  require_models(images);
  require_views(images);
  CalibrationProblem& problem = images.observations.problem;
  problem.rules = dataset.rules;
  problem.rules.insert(problem.rules.end(), job.rules.begin(), job.rules.end());
  require_values(problem.rules, job.start);
  if (!job.start.empty()) take_start(job.start, problem);

  CalibrationResult result = calibrate_explained(problem, options, images);
  for (const std::string& hint : images.hints) say_warning(hint);
  const CalibrationResult first = result;
  const double refine_begin = now();
  if (job.predict_corners && !images.files.empty()) {
    const int added = add_predicted_corners(dataset, result, images, job.input.detect);
    if (added > 0) result = calibrate(problem, options);
  }
  result.stages = stages_of(images.seconds, first, now() - refine_begin);

  const double write_begin = now();
  const std::filesystem::path folder(job.output);
  const ReportExtra extra{images.unused, provenance_of(job, options, images)};
  write_calibration(folder / "calibration.json", calibration_file(problem, result, extra.provenance));
  result.stages.push_back({"write", now() - write_begin});
  const std::string report = text_from_report(problem, result, extra);
  write_file_whole(folder / "report.json", report);
  write_file_whole(folder / "report.html", report_page(report, folder_from(folder)));

  if (job.json) {
    fmt::print("{}\n", report);
    return;
  }
  fmt::print("{}", summary_text(problem, result, images.unused));
  fmt::print("\nwrote {0}/calibration.json, {0}/report.json\nlook  {0}/report.html\n", job.output);
  fmt::print("next  {}\n", job.next.empty() ? next_command(job, result) : job.next);
}

}  // namespace raybundle::apps
