// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>

#include "folder_watch.hpp"
#include "former_frames.hpp"
#include "image_files.hpp"
#include "laser_frame_files.hpp"
#include "laser_images.hpp"
#include "output_folder.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "reconstruct.hpp"
#include "sensor_input.hpp"
#include "state_name.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEndings[] = {".json", ".ply", ".glb", ".html"};

struct Flags {
  std::string sensor;
  std::vector<std::string> images, off;
  std::string output, watch, labeller{kLabellers.front().name};
  int frames = 0;
  SensorFlags table;
  bool json = false;
};

std::vector<std::string> files_of(const std::vector<std::string>& patterns) {
  return patterns.empty() ? patterns : matching_files("", patterns);
}

StructuredLightOptions options_of(const Flags& flags) {
  StructuredLightOptions options;
  options.labeller = *std::ranges::find(kLabellers, flags.labeller, &Labeller::name);
  return options;
}

/// Takes images one after the other and writes what they say.
class Reconstruction {
 public:
  explicit Reconstruction(const Flags& flags)
      : flags_(flags), table_(sensor_of(flags.sensor, flags.table)), sensor_(table_, options_of(flags)) {
    require_writable(flags.output);
    if (flags.json) return;
    fmt::print("{:<24} {:>5} {:>8} {:>10} {:>9} {:>10}  {}\n", "image", "dots", "labelled", "triangles", "depth m",
               "sigma mm", "state");
  }

  /// @return  whether to go on: not once there are --frames
  bool take(const LaserShot& shot) {
    for_each_moment(shot, table_, bits_, [&](const ShotImages& images, const std::string& name) {
      take(images, name, shot.on);
      return taken() != flags_.frames;
    });
    return taken() != flags_.frames;
  }

  int taken() const { return static_cast<int>(names_.size()); }

  void finish() const {
    if (names_.empty()) say("no image came");
    // What a watch has written before it was started again cannot be made again.
    const bool watching = !flags_.watch.empty();
    if (!names_.empty() && !watching) remove_former_frames(flags_.output, kLaserPoints, kEndings, names_);
    if (!flags_.json && !names_.empty()) {
      fmt::print("\nwrote {}: points in JSON, PLY and GLB, and a page, for each image\n", flags_.output);
    }
    if (state_ == State::kInvalid) throw GateFailed{};
  }

 private:
  void take(const ShotImages& images, const std::string& name, const std::string& path) {
    if (names_.contains(name)) {
      throw Error(ErrorKind::kBadInput,
                  "two images are called " + name +
                      ", and their results would be one file; "
                      "reconstruct them into folders of their own",
                  path);
    }
    const LaserFrame& frame = sensor_.process(view_of(images.on), view_of(images.off));
    const LaserFrameFiles files = laser_frame_files(frame, table_, path, images.on);
    const fs::path folder(flags_.output);
    const std::string_view bytes[] = {files.json, files.ply, files.glb, files.html};
    static_assert(std::size(bytes) == std::size(kEndings));
    std::vector<WholeFile> named;
    for (std::size_t i = 0; i < std::size(kEndings); ++i) named.push_back({folder / (name + kEndings[i]), bytes[i]});
    write_results(folder, named);
    flags_.json ? static_cast<void>(fmt::print("{}\n", files.json)) : print_row(name, frame);
    names_.insert(name);
    state_ = frame.state;
    const bool turned = frame.health.state == State::kInvalid;
    if (turned && !turned_) say_turned(name, frame.health);  // an alarm stays, the figures that raised it do not
    turned_ = turned;
  }

  static void say_turned(const std::string& name, const HealthReport& health) {
    const bool lately = health.recent_chi_squared > health.chi_squared;
    const Eigen::Vector3d& turn = lately ? health.recent_turn_rad : health.turn_rad;
    say_warning(
        fmt::format("{}: the projector seems to have turned by {:.2f} mrad {} (chi-squared {:.0f}, alarm above "
                    "{:.0f}); calibrate again",
                    name, 1e3 * turn.norm(), lately ? "in the last images" : "since its calibration",
                    std::max(health.chi_squared, health.recent_chi_squared), health.threshold));
  }

