# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0

# Writes <output> with the page's template, its style and its scripts as raw strings, one for each file, so that none
# comes near the longest literal that a compiler takes. Scripts are in the order of their names, main.js last.
function(raybundle_embed_report_page folder output)
  file(GLOB scripts CONFIGURE_DEPENDS ${folder}/*.js)
  list(SORT scripts)
  list(REMOVE_ITEM scripts ${folder}/main.js)
  list(APPEND scripts ${folder}/main.js)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder}/page.html ${folder}/page.css ${scripts})
  set(literals "")
  foreach(path IN LISTS scripts)
    file(READ ${path} text)
    string(APPEND literals "    R\"part(${text})part\",\n")
  endforeach()
  file(READ ${folder}/page.html template)
  file(READ ${folder}/page.css style)
  file(CONFIGURE OUTPUT ${output} @ONLY CONTENT
"// Generated from apps/report/ by apps/report/embed.cmake.
#include \"report_parts.hpp\"

namespace raybundle::apps {

const std::string_view kReportTemplate = R\"part(@template@)part\";
const std::string_view kReportStyle = R\"part(@style@)part\";
const std::vector<std::string_view> kReportScripts = {
@literals@};

}  // namespace raybundle::apps
")
endfunction()
