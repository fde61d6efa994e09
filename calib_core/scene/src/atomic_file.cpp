// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <memory>
#include <sstream>
#include <string>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, int error_number) {
  throw Error(ErrorKind::kIo,
              std::string("cannot be written: ") + std::strerror(error_number) +
                  "; check that the folder exists, is writable and has space left",
              path.string());
}

// Unique among the threads of this process and the processes of this machine.
fs::path temporary_name(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  std::ostringstream name;
  name << '.' << path.filename().string() << '.' << ::getpid() << '.' << counter++ << ".tmp";
  return path.parent_path() / name.str();
}

bool write_all(int descriptor, const std::vector<std::string_view>& pieces) {
  for (std::string_view bytes : pieces) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return false;
      bytes.remove_prefix(static_cast<size_t>(written));
    }
  }
  return true;
}

// What is written through a link goes to the file behind it, as with any program: others read it there.
fs::path behind_links(fs::path path) {
  constexpr int kMostLinks = 40;  // one after the other: Linux follows no more
  std::error_code ignored;
  for (int i = 0; i < kMostLinks && fs::is_symlink(path, ignored); ++i) {
    path = path.parent_path() / fs::read_symlink(path, ignored);
  }
  return path;
}

// Bytes on their way to a path. Where the file system can, the file has no name until it is whole, so that not even a
// killed program leaves a part of it behind; elsewhere it has a temporary one.
class PendingFile {
 public:
  explicit PendingFile(const fs::path& path) : path_(path), temporary_(temporary_name(path)) {
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    descriptor_ = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
    if (descriptor_ >= 0) return;
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) fail(path_, errno);
    named_ = true;
  }
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;
  ~PendingFile() {
    ::close(descriptor_);
    if (named_) ::unlink(temporary_.c_str());
  }

  void write(const std::vector<std::string_view>& pieces) {
    if (!write_all(descriptor_, pieces) || ::fsync(descriptor_) != 0) fail(path_, errno);
  }

  /// Gives the whole file its temporary name: what may still fail for want of space.
  void name() {
    if (named_) return;
    const std::string self = "/proc/self/fd/" + std::to_string(descriptor_);
    if (::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, temporary_.c_str(), AT_SYMLINK_FOLLOW) != 0) fail(path_, errno);
    named_ = true;
  }

  void rename() {
    if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail(path_, errno);
    named_ = false;
  }

 private:
  fs::path path_, temporary_;
  int descriptor_ = -1;
  bool named_ = false;
};

void write_to_device(const fs::path& path, const std::vector<std::string_view>& pieces) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) fail(path, errno);
  const int error_number = write_all(descriptor, pieces) ? 0 : errno;
  ::close(descriptor);
  if (error_number != 0) fail(path, error_number);
}

}  // namespace

void write_files_whole(const std::vector<WholeFile>& files) {
  std::vector<const WholeFile*> devices;
  std::vector<std::unique_ptr<PendingFile>> pending;
  for (const WholeFile& file : files) {
    std::error_code ignored;
    const fs::file_status status = fs::status(file.path, ignored);
    if (fs::is_directory(status)) fail(file.path, EISDIR);
    if (fs::exists(status) && !fs::is_regular_file(status)) {
      devices.push_back(&file);
      continue;
    }
    pending.push_back(std::make_unique<PendingFile>(behind_links(file.path)));
    pending.back()->write(file.pieces);
  }
  for (const auto& file : pending) file->name();
  for (const WholeFile* device : devices) write_to_device(device->path, device->pieces);
  for (const auto& file : pending) file->rename();
}

void write_file_whole(const fs::path& path, std::string_view bytes) { write_files_whole({{path, bytes}}); }

}  // namespace raybundle
