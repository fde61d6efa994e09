// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>

namespace raybundle::apps {

void add_structured_light_reconstruction(CLI::App& verb);
void add_stereo_reconstruction(CLI::App& verb);

/// The one list of what `reconstruct` can do, each a subcommand, in the order of --help.
inline constexpr void (*kReconstructions[])(CLI::App&) = {add_structured_light_reconstruction,
                                                          add_stereo_reconstruction};

}  // namespace raybundle::apps
