// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "raybundle/device/state.hpp"

namespace raybundle::apps {

inline constexpr const char* kStateNames[] = {"OK", "DEGRADED", "INVALID"};

/// OK, DEGRADED or INVALID.
inline const char* state_name(State state) { return kStateNames[static_cast<int>(state)]; }

/// The same read back; what is none of them is invalid.
inline State state_named(std::string_view name) {
  for (const State state : {State::kOk, State::kDegraded}) {
    if (name == state_name(state)) return state;
  }
  return State::kInvalid;
}

}  // namespace raybundle::apps
