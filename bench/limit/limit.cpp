// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "limit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#if defined(__x86_64__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define WIDE __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define WIDE
#endif

namespace raybundle::limit {
namespace {

constexpr int kUnknowns = 14;  // fx fy cx cy k1 k2 k3 k4, rotation, translation of the board in camera axes
constexpr int kColumns = 13;   // of u or of v, the residual being the last
constexpr int kMostCorners = 256;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector8 = Eigen::Matrix<double, 8, 1>;
using Normal = Eigen::Matrix<double, kUnknowns + 1, kUnknowns + 1>;  // of [J r], upper triangle

struct View {
  int padded = 0;  // to a multiple of four, with corners of no weight
  std::vector<double> x, y, u, v, weight;
};

struct Point {
  Vector8 camera;
  std::vector<Rigid3> poses;
};

struct Rows {
  alignas(32) double u[kColumns][kMostCorners];
  alignas(32) double v[kColumns][kMostCorners];
};

// atan2 for y >= 0 without a branch, so that it can be computed for several corners at once. Source: Cephes, atan.c.
[[gnu::always_inline]] inline double angle_of(double y, double x) {
  const double ax = std::fabs(x);
  const double small = y < ax ? y : ax;
  const double large = y < ax ? ax : y;
  const bool far = small > 0.41421356237309503 * large;
  const double numerator = far ? small - large : small;
  const double denominator = far ? small + large : large;
  const double t = numerator / denominator;
  const double z = t * t;
  const double p =
      (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z - 7.500855792314704667340e1) * z -
       1.228866684490136173410e2) *
          z -
      6.485021904942025371773e1;
  const double q =
      ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z + 4.328810604912902668951e2) * z +
       4.853903996359136964868e2) *
          z +
      1.945506571482613964425e2;
  double angle = t + t * (z * p / q);
  angle = far ? 0.78539816339744831 + angle : angle;
  angle = y > ax ? 1.5707963267948966 - angle : angle;
  return x < 0 ? 3.1415926535897931 - angle : angle;
}

WIDE void fill(const double* __restrict p, const double* __restrict r, const double* __restrict t,
               const double* __restrict bx, const double* __restrict by, const double* __restrict pu,
               const double* __restrict pv, const double* __restrict weight, int count, Rows& __restrict rows) {
  for (int i = 0; i < count; ++i) {
    const double qx = r[0] * bx[i] + r[3] * by[i], qy = r[1] * bx[i] + r[4] * by[i], qz = r[2] * bx[i] + r[5] * by[i];
    const double x = qx + t[0], y = qy + t[1], z = qz + t[2];
    const double rho2 = x * x + y * y + 1e-300;
    const double rho = std::sqrt(rho2), inverse_rho = 1 / rho, inverse_norm2 = 1 / (rho2 + z * z);
    const double a = angle_of(rho, z), a2 = a * a;
    const double radius = a * (1 + a2 * (p[4] + a2 * (p[5] + a2 * (p[6] + a2 * p[7]))));
    const double slope = 1 + a2 * (3 * p[4] + a2 * (5 * p[5] + a2 * (7 * p[6] + a2 * 9 * p[7])));
    const double c = x * inverse_rho, s = y * inverse_rho;
    const double tangential = radius * inverse_rho, difference = slope * z * inverse_norm2 - tangential;
    const double along = -slope * rho * inverse_norm2;
    const double w = weight[i], wu = w * p[0], wv = w * p[1];
    const double ux = wu * (tangential + difference * c * c), uy = wu * difference * c * s, uz = wu * along * c;
    const double vx = wv * difference * c * s, vy = wv * (tangential + difference * s * s), vz = wv * along * s;
    rows.u[0][i] = w * radius * c;
    rows.v[0][i] = w * radius * s;
    rows.u[1][i] = rows.v[1][i] = w;
    double power = a;
    for (int k = 0; k < 4; ++k) {
      power *= a2;
      rows.u[2 + k][i] = wu * power * c;
      rows.v[2 + k][i] = wv * power * s;
    }
    rows.u[6][i] = qy * uz - qz * uy;
    rows.u[7][i] = qz * ux - qx * uz;
    rows.u[8][i] = qx * uy - qy * ux;
    rows.v[6][i] = qy * vz - qz * vy;
    rows.v[7][i] = qz * vx - qx * vz;
    rows.v[8][i] = qx * vy - qy * vx;
    rows.u[9][i] = ux;
    rows.u[10][i] = uy;
    rows.u[11][i] = uz;
    rows.v[9][i] = vx;
    rows.v[10][i] = vy;
    rows.v[11][i] = vz;
    rows.u[12][i] = w * (p[0] * radius * c + p[2] - pu[i]);
    rows.v[12][i] = w * (p[1] * radius * s + p[3] - pv[i]);
  }
}

