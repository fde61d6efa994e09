// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "raybundle/uncertainty/requirements.hpp"

namespace raybundle::apps {

/// What a calibration is held against.
struct GateFlags {
  std::vector<std::string> require;  ///< in words, as "depth 20 mm at 1 m"
  std::string file;                  ///< gates.toml with more of them
};

/// Declares --require and --gates on a verb.
void add_gate_flags(CLI::App& verb, GateFlags& flags);

/// The requirements of the flags, then those of the file: docs/formats/gates.md.
///
/// @throws Error(kBadInput) naming the word or the key that is not understood, Error(kIo) when the file cannot be read
std::vector<Requirement> requirements_of(const GateFlags& flags);

/// Finds out before the work that a requirement cannot be met by any result.
///
/// @param cameras  names of those that will be calibrated
/// @throws Error(kBadInput) for an unknown camera, and for a depth of one camera without a laser
void check_requirements(const std::vector<Requirement>& requirements, const std::vector<std::string>& cameras,
                        bool with_laser);

}  // namespace raybundle::apps
