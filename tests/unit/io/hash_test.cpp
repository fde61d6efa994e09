// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/hash.hpp"

#include "fresh_folder.hpp"
#include "io_examples.hpp"
#include "raybundle/scene/atomic_file.hpp"

namespace raybundle::testing {
namespace {

// Source: NIST, FIPS 180-2, appendix B.
TEST(Sha256, AgreesWithTheStandard) {
  EXPECT_EQ(sha256_of_bytes("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_of_bytes(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of_bytes(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, OfAFileIsThatOfItsBytes) {
  const auto path = fresh_folder() / "file";
  const std::string bytes(200'000, '\0');
  write_file_whole(path, bytes);
  EXPECT_EQ(sha256_of_file(path), sha256_of_bytes(bytes));
  write_file_whole(path, "");
  EXPECT_EQ(sha256_of_file(path), sha256_of_bytes(""));
  std::filesystem::remove(path);
  EXPECT_THAT(message_of([&] { sha256_of_file(path); }, ErrorKind::kIo), ::testing::HasSubstr("cannot be read"));
}

}  // namespace
}  // namespace raybundle::testing
