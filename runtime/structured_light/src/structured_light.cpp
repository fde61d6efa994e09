// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/structured_light.hpp"

#include <algorithm>

namespace raybundle {
namespace {

// Room for what is no dot of a beam: reflexes, texture, sunlight through leaves.
int room_for_dots(const SensorTable& table) { return 2 * static_cast<int>(table.beams.size()) + 64; }

}  // namespace

StructuredLight::StructuredLight(const SensorTable& table, const StructuredLightOptions& options)
    : options_(options),
      most_dots_(room_for_dots(table)),
      beams_(table),
      lattice_(table),
      finder_(table.rays.size, most_dots_, options.dots),
      candidates_(most_dots_),
      work_(most_dots_, table),
      health_(beams_, options.health) {
  const std::size_t beams = table.beams.size();
  dots_.reserve(most_dots_);
  points_.reserve(beams);
  point_of_beam_.reserve(beams);
  samples_.reserve(beams);
  mesh_.reserve(4 * static_cast<std::size_t>(table.grid.size()));
}

const LaserFrame& StructuredLight::process(const GreyView& on, const GreyView& off) {
  const auto fits = [&](const GreyView& image) {
    return image.width == table().rays.size.width && image.height == table().rays.size.height;
  };
  if (!fits(on) || (off.pixels != nullptr && !fits(off))) {
    frame_ = {};
    return frame_;
  }
  return process(finder_.find(on, off));
}

const LaserFrame& StructuredLight::process(std::span<const Dot> dots) {
  dots_.assign(dots.begin(), dots.begin() + std::min<std::ptrdiff_t>(std::ssize(dots), most_dots_));
  candidates_.find(beams_, dots_);
  options_.labeller.label({lattice_, table().range, candidates_}, work_);
  place_points();
  mesh(lattice_, points_, point_of_beam_, options_.most_slant, mesh_);
  watch();
  frame_.dots = dots_;
  frame_.points = points_;
  frame_.mesh = mesh_;
  return frame_;
}

void StructuredLight::place_points() {
  points_.clear();
  samples_.clear();
  point_of_beam_.assign(table().beams.size(), -1);
  for (int dot = 0; dot < candidates_.dots(); ++dot) {
    dots_[dot].beam = kUnlabelled;
    if (work_.chosen[dot] < 0) continue;
    const Candidate& label = candidates_.all()[work_.chosen[dot]];
    const TableBeam& beam = table().beams[label.beam];
    dots_[dot].beam = table().grid.index(beam.row, beam.column);
    LaserPoint point = laser_point(beam, beams_.beams[label.beam], candidates_.ray(dot), dots_[dot].covariance_px2);
    point.dot = dot;
    point.beam = label.beam;
    point.off_sigmas = label.off_sigmas;
    point_of_beam_[label.beam] = static_cast<int>(points_.size());
    points_.push_back(point);
    samples_.push_back({label.beam, candidates_.ray(dot), dots_[dot].covariance_px2});
  }
}

void StructuredLight::watch() {
  frame_.health = health_.update(samples_);
  frame_.state = frame_.health.state;
  const double labelled = static_cast<double>(points_.size());
  if (labelled < options_.least_labelled * static_cast<double>(dots_.size())) {
    frame_.state = worse(frame_.state, State::kDegraded);
  }
  if (points_.empty()) frame_.state = State::kInvalid;
  if (options_.follow_wavelength && frame_.health.state == State::kOk)
    beams_.set_log_wavelength(frame_.health.log_wavelength);
}

}  // namespace raybundle
