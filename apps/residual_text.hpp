// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "raybundle/uncertainty/residual_bias.hpp"

namespace raybundle::apps {

/// Bias, noise, and the residuals by part of the image and by angle.
nlohmann::ordered_json json_from_bias(const ResidualBias& bias);

/// How much of a camera's residuals is bias, and where it is strongest: one line.
std::string bias_text(const std::string& camera, const ResidualBias& bias);

}  // namespace raybundle::apps
