// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "raybundle/device/checked_file.hpp"
#include "raybundle/structured_light/sensor_table.hpp"

namespace raybundle {

inline constexpr FileKind kTableKind{"RBSLTABL", 2, "structured-light table",
                                     "raybundle export CALIBRATION --runtime structured-light -o FILE"};

/// The bytes of a table's file. The format: docs/formats/structured_light_table.md.
std::string bytes_from_table(const SensorTable& table);

/// Reads them back, checks every number and replays the self-test: whatever is not whole is refused.
///
/// @param where  name of the file, for messages
/// @throws Error(kBadInput)
SensorTable table_from_bytes(std::string_view bytes, const std::string& where);

/// The same from a file.
///
/// @throws Error(kIo) when it cannot be read
SensorTable read_table(const std::filesystem::path& path);

/// Whether a file begins as a table does.
bool is_table(std::string_view bytes);

}  // namespace raybundle
