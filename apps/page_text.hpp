// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace raybundle::apps {

/// JSON as it may stand in a <script> element: "</script>" in a file name would end that. In JSON "<" is always within
/// a string, where it has another spelling.
std::string json_for_script(std::string_view json);

/// A page with a text in place of {{name}}, where that stands first.
std::string filled(std::string_view page, std::string_view name, std::string_view text);

/// Bytes of an image as they stand in a page or in JSON.
std::string base64(std::string_view bytes);

/// JSON as text; what is no UTF-8, as a path may hold, is replaced.
template <typename Json>
std::string text_of_json(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace raybundle::apps
