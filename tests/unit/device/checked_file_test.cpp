// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/device/checked_file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "raybundle/device/byte_stream.hpp"
#include "raybundle/device/digest.hpp"

namespace raybundle {
namespace {

constexpr FileKind kKind{"RBTEST\r\n", 3, "test file", "make it"};

std::string hexadecimal(const Sha256& digest) {
  std::string text;
  for (const std::uint8_t byte : digest) text += fmt::format("{:02x}", byte);
  return text;
}

TEST(Digest, EqualsThePublishedExamples) {
  // FIPS 180-4's examples and, for CRC-32, the check value of the Rocksoft catalogue.
  EXPECT_EQ(hexadecimal(sha256({"abc"})), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(hexadecimal(sha256({})), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hexadecimal(sha256({"abcdbcdecdefdefgefghfghighij", "hijkijkljklmklmnlmnomnopnopq"})),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(crc32({"1234", "56789"}), 0xCBF43926U);
}

TEST(CheckedFile, GivesBackWhatWasPutIn) {
  const std::string payload("a\0b", 3);
  const std::string file = checked_file(kKind, payload);
  EXPECT_EQ(file.size(), 64U + 3U);
  EXPECT_EQ(checked_payload(kKind, file, "x"), payload);
  EXPECT_EQ(checked_payload(kKind, checked_file(kKind, ""), "x"), "");
  EXPECT_EQ(serial_of(file).size(), 16U);
}

TEST(CheckedFile, RefusesEveryFlippedBitEveryTruncationAndAppendedBytes) {
  const std::string file = checked_file(kKind, "some payload of no meaning");
  for (std::size_t byte = 0; byte < file.size(); ++byte) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = file;
      damaged[byte] = static_cast<char>(damaged[byte] ^ 1 << bit);
      EXPECT_THROW(checked_payload(kKind, damaged, "x"), Error) << "byte " << byte << ", bit " << bit;
    }
  }
  for (std::size_t size = 0; size < file.size(); ++size) {
    EXPECT_THROW(checked_payload(kKind, file.substr(0, size), "x"), Error) << size << " bytes";
  }
  EXPECT_THROW(checked_payload(kKind, file + '\0', "x"), Error);
}

TEST(CheckedFile, SaysWhichVersionItCannotRead) {
  FileKind newer = kKind;
  newer.version = 4;
  try {
    checked_payload(kKind, checked_file(newer, ""), "table");
    FAIL() << "another version was read";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(),
                 "table: is a test file of version 4, and this program reads version 3; make it again with `make it`");
  }
}

TEST(ByteStream, GivesBackWhatWasPutInAndRefusesToReadOn) {
  ByteWriter writer;
  const std::vector<double> numbers{1.5, -2.0};
  writer.value(std::uint16_t{7});
  writer.text("name");
  writer.values<double>(numbers);
  writer.value(std::uint32_t{5});
  ByteReader reader(writer.bytes(), "x", kKind.remake);
  EXPECT_EQ(reader.value<std::uint16_t>(), 7);
  EXPECT_EQ(reader.text(), "name");
  EXPECT_EQ(reader.values<double>(2), numbers);
  EXPECT_THROW(reader.expect_end(), Error);
  EXPECT_THROW(reader.count(6, 9, "a count"), Error);
  EXPECT_NO_THROW(reader.expect_end());
  EXPECT_THROW(reader.value<char>(), Error);
  EXPECT_THROW(reader.values<double>(std::size_t{1} << 61), Error);
}

}  // namespace
}  // namespace raybundle
