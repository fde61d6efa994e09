// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <tuple>

#include "chosen_camera.hpp"
#include "export.hpp"
#include "foreign_files.hpp"
#include "number_flags.hpp"
#include "output_folder.hpp"
#include "page_text.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/initialize/nearest_camera.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/io/foreign_format.hpp"
#include "raybundle/uncertainty/frame_covariance.hpp"
#include "raybundle/uncertainty/projection_uncertainty.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

struct ForeignFlags {
  std::string to, lens;
  double within_deg = 180.0;
  double max_px = 0.1;
};

// A camera on its way into another format.
struct Converted {
  RigCamera camera;  // as the format can hold it
  const ForeignLens* lens = nullptr;
  bool same = false;  // the format holds the lens as it is
  std::vector<PixelRay> rays;
  CameraDifference difference = {};     // of what the files say from the camera that was asked for
  std::optional<double> sigma_px = {};  // of the calibration itself, where the difference is largest

  Eigen::Matrix<double, 6, 1> moved = Eigen::Matrix<double, 6, 1>::Zero();  // its place in the files, as perturbed()

  bool within(double max_px) const {
    constexpr double kRounding = 1e-9;  // [rad], [m]
    return difference.lost_share == 0.0 && difference.largest_px <= max_px && moved.norm() <= kRounding;
  }
};

// Whether a conversion may aim at a lens: all that it lacks can be held at zero.
bool is_aim(const ForeignLens& lens) {
  if (lens.places.starts_with("f ")) return false;  // of a wider one
  const Camera start = start_camera(lens.model, {2, 2}, 1.0);
  return std::ranges::all_of(parameters_without_place(lens), [&](int i) { return start.parameters[i] == 0.0; });
}

// The difference over what the other program projects by a lens; the rays beyond are lost.
CameraDifference seen_by(const ForeignLens& lens, const std::vector<PixelRay>& rays, const Camera& camera) {
  std::vector<PixelRay> seen;
  std::ranges::copy_if(rays, std::back_inserter(seen), [&](const PixelRay& each) {
    return std::atan2(each.ray.head<2>().norm(), each.ray.z()) < lens.max_angle_rad;
  });
  CameraDifference difference = difference_over(seen, camera);
  const double seen_share = static_cast<double>(seen.size()) / static_cast<double>(rays.size());
  difference.lost_share = 1.0 - seen_share * (1.0 - difference.lost_share);
  return difference;
}

Converted converted(const RigCamera& camera, const ForeignFormat& format, const ForeignFlags& flags) {
  Converted best{.camera = camera,
                 .lens = lens_for(format, camera.camera),
                 .rays = rays_over_image(camera.camera, flags.within_deg * std::numbers::pi / 180.0)};
  if (best.rays.empty()) {
    throw Error(ErrorKind::kBadInput,
                "no pixel has a ray within " + fmt::format("{:g}", flags.within_deg) +
                    " degrees of the axis; give a larger --within",
                camera.name);
  }
  for (const ForeignLens& lens : format.lenses) {
    if (lens.name == flags.lens && holds(format, lens, camera.camera)) best.lens = &lens;
  }
  if (best.lens != nullptr && !flags.lens.empty() && best.lens->name != flags.lens) best.lens = nullptr;
  if (best.lens != nullptr) best.difference = seen_by(*best.lens, best.rays, camera.camera);
  best.same = best.lens != nullptr;
  if (best.same && best.difference.lost_share == 0.0) return best;
  const auto badness = [](const CameraDifference& d) { return std::tuple(d.lost_share, d.largest_px); };
  for (const ForeignLens& lens : format.lenses) {
    if ((!flags.lens.empty() && lens.name != flags.lens) || !is_aim(lens)) continue;
    RigCamera candidate = camera;
    candidate.camera = nearest_camera(best.rays, camera.camera, lens.model, parameters_without_place(lens));
    if (!holds(format, lens, candidate.camera)) continue;  // the program refuses such values
    const CameraDifference difference = seen_by(lens, best.rays, candidate.camera);
    if (best.lens != nullptr && badness(difference) >= badness(best.difference)) continue;
    best.camera = candidate;
    best.lens = &lens;
    best.same = false;
    best.difference = difference;
  }
  if (best.lens == nullptr) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("{} takes no lens{} like this {} one; choose another format", format.name,
                            flags.lens.empty() ? "" : " " + flags.lens, model_name(camera.camera.model)),
                camera.name);
  }
  return best;
}

