// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/survey_files.hpp"

#include "fuzz_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raybundle;
  return fuzz::only_errors(data, size, [](std::string_view text) {
    const auto landmarks = landmarks_from_csv_text(text, "fuzz.csv", Geodetic{43.5, 1.5, 200.0}, HeightDatum{47.0});
    for (const Landmark& landmark : landmarks) {
      fuzz::require(landmark.x_in_local.allFinite() && landmark.sigma >= 0.0, "landmarks are places");
    }
    sightings_from_csv_text("image,u,v,name\na.png,1,2," + landmarks.front().name + "\n", "fuzz.csv", landmarks);
  });
}
