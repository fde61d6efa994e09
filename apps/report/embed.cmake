# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0

# Included: raybundle_embed_report_page() bundles the page's scripts with three.js and makes a source file of the page.
# Run as a script (-DFOLDER, -DBUNDLE, -DOUTPUT): writes that source file.

function(raybundle_embed_report_page folder output)
  find_program(ESBUILD esbuild REQUIRED)
  find_file(THREE_MODULE three.module.js PATHS /usr/share/javascript/three /usr/share/nodejs/three/build REQUIRED)
  file(GLOB parts CONFIGURE_DEPENDS ${folder}/*.js)
  set(bundle ${CMAKE_CURRENT_BINARY_DIR}/report_bundle.js)
  add_custom_command(
    OUTPUT ${output} ${bundle}
    COMMAND ${ESBUILD} ${folder}/main.js --bundle --minify --format=iife --legal-comments=inline --log-level=warning
            --alias:three=${THREE_MODULE} --outfile=${bundle}
    COMMAND ${CMAKE_COMMAND} -DFOLDER=${folder} -DBUNDLE=${bundle} -DOUTPUT=${output} -P ${folder}/embed.cmake
    DEPENDS ${parts} ${folder}/page.html ${folder}/page.css ${folder}/embed.cmake ${THREE_MODULE}
    COMMENT "Bundling the report page"
    VERBATIM)
endfunction()

# A text as raw strings, none of which comes near the longest literal that a compiler takes.
function(literals text result)
  set(pieces "")
  string(LENGTH "${text}" length)
  set(at 0)
  while(at LESS length)
    string(SUBSTRING "${text}" ${at} 16000 piece)
    string(APPEND pieces "    R\"part(${piece})part\",\n")
    math(EXPR at "${at} + 16000")
  endwhile()
  set(${result} "${pieces}" PARENT_SCOPE)
endfunction()

if(CMAKE_SCRIPT_MODE_FILE)
  cmake_minimum_required(VERSION 3.25)
  file(READ ${BUNDLE} script)
  literals("${script}" script_literals)
  file(READ ${FOLDER}/page.html template)
  file(READ ${FOLDER}/page.css style)
  file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT
"// Generated from apps/report/ by apps/report/embed.cmake.
#include \"report_parts.hpp\"

namespace raybundle::apps {

const std::string_view kReportTemplate = R\"part(@template@)part\";
const std::string_view kReportStyle = R\"part(@style@)part\";
const std::vector<std::string_view> kReportScript = {
@script_literals@};

}  // namespace raybundle::apps
")
endif()
