// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace raybundle::apps {

// The pages of apps/pages/, embedded when the program is built (apps/pages/embed.cmake): whole but for their {{data}}.
extern const std::string_view kLaserPage;  ///< and {{picture}}
extern const std::string_view kOccupancyPage;
extern const std::string_view kStereoPage;

}  // namespace raybundle::apps
