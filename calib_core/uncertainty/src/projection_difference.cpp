// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "projection_difference.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "motion_fit.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/uncertainty/image_cells.hpp"
#include "sensitivity.hpp"

namespace raybundle {
namespace {

constexpr int kFewestCells = 6;       // that a motion is fitted to
constexpr double kLeastWeight = 0.1;  // of the largest sigma: no cell counts more than a hundred times another

// A cell that both calibrations saw.
struct Cell {
  Eigen::Index row = 0, column = 0;
  Eigen::Vector2d pixel;     // of a
  Eigen::Vector3d ray_in_a;  // unit
  double weight = 1.0;
};

std::vector<Cell> covered_cells(const RigCamera& a, int columns) {
  const int rows = rows_of_square_cells(a.camera.size, columns);
  std::vector<Cell> cells;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d pixel = middle_of_cell(a.camera.size, rows, columns, row, column);
      if (!a.evidence->covers(a.camera.size, pixel)) continue;
      const std::optional<Eigen::Vector3d> ray = ray_from_pixel(a.camera, pixel);
      if (ray) cells.push_back({row, column, pixel, *ray, 1.0});
    }
  }
  return cells;
}

std::vector<Cell> common_cells(const RigCamera& a, const RigCamera& b, int columns) {
  std::vector<Cell> cells = covered_cells(a, columns);
  std::erase_if(cells, [&](const Cell& cell) {
    return !b.evidence->covers(b.camera.size, cell.pixel) || !ray_from_pixel(b.camera, cell.pixel);
  });
  return cells;
}

// A camera that does not tell where its corners were is looked at where another calibration's were.
RigCamera with_corners_of(const RigCamera& other, RigCamera camera) {
  if (camera.evidence || !other.evidence) return camera;
  camera.evidence = other.evidence;
  camera.evidence->implied_motion.setZero(6, camera.camera.parameters.size());
  return camera;
}

void require_cells(const RigCamera& a, const std::vector<Cell>& cells) {
  if (static_cast<int>(cells.size()) >= kFewestCells) return;
  throw Error(ErrorKind::kBadInput, "the two calibrations of camera " + a.name +
                                        " saw corners in common in hardly any part of the image; there is nothing to "
                                        "compare");
}

Lens lens_of(const Camera& camera) {
  return [&camera](const Eigen::Vector3d& ray) -> std::optional<SeenRay> {
    const std::optional<Eigen::Vector2d> pixel = pixel_from_ray(camera, ray);
    const std::optional<PixelDerivatives> derivatives = pixel_derivatives(camera, ray);
    if (!pixel || !derivatives) return std::nullopt;
    return SeenRay{*pixel, derivatives->by_ray};
  };
}

Eigen::Vector3d moved(const Rigid3& b_from_a, const Eigen::Vector3d& ray, double range_m) {
  return b_from_a.rotation * ray + b_from_a.translation / range_m;
}

// Gauss-Newton from standing still; lenses of one camera differ by little.
Rigid3 fitted_motion(const Lens& b, const std::vector<Cell>& cells, double range_m) {
  constexpr int kIterations = 10;
  Rigid3 b_from_a;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    MotionFit fit(1);
    for (const Cell& cell : cells) {
      const Eigen::Vector3d ray = moved(b_from_a, cell.ray_in_a, range_m);
      const std::optional<SeenRay> seen = b(ray);
      if (seen) fit.add(by_motion_at(seen->by_ray, ray, range_m), seen->pixel - cell.pixel, cell.weight);
    }
    const Eigen::Matrix<double, 6, 1> step = fit.undoing();
    b_from_a = perturbed(Rigid3{}, step) * b_from_a;
    if (step.norm() < 1e-14) break;
  }
  return b_from_a;
}

// Uncertainty of one calibration's part in the difference: what its parameters do after the fitted motion followed.
ProjectionUncertainty after_fit(const RigCamera& camera, const Covariance& covariance, const std::vector<Cell>& cells,
                                double range_m) {
  ProjectionUncertainty uncertainty = projection_uncertainty(camera, covariance);
  MotionFit fit(camera.camera.parameters.size());
  for (const Cell& cell : cells) {
    const std::optional<Eigen::Vector3d> ray = ray_from_pixel(camera.camera, cell.pixel);
    const std::optional<PixelDerivatives> derivatives = pixel_derivatives(camera.camera, *ray);
    if (derivatives) fit.add(by_motion_at(derivatives->by_ray, *ray, range_m), derivatives->by_intrinsics, cell.weight);
  }
  uncertainty.implied_motion = fit.undoing();
  return uncertainty;
}

double sigma_at(const ProjectionUncertainty& uncertainty, const Eigen::Vector2d& pixel, double range_m) {
  const std::optional<Eigen::Matrix2d> covariance = projection_covariance(uncertainty, pixel, range_m);
  return covariance ? largest_sigma(*covariance) : std::nan("");
}

// Well-known cells decide the fit.
void weigh(const ProjectionUncertainty& a, const ProjectionUncertainty& b, double range_m, std::vector<Cell>& cells) {
  std::vector<double> sigmas;
  double largest = 0.0;
  for (const Cell& cell : cells) {
    const double sigma = sigma_at(a, cell.pixel, range_m) + sigma_at(b, cell.pixel, range_m);
    sigmas.push_back(sigma);
    if (std::isfinite(sigma)) largest = std::max(largest, sigma);
  }
  for (std::size_t i = 0; i < cells.size() && largest > 0.0; ++i) {
    const double sigma = std::isfinite(sigmas[i]) ? std::max(sigmas[i], kLeastWeight * largest) : largest;
    cells[i].weight = largest * largest / (sigma * sigma);
  }
}

