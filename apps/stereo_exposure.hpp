// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "raybundle/stereo/exposure_control.hpp"

namespace raybundle::apps {

/// What the exposure control would set, for images that were all taken with one exposure.
class ExposureAdvice {
 public:
  /// @param taken_with  shutter [ms] and gain
  ExposureAdvice(ImageSize size, const std::vector<double>& taken_with);

  /// The "exposure" of docs/formats/stereo.md.
  nlohmann::ordered_json advise(GreyView image);

  /// The last advice in a few words, for a row of a table.
  std::string words() const;

 private:
  Exposure taken_with_;
  ExposureControl control_;
  ExposureReport report_;
};

}  // namespace raybundle::apps
