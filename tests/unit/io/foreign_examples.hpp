// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io_examples.hpp"
#include "raybundle/io/foreign_format.hpp"

namespace raybundle::testing {

/// The files of cameras, each by the first lens that holds it.
inline std::vector<NamedText> texts_of(const ForeignFormat& format, const std::vector<RigCamera>& rig) {
  std::vector<ForeignCamera> cameras;
  for (const RigCamera& camera : rig) cameras.push_back({camera});
  return texts_from_rig(format, cameras);
}

/// One file.
inline std::vector<NamedText> with_text(std::string text, const std::string& name = "file") {
  return {{name, std::move(text)}};
}

inline std::vector<RigCamera> read_as(const char* format, const std::vector<NamedText>& files) {
  return rig_from_texts(*foreign_format_named(format), files);
}

}  // namespace raybundle::testing
