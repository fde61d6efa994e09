// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <string_view>

namespace raybundle {

using Sha256 = std::array<std::uint8_t, 32>;

/// SHA-256 of the pieces, one behind the other. Here so that a device needs no library for it.
/// Source: FIPS 180-4, section 6.2.
Sha256 sha256(std::initializer_list<std::string_view> pieces);

/// CRC-32 of the pieces, one behind the other: the reflected polynomial 0xEDB88320 of Ethernet, zlib and PNG.
std::uint32_t crc32(std::initializer_list<std::string_view> pieces);

}  // namespace raybundle
