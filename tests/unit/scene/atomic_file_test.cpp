// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/atomic_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "fresh_folder.hpp"
#include "raybundle/geometry/error.hpp"
#include "text_file.hpp"

namespace raybundle {
namespace {

namespace fs = std::filesystem;

class AtomicFile : public testing::Test {
 protected:
  void SetUp() override { folder_ = fresh_folder(); }
  size_t files() const { return std::distance(fs::directory_iterator(folder_), fs::directory_iterator()); }

  fs::path folder_;
};

TEST_F(AtomicFile, WritesEveryByteAndLeavesNothingElse) {
  const std::string bytes("a\0b\n", 4);
  write_file_whole(folder_ / "file", bytes);
  EXPECT_EQ(text_of(folder_ / "file"), bytes);
  write_file_whole(folder_ / "file", "");
  EXPECT_EQ(text_of(folder_ / "file"), "");
  EXPECT_EQ(files(), 1u);
}

TEST_F(AtomicFile, TakesAPlainNameInTheWorkingFolder) {
  const fs::path before = fs::current_path();
  fs::current_path(folder_);
  write_file_whole("plain", "x");
  fs::current_path(before);
  EXPECT_EQ(text_of(folder_ / "plain"), "x");
}

// current.json -> v12.json: who reads v12.json has to find what was written.
TEST_F(AtomicFile, WritesWhereALinkLeads) {
  write_file_whole(folder_ / "v12", "old");
  fs::create_symlink("v12", folder_ / "current");
  fs::create_symlink(folder_ / "current", folder_ / "latest");
  write_file_whole(folder_ / "latest", "new");
  EXPECT_EQ(text_of(folder_ / "v12"), "new");
  EXPECT_TRUE(fs::is_symlink(folder_ / "latest") && fs::is_symlink(folder_ / "current"));
  fs::create_symlink("to be", folder_ / "dangling");
  write_file_whole(folder_ / "dangling", "x");
  EXPECT_EQ(text_of(folder_ / "to be"), "x");
}

TEST_F(AtomicFile, FailsNamingThePathAndLeavesNothingBehind) {
  fs::create_directories(folder_ / "taken");
  for (const fs::path& path : {folder_ / "no such folder" / "file", folder_ / "taken"}) {
    try {
      write_file_whole(path, "x");
      FAIL() << path;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kIo);
      EXPECT_THAT(error.what(), testing::HasSubstr(path.string()));
    }
  }
  EXPECT_EQ(files(), 1u);
}

TEST_F(AtomicFile, FilesThatBelongTogetherAreAllWrittenOrNone) {
  write_files_whole({{folder_ / "a", "old"}, {folder_ / "b", "old too"}});
  EXPECT_EQ(text_of(folder_ / "a") + text_of(folder_ / "b"), "oldold too");
  fs::create_directories(folder_ / "taken");
  for (const fs::path& path : {folder_ / "no such folder" / "file", folder_ / "taken"}) {
    EXPECT_THROW(write_files_whole({{folder_ / "a", "new"}, {path, "x"}, {folder_ / "b", "new"}}), Error) << path;
    EXPECT_EQ(text_of(folder_ / "a"), "old");
    EXPECT_EQ(text_of(folder_ / "b"), "old too");
    EXPECT_EQ(files(), 3u);
  }
}

TEST_F(AtomicFile, WritesToADeviceAsItIs) {
  write_file_whole("/dev/null", "x");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace raybundle
