// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "reconstruct.hpp"

#include "verbs.hpp"

namespace raybundle::apps {

void add_reconstruct_verb(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("reconstruct", "calibration + images -> points in space");
  verb->require_subcommand(1);
  for (auto add : kReconstructions) add(*verb);
}

}  // namespace raybundle::apps
