// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
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

// Closes the file, and removes it unless it has been given its final name.
class TemporaryFile {
 public:
  TemporaryFile(const fs::path& path, int flags, bool remove_on_failure)
      : path_(path), remove_(remove_on_failure), descriptor_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (descriptor_ < 0) return;
    ::close(descriptor_);
    if (remove_) ::unlink(path_.c_str());
  }

  bool is_open() const { return descriptor_ >= 0; }

  bool write(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return false;
      bytes.remove_prefix(static_cast<size_t>(written));
    }
    return true;
  }

  bool flush() { return ::fsync(descriptor_) == 0; }

  bool rename_to(const fs::path& path) {
    if (::rename(path_.c_str(), path.c_str()) != 0) return false;
    remove_ = false;
    return true;
  }

 private:
  fs::path path_;
  bool remove_;
  int descriptor_;
};

// Unique among the threads of this process and the processes of this machine.
fs::path temporary_name(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  std::ostringstream name;
  name << '.' << path.filename().string() << '.' << ::getpid() << '.' << counter++ << ".tmp";
  return path.parent_path() / name.str();
}

}  // namespace

void write_file_whole(const fs::path& path, std::string_view bytes) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (fs::is_directory(status)) fail(path, EISDIR);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    TemporaryFile device(path, O_WRONLY, false);
    if (!device.is_open() || !device.write(bytes)) fail(path, errno);
    return;
  }
  TemporaryFile file(temporary_name(path), O_WRONLY | O_CREAT | O_EXCL, true);
  if (!file.is_open() || !file.write(bytes) || !file.flush() || !file.rename_to(path)) fail(path, errno);
}

}  // namespace raybundle
