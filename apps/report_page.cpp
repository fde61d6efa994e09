// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "report_page.hpp"

namespace raybundle::apps {
namespace {

// The text stands inside a script element: "</script" in a file name must not end it. "<" in JSON is always in a
// string.
std::string json_for_script(const std::string& json) {
  std::string text;
  text.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      text += "\\u003c";
    } else {
      text += c;
    }
  }
  return text;
}

}  // namespace

std::string report_page(const std::string& report_json) {
  return "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>Raybundle report</title>\n"
         "<script type=\"application/json\" id=\"report\">" +
         json_for_script(report_json) + "</script>\n</html>\n";
}

}  // namespace raybundle::apps
