// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/structured_light.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "label_rules.hpp"

namespace raybundle {
namespace {

// Halvings of the step in which a wavelength is looked for: to 2 K, a fraction of a pixel at the outermost dots.
constexpr int kHalvings = 3;

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
      health_(beams_, options.health),
      drifts_(std::ranges::any_of(beams_.most_by_wavelength, [](double most) { return most > 0.0; })) {
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
  const bool known = !drifts_ || !options_.follow_wavelength || health_.report().state != State::kDegraded;
  const bool found = known || find_wavelength();
  label_dots();
  // Labels by an unknown wavelength are too few and too often wrong to judge the projector by.
  frame_.health = health_.update(found ? samples_ : std::span<const Health::Sample>{});
  if (options_.follow_wavelength && frame_.health.state == State::kOk) {
    beams_.set_log_wavelength(frame_.health.log_wavelength);
    beams_.log_wavelength_variance = std::pow(frame_.health.log_wavelength_sigma, 2);
    if (!known) label_dots();
  }
  mesh(lattice_, points_, point_of_beam_, options_.most_slant, mesh_);
  judge();
  frame_.dots = dots_;
  frame_.points = points_;
  frame_.mesh = mesh_;
  return frame_;
}

bool StructuredLight::find_wavelength() {
  const double sigma = options_.health.wavelength_sigma;
  double middle = 0.0, step = sigma;
  bool found = std::ssize(dots_) >= options_.health.least_dots;
  for (int level = 0; found && level <= kHalvings; ++level, step *= 0.5) {
    const int steps = level == 0 ? kWavelengthSigmas : 1;
    double best = middle, most = -std::numeric_limits<double>::infinity();
    int labelled = 0;
    beams_.log_wavelength_variance = 0.25 * step * step;
    for (int k = -steps; k <= steps; ++k) {
      beams_.set_log_wavelength(middle + k * step);
      choose_labels();
      double log_odds = 0.0;
      int count = 0;
      for (const int chosen : work_.chosen) {
        if (chosen < 0) continue;
        log_odds += kBeamOverClutter + candidates_.all()[chosen].log_odds;
        ++count;
      }
      if (log_odds <= most) continue;
      most = log_odds;
      best = beams_.log_wavelength;
      labelled = count;
    }
    middle = best;
    found = labelled >= options_.health.least_dots;
  }
  beams_.set_log_wavelength(found ? middle : 0.0);
  if (!found) beams_.log_wavelength_variance = sigma * sigma;
  return found;
}

void StructuredLight::choose_labels() {
  candidates_.find(beams_, dots_);
  options_.labeller.label({lattice_, table().range, candidates_}, work_);
}

void StructuredLight::label_dots() {
  choose_labels();
  points_.clear();
  samples_.clear();
  point_of_beam_.assign(table().beams.size(), -1);
  for (int dot = 0; dot < candidates_.dots(); ++dot) {
    dots_[dot].beam = kUnlabelled;
    if (work_.chosen[dot] < 0) continue;
    const Candidate& label = candidates_.all()[work_.chosen[dot]];
    const TableBeam& beam = table().beams[label.beam];
    dots_[dot].beam = table().grid.index(beam.row, beam.column);
    LaserPoint point = laser_point(beam, beams_.beams[label.beam], candidates_.ray(dot), dots_[dot].covariance_px2,
                                   beams_.log_wavelength_variance);
    point.dot = dot;
    point.beam = label.beam;
    point.off_sigmas = label.off_sigmas;
    point_of_beam_[label.beam] = static_cast<int>(points_.size());
    points_.push_back(point);
    samples_.push_back({label.beam, candidates_.ray(dot), dots_[dot].covariance_px2});
  }
}

void StructuredLight::judge() {
  frame_.state = frame_.health.state;
  const double labelled = static_cast<double>(points_.size());
  if (labelled < options_.least_labelled * static_cast<double>(dots_.size()) ||
      labelled < options_.least_beams * static_cast<double>(table().beams.size())) {
    frame_.state = worse(frame_.state, State::kDegraded);
  }
  if (points_.empty()) frame_.state = State::kInvalid;
}

}  // namespace raybundle
