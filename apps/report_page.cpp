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

void append_part(std::string_view name, const std::string& report_json, const std::string& images, std::string& page) {
  if (name == "style") {
    page += kReportStyle;
  } else if (name == "script") {
    for (const std::string_view piece : kReportScript) page += piece;
  } else if (name == "report") {
    append_json_for_script(report_json, page);  // the one that may be long
  } else if (name == "images") {
    page += text_for_attribute(images.empty() ? images : images + "/");
  } else {
    throw Error(ErrorKind::kBadInput, "the page has no part of that name; see apps/report_page.cpp", std::string(name));
  }
}

}  // namespace

std::string report_page(const std::string& report_json, const std::string& images) {
  std::size_t size = kReportTemplate.size() + kReportStyle.size() + report_json.size();
  for (const std::string_view piece : kReportScript) size += piece.size();
  std::string page;
  // A report may be long; the little more is for what has to be spelt otherwise.
  page.reserve(size + size / 64);
  std::string_view rest = kReportTemplate;
  for (std::size_t begin = rest.find("{{"); begin != rest.npos; begin = rest.find("{{")) {
    const std::size_t end = rest.find("}}", begin);
    page += rest.substr(0, begin);
    append_part(rest.substr(begin + 2, end - begin - 2), report_json, images, page);
    rest.remove_prefix(end + 2);
  }
  return page += rest;
}

}  // namespace raybundle::apps
