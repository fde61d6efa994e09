// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "report_page.hpp"

#include "page_text.hpp"
#include "raybundle/geometry/error.hpp"
#include "report_parts.hpp"

namespace raybundle::apps {
namespace {

std::string replaced(std::string_view text, char what, std::string_view by) {
  std::string result;
  result.reserve(text.size());
  for (const char c : text) {
    if (c == what) {
      result += by;
    } else {
      result += c;
    }
  }
  return result;
}

std::string text_for_attribute(std::string_view text) {
  return replaced(replaced(replaced(text, '&', "&amp;"), '"', "&quot;"), '<', "&lt;");
}

std::string joined_script() {
  std::string text;
  for (const std::string_view piece : kReportScript) text += piece;
  return text;
}

std::string part_named(std::string_view name, const std::string& report_json, const std::string& images) {
  if (name == "style") return std::string(kReportStyle);
  if (name == "script") return joined_script();
  if (name == "report") return json_for_script(report_json);
  if (name == "images") return text_for_attribute(images.empty() ? images : images + "/");
  throw Error(ErrorKind::kBadInput, "the page has no part of that name; see apps/report_page.cpp", std::string(name));
}

}  // namespace

std::string report_page(const std::string& report_json, const std::string& images) {
  std::string page;
  std::string_view rest = kReportTemplate;
  for (std::size_t begin = rest.find("{{"); begin != rest.npos; begin = rest.find("{{")) {
    const std::size_t end = rest.find("}}", begin);
    page += rest.substr(0, begin);
    page += part_named(rest.substr(begin + 2, end - begin - 2), report_json, images);
    rest.remove_prefix(end + 2);
  }
  return page += rest;
}

}  // namespace raybundle::apps
