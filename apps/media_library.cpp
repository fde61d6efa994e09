// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>

#include <filesystem>

#include "media/media.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

// Where the library lies: beside the program, as in the build, or where it is installed.
fs::path library_path() {
  std::error_code unknown;
  const fs::path folder = fs::read_symlink("/proc/self/exe", unknown).parent_path();
  for (const char* place : {".", "../lib"}) {
    fs::path path = folder / place / kMediaLibrary;
    std::error_code ignored;
    if (!unknown && fs::exists(path, ignored)) return path;
  }
  throw Error(ErrorKind::kIo,
              std::string(kMediaLibrary) +
                  ", which reads videos and images other than JPEG and grey PNG, does not lie beside the program; "
                  "install both, or build again",
              folder.string());
}

const Media& loaded() {
  const fs::path path = library_path();
  using Get = const Media* (*)();
  void* const library = ::dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
  void* const get = library == nullptr ? nullptr : ::dlsym(library, "raybundle_media");
  if (get == nullptr) throw Error(ErrorKind::kIo, std::string("cannot be loaded: ") + ::dlerror(), path.string());
  return *reinterpret_cast<Get>(get)();
}

}  // namespace

const Media& media() {
  static const Media& only = loaded();
  return only;
}

}  // namespace raybundle::apps