using Lane = double __attribute__((vector_size(32)));

WIDE void add_products(const double (*rows)[kMostCorners], int count, int axis, Normal& normal) {
  const auto full = [axis](int k) { return k < 2 ? 2 * k + axis : k + 2; };
  for (int a = 0; a < kColumns; a += 4) {
    for (int b = a / 3 * 3; b < kColumns; b += 3) {  // tiles of 4×3: their sums stay in registers
      const double* left[4];
      const double* right[3];
      for (int k = 0; k < 4; ++k) left[k] = rows[std::min(a + k, kColumns - 1)];
      for (int l = 0; l < 3; ++l) right[l] = rows[std::min(b + l, kColumns - 1)];
      Lane sum[4][3] = {};
      for (int i = 0; i < count; i += 4) {
        for (int k = 0; k < 4; ++k) {
          const Lane x = *reinterpret_cast<const Lane*>(left[k] + i);
          for (int l = 0; l < 3; ++l) sum[k][l] += x * *reinterpret_cast<const Lane*>(right[l] + i);
        }
      }
      for (int k = 0; k < 4; ++k) {
        for (int l = 0; l < 3; ++l) {
          const Lane& s = sum[k][l];
          if (a + k <= b + l && b + l < kColumns) normal(full(a + k), full(b + l)) += (s[0] + s[1]) + (s[2] + s[3]);
        }
      }
    }
  }
}

double linearize(const std::vector<View>& views, const Point& point, std::vector<Normal>& normals) {
  static Rows rows;
  double chi2 = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const View& view = views[i];
    const Eigen::Matrix3d rotation = point.poses[i].rotation.toRotationMatrix();
    fill(point.camera.data(), rotation.data(), point.poses[i].translation.data(), view.x.data(), view.y.data(),
         view.u.data(), view.v.data(), view.weight.data(), view.padded, rows);
    normals[i].setZero();
    add_products(rows.u, view.padded, 0, normals[i]);
    add_products(rows.v, view.padded, 1, normals[i]);
    chi2 += normals[i](kUnknowns, kUnknowns);
  }
  return 0.5 * chi2;
}

// The damped step from a point; what it should take off the cost is returned.
double step(const std::vector<Normal>& normals, double radius, const Point& from, Point& to) {
  using Follow = Eigen::Matrix<double, 6, 9>;
  static std::vector<Follow> follow;
  static std::vector<Vector6> damping;
  follow.resize(normals.size());
  damping.resize(normals.size());
  Eigen::Matrix<double, 9, 9> reduced = Eigen::Matrix<double, 9, 9>::Zero();
  Vector8 diagonal = Vector8::Zero();
  double alone = 0;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const Normal& n = normals[i];
    Eigen::Matrix<double, 6, 6> own = n.block<6, 6>(8, 8);
    damping[i] = own.diagonal() / radius;
    own.diagonal() += damping[i];
    Follow across;
    across << n.block<8, 6>(0, 8).transpose(), n.block<6, 1>(8, 14);
    follow[i] = own.selfadjointView<Eigen::Upper>().llt().solve(across);
    reduced.topLeftCorner<8, 8>() += n.topLeftCorner<8, 8>();
    reduced.topRightCorner<8, 1>() += n.topRightCorner<8, 1>();
    reduced.noalias() -= across.transpose() * follow[i];
    diagonal += n.diagonal().head<8>();
    alone += across.col(8).dot(follow[i].col(8));
  }
  Eigen::Matrix<double, 8, 8> matrix = reduced.topLeftCorner<8, 8>();
  matrix.diagonal() += diagonal / radius;
  const Vector8 change = -matrix.selfadjointView<Eigen::Upper>().llt().solve(reduced.topRightCorner<8, 1>());
  double damped = (diagonal.array() * change.array().square()).sum() / radius;
  to.camera = from.camera + change;
  to.poses.resize(from.poses.size());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const Vector6 motion = -follow[i].col(8) - follow[i].leftCols<8>() * change;
    damped += (damping[i].array() * motion.array().square()).sum();
    to.poses[i] = perturbed(from.poses[i], motion);
  }
  return 0.5 * (damped + alone - reduced.topRightCorner<8, 1>().dot(change));
}

