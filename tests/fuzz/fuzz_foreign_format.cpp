// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz_reader.hpp"
#include "raybundle/io/foreign_format.hpp"

// The first byte chooses the format; what can be read has to come back from what is written of it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  return fuzz::only_errors(data, size, [](std::string_view text) {
    if (text.empty()) return;
    const auto formats = foreign_formats();
    const ForeignFormat& format = formats[static_cast<unsigned char>(text.front()) % formats.size()];
    const NamedText file{"fuzz", std::string(text.substr(1))};
    const std::vector<RigCamera> rig = rig_from_texts(format, {&file, 1});
    for (const RigCamera& camera : rig) {
      fuzz::require(camera.camera.parameters.allFinite(), "cameras are finite");
      fuzz::require(camera.camera.fx() > 0 && camera.camera.fy() > 0, "focal lengths are positive");
    }
    if (lens_for(format, rig[0].camera) == nullptr) return;  // what the program itself would refuse
    const std::vector<NamedText> texts = texts_from_rig(format, {{rig[0]}});
    fuzz::require(rig_from_texts(format, {texts.data(), 1}).size() == 1, "what is written is read");
  });
}
