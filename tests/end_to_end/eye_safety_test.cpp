// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "eye_safety_limits.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "program.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle::testing {
namespace {

using apps::kSafetyEditions;
using apps::safety_limit;

// The figures of Boverie, Devy, Lerasle 2006, section 2.2: 0.78 mW, and "a factor 2" more for shorter pulses.
TEST(EyeSafety, GivesThePublishedFigures) {
  EXPECT_NEAR(1e3 * safety_limit({.wavelength_nm = 850, .pulse_s = 1e-3, .rate_Hz = 100}, kSafetyEditions[0]).least_W(),
              0.785, 0.0005);
  EXPECT_NEAR(1e3 * safety_limit({.wavelength_nm = 850, .pulse_s = 1e-4, .rate_Hz = 100}, kSafetyEditions[0]).least_W(),
              1.397, 0.0005);
}

TEST(EyeSafety, NeverAllowsMoreThanItsAverageAndASinglePulse) {
  for (const auto& edition : kSafetyEditions) {
    for (const double pulse_s : {1e-8, 1e-6, 1e-4, 1e-2}) {
      const auto limit = safety_limit({.wavelength_nm = 830, .pulse_s = pulse_s, .rate_Hz = 50}, edition);
      EXPECT_LE(limit.least_W(), limit.single_pulse_W);
      EXPECT_LE(limit.least_W(), limit.average_W);
      EXPECT_GT(limit.least_W(), 0.0);
    }
  }
  EXPECT_THROW(safety_limit({.wavelength_nm = 650}, kSafetyEditions[0]), Error);
  EXPECT_THROW(safety_limit({.pulse_s = 0.1, .rate_Hz = 20}, kSafetyEditions[0]), Error);
}

// Worked by hand from the tables of the 2014 edition.
TEST(EyeSafety, CountsSizeAndNumberByTheLaterEdition) {
  const apps::SafetyEdition& later = kSafetyEditions[2];
  const auto limit = [&](double pulse_s, double rate_Hz, double source_mrad) {
    return safety_limit({.wavelength_nm = 850, .pulse_s = pulse_s, .rate_Hz = rate_Hz, .source_mrad = source_mrad},
                        later);
  };
  EXPECT_NEAR(limit(1e-3, 100, 50).c6, 200 * std::sqrt(1e-3) / 1.5, 1e-12);  // 6.3 mrad count of a pulse of 1 ms
  EXPECT_NEAR(limit(1e-4, 100, 50).c6, 5 / 1.5, 1e-12);
  EXPECT_EQ(limit(1e-3, 100, 1.5).c5, 1.0);                                 // small
  EXPECT_EQ(limit(1e-3, 100, 6).c5, 0.4);                                   // of a size that counts
  EXPECT_EQ(limit(1e-3, 100, 50).c5, 0.2);                                  // larger
  EXPECT_NEAR(limit(1e-6, 100, 1.5).c5, 5 * std::pow(1000, -0.25), 1e-12);  // short: 1000 pulses in 10 s
  EXPECT_EQ(limit(1e-6, 50, 1.5).c5, 1.0);                                  // 500
  EXPECT_NEAR(limit(1e-3, 100, 100).exposure_s, 100, 1e-9);                 // T2
  EXPECT_NEAR(limit(1e-3, 100, 1.5).exposure_s, 10, 1e-12);
  // 3.9e-4 C4 W of mean power for a point, at a duty of a tenth.
  EXPECT_NEAR(limit(1e-3, 100, 1.5).average_W, 10 * 3.9e-4 * std::pow(10, 0.3), 1e-12);
  EXPECT_THROW(limit(1e-7, 1e6, 1.5), Error);  // groups of pulses
}

TEST(EyeSafety, CountsBeamsThatEnterAnApertureTogether) {
  const auto beam = [](double angle) { return Line3{Eigen::Vector3d::Zero(), {std::sin(angle), 0, std::cos(angle)}}; };
  EXPECT_EQ(apps::beams_in_aperture({beam(0.0), beam(0.15), beam(0.3)}, 0.1), 1);
  EXPECT_EQ(apps::beams_in_aperture({beam(0.0), beam(0.06), beam(0.3)}, 0.1), 2);  // 6 mm apart at 100 mm
  EXPECT_EQ(apps::beams_in_aperture({beam(0.0), beam(0.03), beam(0.06), beam(0.09)}, 0.1), 3);
}

TEST(EyeSafety, JudgesAPowerByItsExitCode) {
  const std::vector<std::string> drive{"eye-safety", "--edition", "1993", "--wavelength", "850", "--power"};
  const auto run = [&](const char* power) {
    std::vector<std::string> arguments = drive;
    arguments.emplace_back(power);
    return raybundle_program(arguments);
  };
  EXPECT_EQ(run("0.7").exit_code, 0);
  const ProgramRun above = run("0.9");
  EXPECT_EQ(above.exit_code, 1);
  EXPECT_NE(above.out.find("not a compliance verdict"), std::string::npos);
  EXPECT_EQ(raybundle_program({"eye-safety"}).exit_code, 2);  // the edition is never assumed
}

}  // namespace
}  // namespace raybundle::testing
