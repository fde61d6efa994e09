// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "page_text.hpp"

#include <openssl/evp.h>

namespace raybundle::apps {

std::string json_for_script(std::string_view json) {
  std::string text;
  for (const char c : json) c == '<' ? text += "\\u003c" : text += c;
  return text;
}

std::string filled(std::string_view page, std::string_view name, std::string_view text) {
  std::string mark = "{{";
  mark.append(name).append("}}");
  std::string whole(page);
  return whole.replace(whole.find(mark), mark.size(), text);
}

std::string base64(std::string_view bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // with the 0 that is written behind it
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), reinterpret_cast<const unsigned char*>(bytes.data()),
                  static_cast<int>(bytes.size()));
  text.pop_back();
  return text;
}

}  // namespace raybundle::apps
