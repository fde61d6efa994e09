// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace raybundle::apps {

/// report.html: one self-contained page that draws everything from report.json.
///
/// @param report_json  the text of report.json, which is put into the page
std::string report_page(const std::string& report_json);

}  // namespace raybundle::apps
