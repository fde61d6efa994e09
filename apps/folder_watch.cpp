// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "folder_watch.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <thread>

#include "image_files.hpp"
#include "raybundle/geometry/error.hpp"
#include "terminal.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kTick(100);
constexpr int kPatience = 20;  // ticks without a change, after which a file that cannot be read is given up

volatile std::sig_atomic_t interrupted = 0;

// Notes signals while it lives, instead of ending the program.
class Interruption {
 public:
  Interruption() {
    interrupted = 0;
    for (std::size_t i = 0; i < kSignals.size(); ++i)
      before_[i] = std::signal(kSignals[i], [](int) { interrupted = 1; });
  }
  ~Interruption() {
    for (std::size_t i = 0; i < kSignals.size(); ++i) std::signal(kSignals[i], before_[i]);
  }
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

 private:
  static constexpr std::array kSignals{SIGINT, SIGTERM};
  std::array<void (*)(int), kSignals.size()> before_{};
};

struct WatchedFile {
  std::uintmax_t size = 0;
  fs::file_time_type time;
  int unchanged = 0;  // ticks
  bool done = false;
};

// What the folder holds now; files may vanish while they are looked at.
void look(const fs::path& folder, std::map<fs::path, WatchedFile>& files) {
  std::error_code gone;
  fs::directory_iterator entries(folder, gone);
  if (gone) throw Error(ErrorKind::kIo, "is no folder to watch; make it first", folder.string());
  for (const auto& entry : entries) {
    if (!is_image(entry.path().string())) continue;
    const auto known = files.find(entry.path());
    if (known != files.end() && known->second.done) continue;
    const auto size = entry.file_size(gone);
    const auto time = gone ? fs::file_time_type{} : entry.last_write_time(gone);
    if (gone) continue;
    WatchedFile& file = files[entry.path()];
    const bool same = file.size == size && file.time == time;
    file.unchanged = same ? file.unchanged + 1 : 0;
    file.size = size;
    file.time = time;
  }
}

}  // namespace

void watch_folder(const std::string& folder, const std::function<bool(const std::string& path)>& take) {
  const Interruption interruption;
  std::map<fs::path, WatchedFile> files;  // in the order of their names
  while (!interrupted) {
    look(folder, files);
    for (auto& [path, file] : files) {
      if (interrupted) return;
      if (file.done || file.unchanged == 0 || file.size == 0) continue;
      try {
        file.done = true;
        if (!take(path.string())) return;
      } catch (const Error& error) {
        if (error.where() != path.string()) throw;
        file.done = error.kind() != ErrorKind::kIo || file.unchanged >= kPatience;
        if (file.done) say_warning(error.what());
      }
    }
    std::this_thread::sleep_for(kTick);
  }
}

}  // namespace raybundle::apps
