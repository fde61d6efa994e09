// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <algorithm>
#include <array>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "chosen_camera.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/scene/number.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

struct ProjectFlags {
  std::string calibration;
  std::string camera;
};

// Numbers of a line, separated by commas or blanks.
template <std::size_t count>
std::array<double, count> numbers_in(const std::string& line, int number) {
  constexpr std::string_view kBetween = ", \t\r";
  std::string_view rest = line;
  const auto skip = [&] { rest.remove_prefix(std::min(rest.find_first_not_of(kBetween), rest.size())); };
  std::array<double, count> values{};
  for (double& value : values) {
    skip();
    const std::string_view word = rest.substr(0, rest.find_first_of(kBetween));
    const std::optional<double> found = number_from<double>(word);
    if (!found) {
      throw Error(ErrorKind::kBadInput, fmt::format("'{}' is not {} numbers separated by commas", line, count),
                  fmt::format("standard input:{}", number));
    }
    value = *found;
    rest.remove_prefix(word.size());
  }
  skip();
  if (!rest.empty()) {
    throw Error(ErrorKind::kBadInput, fmt::format("'{}' has more than {} numbers", line, count),
                fmt::format("standard input:{}", number));
  }
  return values;
}

// Numbers separated by commas; all nan, without a sign, where there is no answer.
template <typename Vector>
std::string line_of(const std::optional<Vector>& values) {
  const bool known = values && values->allFinite();
  std::string line;
  for (Eigen::Index i = 0; i < Vector::RowsAtCompileTime; ++i) {
    line += (line.empty() ? "" : ",") + (known ? fmt::format("{}", (*values)[i]) : std::string("nan"));
  }
  return line;
}

// Answers each line of stdin with a line on stdout; nan where there is no answer.
template <std::size_t in, typename Answer>
void answer_lines(const ProjectFlags& flags, Answer&& answer) {
  const CalibrationFile file = read_calibration(flags.calibration);
  const RigCamera& camera = chosen_camera(file.calibration, flags.camera);
  std::string line;
  for (int number = 1; std::getline(std::cin, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    fmt::print("{}\n", answer(camera.camera, numbers_in<in>(line, number)));
  }
}

void declare(CLI::App& verb, ProjectFlags& flags) {
  verb.add_option("calibration", flags.calibration, "calibration.json")->required()->type_name("CALIBRATION");
  verb.add_option("--camera", flags.camera, "name; may be left out when there is only one")->type_name("NAME");
}

}  // namespace

void add_project_verb(CLI::App& app) {
  auto flags = std::make_shared<ProjectFlags>();
  CLI::App* verb = app.add_subcommand("project", "rays or points x,y,z in the camera's frame on stdin -> pixels u,v");
  declare(*verb, *flags);
  verb->footer(
      "One line of numbers in, one line out; nan,nan where the camera cannot see the ray.\n"
      "Example:\n  echo 0,0,1 | raybundle project out/calibration.json --camera left");
  verb->callback([flags] {
    answer_lines<3>(*flags, [](const Camera& camera, const std::array<double, 3>& ray) {
      return line_of(pixel_from_ray(camera, Eigen::Vector3d(ray.data())));
    });
  });
}

void add_unproject_verb(CLI::App& app) {
  auto flags = std::make_shared<ProjectFlags>();
  CLI::App* verb = app.add_subcommand("unproject", "pixels u,v on stdin -> unit rays x,y,z in the camera's frame");
  declare(*verb, *flags);
  verb->footer(
      "One line of numbers in, one line out; nan,nan,nan where no ray meets the pixel.\n"
      "Example:\n  echo 320,240 | raybundle unproject out/calibration.json --camera left");
  verb->callback([flags] {
    answer_lines<2>(*flags, [](const Camera& camera, const std::array<double, 2>& pixel) {
      return line_of(ray_from_pixel(camera, Eigen::Vector2d(pixel.data())));
    });
  });
}

}  // namespace raybundle::apps