// Reads the files back, so that the differences are those of the files, digits and all.
void measure(const ForeignFormat& format, const std::vector<NamedText>& files, std::vector<Converted>& cameras) {
  std::vector<RigCamera> rig;
  if (format.holds_extrinsics) rig = rig_from_texts(format, files);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    Converted& camera = cameras[i];
    // One file for each, before any other.
    const Camera back = rig.empty() ? rig_from_texts(format, {&files[i], 1})[0].camera : rig[i].camera;
    camera.difference = seen_by(*camera.lens, camera.rays, back);
    if (rig.empty()) continue;
    const Rigid3 from_first = camera.camera.camera_from_rig * cameras[0].camera.camera_from_rig.inverse();
    camera.moved = motion_between(from_first, rig[i].camera_from_rig);
  }
}

// How well the calibration knows where a camera sees far points, by corners or by frames, whichever tells less; nothing
// when it does not say.
std::optional<double> sigma_at(const Calibration& calibration, const RigCamera& camera, const Eigen::Vector2d& pixel) {
  if (!camera.evidence || calibration.covariance.names.empty() || !ray_from_pixel(camera.camera, pixel)) {
    return std::nullopt;
  }
  return larger_sigma(calibration, [&](const Covariance& covariance) {
    const auto at = projection_covariance(projection_uncertainty(camera, covariance), pixel, kInfinitelyFar);
    return at ? largest_sigma(*at) : 0.0;
  });
}

std::string miss(const Converted& camera, const ForeignFormat& format, const ForeignFlags& flags) {
  const CameraDifference& d = camera.difference;
  std::string what =
      d.lost_share > 0.0
          ? fmt::format("does not see {:.0f} % of the image", std::max(1.0, 100.0 * d.lost_share))
          : fmt::format("is up to {:.2g} px off, at ({:.0f}, {:.0f}), and {:g} px are allowed (--max-px)", d.largest_px,
                        d.largest_at.x(), d.largest_at.y(), flags.max_px);
  return fmt::format("{}: {}, the{} lens of {}, {}; keep less of the image with --within DEG, or choose another format",
                     camera.camera.name, camera.lens->name, camera.same || !flags.lens.empty() ? "" : " nearest",
                     format.name, what);
}

void print_text(const std::vector<Converted>& cameras, const std::vector<RigCamera>& rig) {
  std::vector<std::vector<std::string>> rows{
      {"camera", "lens here", "lens there", "rms [px]", "largest [px]", "at", "known to [px]"}};
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Converted& c = cameras[i];
    rows.push_back({c.camera.name, std::string(model_name(rig[i].camera.model)),
                    std::string(c.lens->name) + (c.same ? ", the same" : ", the nearest"),
                    fmt::format("{:.2g}", c.difference.rms_px), fmt::format("{:.2g}", c.difference.largest_px),
                    fmt::format("({:.0f}, {:.0f})", c.difference.largest_at.x(), c.difference.largest_at.y()),
                    c.sigma_px ? fmt::format("{:.2g}", *c.sigma_px) : "-"});
  }
  fmt::print("{}", text_table(rows));
}

void print_json(const std::vector<Converted>& cameras, const std::vector<fs::path>& paths,
                const std::vector<std::string>& missed) {
  nlohmann::ordered_json json{
      {"passed", missed.empty()}, {"missed", missed}, {"files", nlohmann::ordered_json::array()}};
  for (const fs::path& path : paths) json["files"].push_back(path.string());
  for (const Converted& c : cameras) {
    json["cameras"].push_back({{"name", c.camera.name},
                               {"lens", c.lens->name},
                               {"same_lens", c.same},
                               {"rms_px", c.difference.rms_px},
                               {"largest_px", c.difference.largest_px},
                               {"largest_at_px", {c.difference.largest_at.x(), c.difference.largest_at.y()}},
                               {"sigma_there_px", c.sigma_px ? nlohmann::ordered_json(*c.sigma_px) : nullptr},
                               {"lost_share", c.difference.lost_share},
                               {"place_error_rad", c.moved.head<3>().norm()},
                               {"place_error_m", c.moved.tail<3>().norm()}});
  }
  fmt::print("{}\n", text_of_json(json, 2));
}

