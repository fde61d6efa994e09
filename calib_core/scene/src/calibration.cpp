// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/calibration.hpp"

#include <algorithm>
#include <cmath>

#include "raybundle/geometry/error.hpp"

namespace raybundle {

double Covariance::sigma(const std::string& name) const {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return 0.0;
  const Eigen::Index i = found - names.begin();
  return std::sqrt(matrix(i, i));
}

std::vector<int> Covariance::places_of(const std::vector<std::string>& some) const {
  std::vector<int> places;
  for (const std::string& name : some) {
    const auto found = std::ranges::find(names, name);
    places.push_back(found == names.end() ? -1 : static_cast<int>(found - names.begin()));
  }
  return places;
}

Eigen::MatrixXd Covariance::block(const std::vector<std::string>& some) const {
  const std::vector<int> places = places_of(some);
  Eigen::MatrixXd part = Eigen::MatrixXd::Zero(std::ssize(places), std::ssize(places));
  for (Eigen::Index i = 0; i < part.rows(); ++i) {
    for (Eigen::Index j = 0; j < part.cols(); ++j) {
      const int row = places[static_cast<std::size_t>(i)], column = places[static_cast<std::size_t>(j)];
      if (row >= 0 && column >= 0) part(i, j) = matrix(row, column);
    }
  }
  return part;
}

std::optional<int> CornerEvidence::cell(ImageSize size, const Eigen::Vector2d& pixel) const {
  // Pixel (0, 0) is the centre of the first one, so that the image begins half a pixel before it.
  const double column = std::floor((pixel.x() + 0.5) * columns / size.width);
  const double row = std::floor((pixel.y() + 0.5) * rows / size.height);
  if (!(column >= 0.0 && row >= 0.0 && column < columns && row < rows)) return std::nullopt;
  return static_cast<int>(row) * columns + static_cast<int>(column);
}

bool CornerEvidence::covers(ImageSize size, const Eigen::Vector2d& pixel) const {
  const std::optional<int> here = cell(size, pixel);
  return here && corners[*here] > 0;
}

const RigCamera& camera_named(const Calibration& calibration, const std::string& name) {
  const auto found = std::ranges::find(calibration.cameras, name, &RigCamera::name);
  if (found != calibration.cameras.end()) return *found;
  std::string known;
  for (const RigCamera& camera : calibration.cameras) known += (known.empty() ? "" : ", ") + camera.name;
  throw Error(ErrorKind::kBadInput, "no camera is called '" + name + "'; there are: " + known);
}

}  // namespace raybundle