std::vector<View> gather(const CalibrationProblem& problem) {
  std::vector<View> views(problem.views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::vector<Observation>& seen = problem.views[i].observations;
    View& view = views[i];
    view.padded = (static_cast<int>(seen.size()) + 3) / 4 * 4;
    for (std::vector<double>* values : {&view.x, &view.y, &view.u, &view.v, &view.weight}) values->resize(view.padded);
    for (std::size_t k = 0; k < seen.size(); ++k) {
      const TargetPoint* point = problem.targets[0].find(seen[k].point_id);
      view.x[k] = point->x_in_target.x();
      view.y[k] = point->x_in_target.y();
      view.u[k] = seen[k].pixel.x();
      view.v[k] = seen[k].pixel.y();
      view.weight[k] = 1 / seen[k].sigma_px;
    }
  }
  return views;
}

}  // namespace

BundleSummary solve(const CalibrationProblem& problem, BundleState& state) {
  const std::vector<View> views = gather(problem);
  Point point{state.cameras[0].parameters, {}};
  for (std::size_t i = 0; i < views.size(); ++i)
    point.poses.push_back(state.poses[state.pose_of_view[i]].rig_from_target);
  std::vector<Normal> here(views.size());
  std::vector<Normal> there(views.size());
  BundleSummary summary;
  double cost = summary.initial_cost = linearize(views, point, here);
  double radius = 1e9;
  double shrink = 2;
  double promised = 0;  // by the step before
  double corners = 0;
  for (const TargetView& view : problem.views) corners += static_cast<double>(view.observations.size());
  const double left_at_most = 1e-6 / (2 * corners);  // as solve_bundle ends
  Point candidate;
  while (summary.iterations++ < 100 && radius > 1e-32) {
    const double predicted = step(here, radius, point, candidate);
    if (predicted <= 1e-14 * cost) break;
    const double fall = std::max(predicted / promised, 0.1);
    if (predicted <= 1e-6 * cost && fall < 1 && predicted * fall / (1 - fall) <= left_at_most * cost) {
      std::swap(point, candidate);  // as solve_bundle, which does not look at what the last step leads to either
      cost -= predicted;
      break;
    }
    const double new_cost = linearize(views, candidate, there);
    const double gain = (cost - new_cost) / predicted;
    if (gain > 1e-3) {
      radius = std::min(1e16, radius / std::max(1.0 / 3, 1 - std::pow(2 * gain - 1, 3)));
      shrink = 2;
      promised = predicted;
      const bool settled = cost - new_cost <= 1e-14 * cost;
      std::swap(point, candidate);
      std::swap(here, there);
      cost = new_cost;
      if (settled) break;
    } else {
      radius /= shrink;
      shrink *= 2;
    }
  }
  summary.termination = Termination::kConverged;
  summary.final_cost = cost;
  state.cameras[0].parameters = point.camera;
  for (std::size_t i = 0; i < views.size(); ++i) state.poses[state.pose_of_view[i]].rig_from_target = point.poses[i];
  return summary;
}

}  // namespace raybundle::limit