  static void print_row(const std::string& name, const LaserFrame& frame) {
    std::vector<double> depths, sigmas;
    for (const LaserPoint& point : frame.points) {
      depths.push_back(point.x_in_camera.z());
      sigmas.push_back(1e3 * std::sqrt(point.covariance(2, 2)));
    }
    const bool none = depths.empty();
    fmt::print("{:<24} {:>5} {:>8} {:>10} {:>9} {:>10}  {}\n", name, frame.dots.size(), frame.points.size(),
               frame.mesh.size(), none ? "-" : fmt::format("{:.3f}", median(depths)),
               none ? "-" : fmt::format("{:.1f}", median(sigmas)), state_name(frame.state));
    std::fflush(stdout);
  }

  const Flags& flags_;
  SensorTable table_;
  StructuredLight sensor_;
  EightBits bits_;
  std::set<std::string> names_;
  State state_ = State::kOk;
  bool turned_ = false;  // the projector, and it has been said
};

void run(const Flags& flags) {
  if (flags.images.empty() == flags.watch.empty()) {
    throw Error(ErrorKind::kBadInput, "give images or a video, or a folder with --watch, and not both");
  }
  if (!flags.watch.empty() && !flags.off.empty()) {
    throw Error(ErrorKind::kBadInput, "--watch takes images with the laser on only; leave out --off");
  }
  const std::vector<LaserShot> shots = laser_shots(files_of(flags.images), files_of(flags.off));
  Reconstruction reconstruction(flags);
  for (const LaserShot& shot : shots) {
    if (!reconstruction.take(shot)) break;
  }
  if (is_video(flags.watch)) {
    reconstruction.take({flags.watch, ""});
  } else if (!flags.watch.empty()) {
    watch_folder(flags.watch, [&](const std::string& path) { return reconstruction.take({path, ""}); });
  }
  reconstruction.finish();
}

}  // namespace

void add_structured_light_reconstruction(CLI::App& reconstruct) {
  auto flags = std::make_shared<Flags>();
  CLI::App* verb = reconstruct.add_subcommand("structured-light", "images of laser dots -> labelled points and a mesh");
  verb->add_option("sensor", flags->sensor, "calibration.json, or a table of `export --runtime structured-light`")
      ->required()
      ->type_name("CALIBRATION");
  verb->add_option("images", flags->images, "with the laser on, or a video; patterns in quotes")->type_name("IMAGE");
  verb->add_option("--off", flags->off, "the same moments with the laser off: of the same digits, or in the same order")
      ->type_name("IMAGE");
  verb->add_option("-o,--output", flags->output, "folder to write; frames of a former run in it are removed")
      ->type_name("DIR")
      ->required();
  verb->add_option("--watch", flags->watch, "take images as they come into a folder, until interrupted, or a video")
      ->type_name("DIR");
  verb->add_option("--frames", flags->frames, "end after so many")->check(CLI::Range(1, 1 << 30));
  std::vector<std::string> names;
  for (const Labeller& labeller : kLabellers) names.emplace_back(labeller.name);
  verb->add_option("--labels", flags->labeller, "how dots get their beams")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  declare_sensor_flags(*verb, flags->table);
  verb->add_flag("--json", flags->json, "print the results as JSON, one after the other");
  verb->footer(
      "Exit code 1 when the last image's state is INVALID: nothing was seen, or the calibration no longer holds.\n"
      "Example:\n"
      "  raybundle simulate datasets/rigs/rig_26mm_laser.toml --frames 60 --seed 7 -o sim\n"
      "  raybundle calibrate sim/dataset.toml -o out\n"
      "  raybundle reconstruct structured-light out/calibration.json sim/images/camera/000_on.png "
      "--off sim/images/camera/000_off.png "
      "-o points");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
