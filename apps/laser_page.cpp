// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "laser_page.hpp"

#include "page_parts.hpp"
#include "page_text.hpp"

namespace raybundle::apps {

std::string laser_page(std::string_view json, std::string_view jpeg) {
  return filled(filled(kLaserPage, "picture", base64(jpeg)), "data", json_for_script(json));
}

}  // namespace raybundle::apps
