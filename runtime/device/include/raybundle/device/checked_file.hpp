// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace raybundle {

/// Which files are meant.
struct FileKind {
  char magic[9] = {};         ///< eight characters, the first bytes of the file
  std::uint32_t version = 0;  ///< of the payload's layout; another one is refused
  std::string_view name;      ///< for messages: "structured-light table"
  std::string_view remake;    ///< for messages, how to make it again: "raybundle export ..."
};

/// A payload in the container that every file for a device has, 64 bytes and the payload:
///
///   0  8  magic              16  8  length of the whole file    28  4  zero
///   8  4  0x01020304         24  4  CRC-32 of bytes 0..23       32 32  SHA-256 of bytes 0..31 and the payload
///  12  4  version                   and the payload             64     payload
///
/// Numbers are in the writer's byte order, which bytes 8..11 tell.
std::string checked_file(const FileKind& kind, std::string_view payload);

/// The payload of such a file. Every flipped bit, every truncation and every appended byte is refused.
///
/// @param where  name of the file, for messages
/// @throws Error(kBadInput) naming the first thing that is wrong
std::string_view checked_payload(const FileKind& kind, std::string_view file, const std::string& where);

/// The serial number of a checked payload: the first 8 bytes of the file's SHA-256, 16 hexadecimal digits.
std::string serial_of(std::string_view file);

}  // namespace raybundle
