// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "occupancy_classify.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "image_files.hpp"
#include "occupancy_answer.hpp"
#include "occupancy_evaluation.hpp"
#include "occupancy_input.hpp"
#include "occupancy_learning.hpp"
#include "occupancy_page.hpp"
#include "output_folder.hpp"
#include "page_text.hpp"
#include "points_json.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/occupancy/case_base_file.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "raybundle/scene/csv.hpp"
#include "stereo_cabin.hpp"
#include "stereo_frame_input.hpp"
#include "stereo_page.hpp"
#include "stereo_scan.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kNear_m = 0.30;  // cases of stereo were learnt with what is farther than 0.25 m

struct Flags {
  std::string base, vehicle, page;
  std::vector<std::string> points;
  bool json = false;
};

// In the order given; those of a pattern or folder in the order of their numbers.
std::vector<std::string> files_of(const std::vector<std::string>& given) {
  std::vector<std::string> files;
  for (const std::string& each : given) {
    const bool pattern = !fs::exists(each) && each.find_first_of("*?[{~") != std::string::npos;
    const std::vector<std::string> found = fs::is_directory(each) ? matching_files(each, {"*.json"})
                                           : pattern              ? matching_files("", {each})
                                                                  : std::vector{each};
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

/// What is told of the frames, one after the other.
class Answers {
 public:
  explicit Answers(const CaseBase& base) : base_(base), rows_{head_of_answers()} {}

  /// @param more  what else is told of the frame
  /// @return      the frame's entry
  const Json& add(const std::string& file, const Occupancy& answer, const Json& more = Json::object()) {
    rows_.push_back(row_of_answer(file, answer, base_));
    any_ |= answer.state != State::kInvalid;
    Json json = json_of_answer(file, answer, base_);
    json.update(more);
    return frames_.emplace_back(std::move(json));
  }

  bool any() const { return any_; }  ///< a frame that is not INVALID
  std::string text() const { return text_table(rows_); }
  std::string json() const { return text_of_json(Json{{"frames", frames_}}, 2) + "\n"; }

 private:
  const CaseBase& base_;
  std::vector<std::vector<std::string>> rows_;
  Json frames_ = Json::array();
  bool any_ = false;
};

// Each returns the page, or nothing without --page.
std::string classify_laser(const Flags& flags, const std::vector<std::string>& files, const CaseBase& base,
                           Answers& answers) {
  const InstalledSensor sensor = read_installed_sensor(flags.vehicle);
  OccupancyMonitor monitor(sensor.layout, base, sensor.rays(), monitor_options_of(SensorKind::kStructuredLight));
  Json shown = Json::array();
  for (const std::string& file : files) {
    const PointFrame frame = read_point_frame(file, sensor);
    const Json& answer =
        answers.add(file, monitor.process({sensor.viewpoint_in_vehicle, frame.points, sensor.rays(), frame.state}));
    if (flags.page.empty()) continue;
    shown.push_back(answer);
    shown.back()["points"] = page_points(frame.points);
  }
  return flags.page.empty() ? "" : occupancy_page(sensor.layout, shown);
}

/// A pair of cameras in a car: its points, what the seat's boxes and the head say, and the decision.
class StereoSeat {
 public:
  StereoSeat(const StereoCabin& cabin, const StereoFrameInput& first, const CaseBase& base)
      : rectification_(first.rectification),
        watch_(cabin, rectification_),
        scan_(rectification_.camera, cabin.vehicle_from_rig * rectification_.rig_from_rectified),
        monitor_(cabin.layout, base, scan_.rays(), scan_.monitor_options()) {}

  /// Whether a frame is of this pair.
  bool took(const StereoFrameInput& frame) const {
    const RectifiedCamera &a = rectification_.camera, &b = frame.rectification.camera;
    const Rigid3 &at = rectification_.rig_from_rectified, &to = frame.rectification.rig_from_rectified;
    return a.projection == b.projection && a.size == b.size && a.focal_px == b.focal_px && a.centre_px == b.centre_px &&
           at.rotation.coeffs() == to.rotation.coeffs() && at.translation == to.translation;
  }

  /// @param cabin  takes what is told of seat and head: they come first, for the cases' boxes are those of the seat
  Occupancy process(const StereoFrame& frame, Json& cabin) {
    cabin = watch_.take(frame);
    return monitor_.process(scan_.of(frame), watch_.seat());
  }
  const CabinWatch& watch() const { return watch_; }

 private:
  Rectification rectification_;
  CabinWatch watch_;
  StereoScan scan_;
  OccupancyMonitor monitor_;
};

std::string classify_stereo(const Flags& flags, const std::vector<std::string>& files, const CaseBase& base,
                            Answers& answers) {
  const StereoCabin cabin = read_stereo_cabin(flags.vehicle);
  std::optional<StereoSeat> seat;
  nlohmann::json shown = nlohmann::json::array();
  for (const std::string& file : files) {
    const bool on_page = !flags.page.empty() && std::ssize(shown) < kMostPageFrames;
    const StereoFrameInput input(file, on_page);
    if (!seat) {
      seat.emplace(cabin, input, base);
      if (input.nearest_m > kNear_m) {
        say_warning(
            fmt::format("{}: nothing nearer than {:.2f} m was searched, where a hand may be; use `raybundle "
                        "reconstruct stereo --near 0.25`",
                        file, input.nearest_m));
      }
    }
    if (!seat->took(input)) {
      throw Error(ErrorKind::kBadInput,
                  fmt::format("is of another pair than {}, or rectified otherwise; classify them apart", files.front()),
                  file);
    }
    const StereoFrame frame = input.frame();
    Json more;
    const Occupancy occupancy = seat->process(frame, more["cabin"]);
    const Json& answer = answers.add(file, occupancy, more);
    if (!on_page) continue;
    shown.push_back(stereo_page_frame(input.name, frame));
    shown.back().update(seat->watch().on_page());
    shown.back()["answer"] = answer;
  }
  if (flags.page.empty()) return "";
  if (shown.size() < files.size())
    say(fmt::format("the page shows the first {} of {} frames", shown.size(), files.size()));
  return stereo_page(shown);
}

void run(const Flags& flags) {
  const CaseBase base = case_base_from_bytes(text_of_file(flags.base), flags.base);
  const std::vector<std::string> files = files_of(flags.points);
  if (!flags.page.empty()) require_writable_file(flags.page, "--page");
  Answers answers(base);
  const bool stereo = sensor_kind_of(base) == SensorKind::kStereo;
  // Points of the other sensor come with a vehicle file that lacks what this one has: the points say which it is.
  read_points_json(files.front(), stereo ? kStereoPoints : kLaserPoints, [](const nlohmann::json&) {});
  const std::string page = (stereo ? classify_stereo : classify_laser)(flags, files, base, answers);
  if (!flags.page.empty()) write_file_whole(flags.page, page);
  fmt::print("{}", flags.json ? answers.json() : answers.text());
  if (!answers.any()) throw GateFailed{};
}

}  // namespace

void add_occupancy_classify(CLI::App& occupancy) {
  auto flags = std::make_shared<Flags>();
  CLI::App* verb = occupancy.add_subcommand("classify", "points of the frames of one seat, in their order");
  verb->add_option("base", flags->base, "what `occupancy learn` wrote for that sensor")->required();
  verb->add_option("points", flags->points, "what `reconstruct` wrote: JSON, patterns in quotes, or a folder")
      ->required();
  verb->add_option("--vehicle", flags->vehicle, "where dashboard and sensor are (docs/formats/occupancy.md)")
      ->type_name("TOML")
      ->required();
  verb->add_option("--page", flags->page, "an HTML page of the frames to write")->type_name("FILE");
  verb->add_flag("--json", flags->json, "print the result as JSON");
  verb->footer(
      "Exit code 1 when every frame is INVALID: nothing was answered.\n"
      "Example, of a pair of cameras:\n"
      "  raybundle reconstruct stereo calibration.json 'left*.png' 'right*.png' --near 0.25 -o points\n"
      "  raybundle occupancy classify seats.rbcases points --vehicle vehicle.toml --page seats.html");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
