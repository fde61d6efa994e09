// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_frame_input.hpp"

#include "file_of.hpp"
#include "fuzz_reader.hpp"

// What comes before the first zero byte is the JSON of a frame, the rest its PLY.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  return fuzz::only_errors(data, size, [](std::string_view bytes) {
    const std::size_t parted = std::min(bytes.find('\0'), bytes.size());
    fuzz::file_of("frame.ply", bytes.substr(std::min(parted + 1, bytes.size())));
    const apps::StereoFrameInput input(fuzz::file_of("frame.json", bytes.substr(0, parted)), false);
    const ImageView<const StereoPoint> points = input.frame().points;
    fuzz::require(points.width > 0 && points.height > 0, "an organised cloud");
  });
}
