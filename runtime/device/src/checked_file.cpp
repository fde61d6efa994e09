// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/device/checked_file.hpp"

#include <cstring>

#include "raybundle/device/digest.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr std::uint32_t kByteOrder = 0x01020304;
constexpr std::size_t kMagicSize = 8, kSumsAt = 24, kShaAt = 32, kHeaderSize = 64;

template <typename Number>
void put(std::string& bytes, std::size_t at, Number number) {
  std::memcpy(bytes.data() + at, &number, sizeof number);
}

template <typename Number>
Number number_at(std::string_view bytes, std::size_t at) {
  Number number;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

std::string_view bytes_of(const Sha256& digest) {
  return {reinterpret_cast<const char*>(digest.data()), digest.size()};
}

}  // namespace

std::string checked_file(const FileKind& kind, std::string_view payload) {
  std::string file(kHeaderSize, '\0');
  std::memcpy(file.data(), kind.magic, kMagicSize);
  put(file, 8, kByteOrder);
  put(file, 12, kind.version);
  put(file, 16, static_cast<std::uint64_t>(kHeaderSize + payload.size()));
  const std::string_view header = file;
  put(file, kSumsAt, crc32({header.substr(0, kSumsAt), payload}));
  const Sha256 digest = sha256({header.substr(0, kShaAt), payload});
  std::memcpy(file.data() + kShaAt, digest.data(), digest.size());
  return file.append(payload);
}

std::string_view checked_payload(const FileKind& kind, std::string_view file, const std::string& where) {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorKind::kBadInput, what + "; make it again with `" + std::string(kind.remake) + "`", where);
  };
  const std::string name(kind.name);
  if (file.size() < kHeaderSize || std::memcmp(file.data(), kind.magic, kMagicSize) != 0) {
    refuse("is no " + name);
  }
  if (number_at<std::uint32_t>(file, 8) != kByteOrder) refuse("was written by a machine of another byte order");
  if (const auto version = number_at<std::uint32_t>(file, 12); version != kind.version) {
    refuse("is a " + name + " of version " + std::to_string(version) + ", and this program reads version " +
           std::to_string(kind.version));
  }
  if (const auto length = number_at<std::uint64_t>(file, 16); length != file.size()) {
    refuse("has " + std::to_string(file.size()) + " bytes and says that it has " + std::to_string(length));
  }
  const std::string_view payload = file.substr(kHeaderSize);
  if (number_at<std::uint32_t>(file, kSumsAt) != crc32({file.substr(0, kSumsAt), payload})) {
    refuse("is damaged: its CRC-32 is not that of its bytes");
  }
  if (file.substr(kShaAt, kHeaderSize - kShaAt) != bytes_of(sha256({file.substr(0, kShaAt), payload}))) {
    refuse("is damaged: its SHA-256 is not that of its bytes");
  }
  return payload;
}

std::string serial_of(std::string_view file) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string serial;
  for (const char byte : file.substr(kShaAt, 8)) {
    serial += kDigits[static_cast<std::uint8_t>(byte) >> 4];
    serial += kDigits[static_cast<std::uint8_t>(byte) & 15];
  }
  return serial;
}

}  // namespace raybundle