std::vector<fs::path> write(const ForeignFormat& format, const std::vector<NamedText>& files, const fs::path& output) {
  const bool one_file = !format.file.empty();
  std::vector<fs::path> paths;
  std::vector<WholeFile> whole;
  for (const NamedText& file : files) paths.push_back(one_file ? output : output / file.name);
  for (std::size_t i = 0; i < files.size(); ++i) whole.push_back({paths[i], files[i].text});
  one_file ? write_files_whole(whole) : write_results(output, whole);
  return paths;
}

bool run(const ExportRequest& request, const ForeignFlags& flags) {
  if (flags.to.empty()) return false;
  const ForeignFormat& format = *foreign_format_named(flags.to);
  if (request.output.empty()) {
    throw Error(ErrorKind::kBadInput, format.file.empty()
                                          ? fmt::format("where to? Give -o FOLDER, as in -o {}", flags.to)
                                          : fmt::format("where to? Give -o FILE, as in -o {}", format.file));
  }
  format.file.empty() ? require_writable(request.output) : require_writable_file(request.output, "--output");
  require_lens(format, flags.lens);
  require_other_file({request.calibration}, request.output);
  const CalibrationFile file = read_calibration(request.calibration);
  std::vector<RigCamera> rig = file.calibration.cameras;
  if (!request.camera.empty()) rig = {chosen_camera(file.calibration, request.camera)};

  std::vector<Converted> cameras;
  std::vector<ForeignCamera> theirs;
  for (const RigCamera& camera : rig) {
    cameras.push_back(converted(camera, format, flags));
    theirs.push_back({cameras.back().camera, cameras.back().lens});
  }
  const std::vector<NamedText> files = texts_from_rig(format, theirs);
  measure(format, files, cameras);
  std::vector<std::string> missed;
  for (std::size_t i = 0; i < rig.size(); ++i) {
    Converted& camera = cameras[i];
    camera.sigma_px = sigma_at(file.calibration, rig[i], camera.difference.largest_at);
    if (!camera.within(flags.max_px)) missed.push_back(miss(camera, format, flags));
  }
  const std::vector<fs::path> paths = missed.empty() ? write(format, files, request.output) : std::vector<fs::path>{};
  if (request.json) {
    print_json(cameras, paths, missed);
  } else {
    print_text(cameras, rig);
    for (const fs::path& path : paths) fmt::print("wrote {}\n", path.string());
    for (const std::string& sentence : missed) fmt::print("FAIL  {}\n", sentence);
  }
  if (!missed.empty()) throw GateFailed{};
  if (file.calibration.laser) say("the laser's beams stay behind: no other program has them");
  return true;
}

}  // namespace

Export add_foreign_export(CLI::App& verb) {
  auto flags = std::make_shared<ForeignFlags>();
  CLI::Option* to = verb.add_option("--to", flags->to, "another program's files: " + formats_help())
                        ->type_name("FORMAT")
                        ->check(CLI::IsMember(format_names()));
  const auto add = [&](const char* name, auto& value, const char* help) {
    return verb.add_option(name, value, help)->needs(to);
  };
  add("--lens", flags->lens, "what the format calls the lens to write; the same or the nearest one unless said")
      ->type_name("NAME");
  add("--within", flags->within_deg, "degrees off the axis up to which a lens is converted and compared [deg]")
      ->check(CLI::Range(1.0, 180.0))
      ->capture_default_str();
  add("--max-px", flags->max_px, "gate: no ray may land farther from where it does now [px]")
      ->check(above_zero)
      ->capture_default_str();
  return [flags](const ExportRequest& request) { return run(request, *flags); };
}

}  // namespace raybundle::apps
