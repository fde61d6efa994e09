// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

namespace raybundle::apps {

// The files of apps/report/, embedded when the program is built (apps/report/embed.cmake).
extern const std::string_view kReportTemplate;  ///< page.html with {{style}}, {{images}}, {{report}}, {{script}}
extern const std::string_view kReportStyle;     ///< page.css
extern const std::vector<std::string_view> kReportScript;  ///< one script in pieces, which are to be joined

}  // namespace raybundle::apps
