// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace raybundle {

/// Four numbers that a camera model takes for one, so that it projects four corners at once.
///
/// A comparison can have one answer only. Where the four disagree it is false, like any comparison with a NaN, and
/// `disagreed` is set: the caller then has to take the corners one by one.
class Lanes {
 public:
  static constexpr int kCount = 4;
  using Vector = double __attribute__((vector_size(8 * kCount)));
  using Mask = std::int64_t __attribute__((vector_size(8 * kCount)));
  static inline thread_local bool disagreed = false;

  Lanes() = default;
  [[gnu::always_inline]] Lanes(double value) : vector_{value, value, value, value} {}
  [[gnu::always_inline]] explicit Lanes(const Vector& vector) : vector_(vector) {}
  [[gnu::always_inline]] static Lanes from(const double* numbers) {
    return Lanes(Vector{numbers[0], numbers[1], numbers[2], numbers[3]});
  }
  [[gnu::always_inline]] void store(double* numbers) const {
    for (int lane = 0; lane < kCount; ++lane) numbers[lane] = vector_[lane];
  }
  [[gnu::always_inline]] double sum() const { return (vector_[0] + vector_[1]) + (vector_[2] + vector_[3]); }
  [[gnu::always_inline]] double operator[](int lane) const { return vector_[lane]; }

#define RAYBUNDLE_LANES_OPERATOR(op)                                                \
  [[gnu::always_inline]] friend Lanes operator op(const Lanes& a, const Lanes& b) { \
    return Lanes(a.vector_ op b.vector_);                                           \
  }                                                                                 \
  [[gnu::always_inline]] Lanes& operator op##=(const Lanes& b) {                    \
    vector_ = vector_ op b.vector_;                                                 \
    return *this;                                                                   \
  }
  RAYBUNDLE_LANES_OPERATOR(+)
  RAYBUNDLE_LANES_OPERATOR(-)
  RAYBUNDLE_LANES_OPERATOR(*)
  RAYBUNDLE_LANES_OPERATOR(/)
#undef RAYBUNDLE_LANES_OPERATOR
  [[gnu::always_inline]] friend Lanes operator-(const Lanes& a) { return Lanes(-a.vector_); }
  [[gnu::always_inline]] friend bool operator<(const Lanes& a, const Lanes& b) { return all(a.vector_ < b.vector_); }
  [[gnu::always_inline]] friend bool operator>(const Lanes& a, const Lanes& b) { return b < a; }

  [[gnu::always_inline]] friend Lanes sqrt(const Lanes& a) {
    return Lanes(Vector{std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])});
  }

  [[gnu::always_inline]] friend Lanes tan(const Lanes& a) {
    return Lanes(Vector{std::tan(a[0]), std::tan(a[1]), std::tan(a[2]), std::tan(a[3])});
  }

  /// Zeros have no sign here. Source: Cephes, atan.c; error below two units of the last digit.
  [[gnu::always_inline]] friend Lanes atan2(const Lanes& y_lanes, const Lanes& x_lanes) {
    const Vector& y = y_lanes.vector_;
    const Vector& x = x_lanes.vector_;
    const Vector zero{};
    const Vector ax = x < zero ? -x : x;
    const Vector ay = y < zero ? -y : y;
    const Vector small = ay < ax ? ay : ax;
    const Vector large = ay < ax ? ax : ay;
    const Mask far = small > 0.41421356237309503 * large;  // tan 22.5°
    const Vector t = (far ? small - large : small) / (far ? small + large : large);
    const Vector z = t * t;
    const Vector p =
        (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z - 7.500855792314704667340e1) * z -
         1.228866684490136173410e2) *
            z -
        6.485021904942025371773e1;
    const Vector q =
        ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z + 4.328810604912902668951e2) * z +
         4.853903996359136964868e2) *
            z +
        1.945506571482613964425e2;
    Vector angle = t + t * (z * p / q);
    angle = far ? 0.25 * std::numbers::pi + angle : angle;
    angle = ay > ax ? 0.5 * std::numbers::pi - angle : angle;
    angle = x < zero ? std::numbers::pi - angle : angle;
    return Lanes(y < zero ? -angle : angle);
  }

 private:
  [[gnu::always_inline]] static bool all(const Mask& mask) {
    const std::int64_t both = mask[0] & mask[1] & mask[2] & mask[3];
    const std::int64_t any = mask[0] | mask[1] | mask[2] | mask[3];
    if (both != any) disagreed = true;
    return both != 0;
  }

  Vector vector_;
};

[[gnu::always_inline]] inline void load(const double* from, double& number) { number = *from; }
[[gnu::always_inline]] inline void load(const double* from, Lanes& lanes) { lanes = Lanes::from(from); }
[[gnu::always_inline]] inline void store(double number, double* to) { *to = number; }
[[gnu::always_inline]] inline void store(const Lanes& lanes, double* to) { lanes.store(to); }

/// Coordinates of the vector there, or of the Lanes::kCount from there on.
template <int size>
[[gnu::always_inline]] inline void load(const Eigen::Matrix<double, size, 1>* from, double (&numbers)[size]) {
  for (int k = 0; k < size; ++k) numbers[k] = (*from)[k];
}
template <int size>
[[gnu::always_inline]] inline void load(const Eigen::Matrix<double, size, 1>* from, Lanes (&numbers)[size]) {
  for (int k = 0; k < size; ++k) numbers[k] = Lanes(Lanes::Vector{from[0][k], from[1][k], from[2][k], from[3][k]});
}

/// Calls `take` with the first of as many as there are lanes, and one by one for those that are left and where the
/// lanes have no common answer; calls `miss` for each that it cannot take.
///
/// @param take  a template on the number, always inline: bool <Number>(index)
template <typename Index, typename Take, typename Miss>
[[gnu::always_inline]] inline void for_each_in_lanes(Index count, const Take& take, const Miss& miss) {
  const auto take_one = [&](Index i) __attribute__((always_inline)) {
    if (!take.template operator()<double>(i)) miss(i);
  };
  Index i = 0;
  for (; i + Lanes::kCount <= count; i += Lanes::kCount) {
    Lanes::disagreed = false;
    if (take.template operator()<Lanes>(i) && !Lanes::disagreed) continue;
    for (int lane = 0; lane < Lanes::kCount; ++lane) take_one(i + lane);
  }
  for (; i < count; ++i) take_one(i);
}

}  // namespace raybundle
