// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/geometry/error.hpp"

namespace raybundle::apps {

/// What the program returns, as `raybundle --help` explains it.
enum ExitCode : int { kDone = 0, kGateFailed = 1, kWrongUsage = 2, kNotEnoughData = 3, kSolveFailed = 4, kIo = 5 };

/// What it returns after an error.
constexpr ExitCode exit_code(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kBadInput:
      return kWrongUsage;
    case ErrorKind::kNotEnoughData:
      return kNotEnoughData;
    case ErrorKind::kSolveFailed:
      return kSolveFailed;
    case ErrorKind::kIo:
      return kIo;
  }
  return kSolveFailed;
}

}  // namespace raybundle::apps
