// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "raybundle/device/checked_file.hpp"
#include "raybundle/occupancy/case_base.hpp"

namespace raybundle {

inline constexpr FileKind kCaseBaseKind{"RBOCCUPY", 3, "base of occupancy cases", "raybundle occupancy learn"};

/// The bytes of a file of learnt cases, in the container of checked_file.hpp. Format: docs/formats/occupancy.md.
std::string bytes_from_case_base(const CaseBase& base);

/// Reads them back: the same bits.
///
/// @param where  name of the file, for messages
/// @throws Error(kBadInput) for any flipped bit or truncation, and for content that does not agree
CaseBase case_base_from_bytes(std::string_view bytes, const std::string& where);

}  // namespace raybundle
