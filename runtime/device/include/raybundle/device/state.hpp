// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace raybundle {

/// How far an answer of the runtime may be relied on. It travels with every answer; kInvalid must reach whoever
/// decides, and never stands for a default class.
enum class State : unsigned char { kOk, kDegraded, kInvalid };

/// The worse of two.
constexpr State worse(State a, State b) { return std::max(a, b); }

}  // namespace raybundle
