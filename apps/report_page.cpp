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

std::string part_named(std::string_view name, const std::string& images) {
  if (name == "style") return std::string(kReportStyle);
  if (name == "images") return text_for_attribute(images.empty() ? images : images + "/");
  if (name != "script") {
    throw Error(ErrorKind::kBadInput, "the page has no part of that name; see apps/report_page.cpp", std::string(name));
  }
  std::string script;
  for (const std::string_view piece : kReportScript) script += piece;
  return script;
}

}  // namespace

ReportFrame report_frame(const std::string& images) {
  ReportFrame frame;
  std::string* text = &frame.before;
  std::string_view rest = kReportTemplate;
  for (std::size_t begin = rest.find("{{"); begin != rest.npos; begin = rest.find("{{")) {
    const std::size_t end = rest.find("}}", begin);
    const std::string_view name = rest.substr(begin + 2, end - begin - 2);
    *text += rest.substr(0, begin);
    if (name == "report") {
      text = &frame.behind;
    } else {
      *text += part_named(name, images);
    }
    rest.remove_prefix(end + 2);
  }
  *text += rest;
  return frame;
}

std::string report_page(std::string_view report_json, const std::string& images) {
  const ReportFrame frame = report_frame(images);
  return frame.before + json_for_script(report_json) + frame.behind;
}

}  // namespace raybundle::apps