void summarize(ProjectionDifference& difference) {
  int cells = 0;
  double squares = 0.0;
  for (Eigen::Index i = 0; i < difference.u_px.size(); ++i) {
    const double distance = std::hypot(difference.u_px.data()[i], difference.v_px.data()[i]);
    if (!std::isfinite(distance)) continue;
    ++cells;
    squares += distance * distance;
    difference.largest_px = std::max(difference.largest_px, distance);
  }
  difference.covered_share = static_cast<double>(cells) / static_cast<double>(difference.u_px.size());
  difference.share_within = share_within(difference, kMostSummedSigmas);
  if (cells > 0) difference.rms_px = std::sqrt(squares / cells);
}

// A lens may end within the cell of evidence that holds its outermost corner, but not before it.
double lost_share(const RigCamera& a, const RigCamera& b, const ProjectionDifference& difference) {
  const auto rows = static_cast<int>(difference.u_px.rows()), columns = static_cast<int>(difference.u_px.cols());
  std::map<int, bool> compared;  // anything of a cell of a's evidence
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d pixel = middle_of_cell(a.camera.size, rows, columns, row, column);
      if (!a.evidence->covers(a.camera.size, pixel) || !b.evidence->covers(b.camera.size, pixel)) continue;
      if (!ray_from_pixel(a.camera, pixel) && !ray_from_pixel(b.camera, pixel)) continue;
      compared[*a.evidence->cell(a.camera.size, pixel)] |= std::isfinite(difference.u_px(row, column));
    }
  }
  const auto lost = std::ranges::count(compared, false, &std::pair<const int, bool>::second);
  return compared.empty() ? 0.0 : static_cast<double>(lost) / static_cast<double>(compared.size());
}

// The map of a's cells; sigmas are filled in later.
ProjectionDifference difference_of(const RigCamera& a, const Lens& b, const std::vector<Cell>& cells, double range_m,
                                   int columns) {
  ProjectionDifference difference;
  difference.camera = a.name;
  difference.size = a.camera.size;
  difference.range_m = range_m;
  difference.u_px = Eigen::MatrixXd::Constant(rows_of_square_cells(a.camera.size, columns), columns, std::nan(""));
  difference.v_px = difference.sigma_px = difference.u_px;
  difference.b_from_a = fitted_motion(b, cells, range_m);
  for (const Cell& cell : cells) {
    const std::optional<SeenRay> seen = b(moved(difference.b_from_a, cell.ray_in_a, range_m));
    if (!seen) continue;
    difference.u_px(cell.row, cell.column) = seen->pixel.x() - cell.pixel.x();
    difference.v_px(cell.row, cell.column) = seen->pixel.y() - cell.pixel.y();
  }
  return difference;
}

}  // namespace

ProjectionDifference projection_difference(const RigCamera& camera_a, const Covariance& covariance_a,
                                           const RigCamera& camera_b, const Covariance& covariance_b, double range_m,
                                           int columns) {
  if (!camera_a.evidence && !camera_b.evidence) {
    throw Error(ErrorKind::kBadInput, "neither calibration tells where the corners of camera " + camera_a.name +
                                          " were; compare with one that was solved from corners");
  }
  const RigCamera a = with_corners_of(camera_b, camera_a), b = with_corners_of(camera_a, camera_b);
  const ProjectionUncertainty alone_a = projection_uncertainty(a, covariance_a);
  const ProjectionUncertainty alone_b = projection_uncertainty(b, covariance_b);
  std::vector<Cell> cells = common_cells(a, b, columns);
  require_cells(a, cells);
  weigh(alone_a, alone_b, range_m, cells);
  ProjectionDifference difference = difference_of(a, lens_of(b.camera), cells, range_m, columns);
  const ProjectionUncertainty fitted_a = after_fit(a, covariance_a, cells, range_m);
  const ProjectionUncertainty fitted_b = after_fit(b, covariance_b, cells, range_m);
  for (const Cell& cell : cells) {
    if (!std::isfinite(difference.u_px(cell.row, cell.column))) continue;
    difference.sigma_px(cell.row, cell.column) =
        sigma_at(fitted_a, cell.pixel, range_m) + sigma_at(fitted_b, cell.pixel, range_m);
  }
  difference.lost_share = lost_share(a, b, difference);
  summarize(difference);
  return difference;
}

ProjectionDifference projection_difference(const RigCamera& a, const Covariance& covariance_a, const Lens& b,
                                           int columns) {
  const ProjectionUncertainty alone = projection_uncertainty(a, covariance_a);
  std::vector<Cell> cells = covered_cells(a, columns);
  require_cells(a, cells);
  weigh(alone, alone, kInfinitelyFar, cells);
  ProjectionDifference difference = difference_of(a, b, cells, kInfinitelyFar, columns);
  const ProjectionUncertainty fitted = after_fit(a, covariance_a, cells, kInfinitelyFar);
  for (const Cell& cell : cells) {
    if (!std::isfinite(difference.u_px(cell.row, cell.column))) continue;
    difference.sigma_px(cell.row, cell.column) = 2.0 * sigma_at(fitted, cell.pixel, kInfinitelyFar);
  }
  summarize(difference);
  return difference;
}

ProjectionDifference less(ProjectionDifference difference, const ProjectionDifference& known) {
  difference.u_px -= known.u_px;
  difference.v_px -= known.v_px;
  difference.largest_px = 0.0;
  summarize(difference);
  return difference;
}

}  // namespace raybundle
