// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace raybundle::apps {

/// report.html: one self-contained page that draws everything from report.json and asks for nothing from a network.
///
/// @param report_json  the text of report.json, which is put into the page
/// @param images       folder that the report's image paths start from, as seen from the page's folder; empty: the same
std::string report_page(std::string_view report_json, const std::string& images = {});

/// What stands before and behind the report in its page, for reports that are too long to be copied.
struct ReportFrame {
  std::string before, behind;
};
ReportFrame report_frame(const std::string& images = {});

}  // namespace raybundle::apps
