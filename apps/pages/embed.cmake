# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0

# Included: raybundle_embed_pages() makes a source file of the pages.
# Run as a script (-DFOLDER, -DOUTPUT): writes that source file.

function(raybundle_embed_pages folder output)
  file(GLOB parts CONFIGURE_DEPENDS ${folder}/*)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DFOLDER=${folder} -DOUTPUT=${output} -P ${folder}/embed.cmake
    DEPENDS ${parts}
    COMMENT "Embedding the pages"
    VERBATIM)
endfunction()

# The page NAME.html with {{style.css}} and {{script.js}} replaced by these files; {{data}} is for the program.
function(page name result)
  file(READ ${FOLDER}/${name}.html text)
  file(GLOB parts RELATIVE ${FOLDER} ${FOLDER}/*.css ${FOLDER}/*.js)
  foreach(part IN LISTS parts)
    file(READ ${FOLDER}/${part} content)
    string(REPLACE "{{${part}}}" "${content}" text "${text}")
  endforeach()
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

if(CMAKE_SCRIPT_MODE_FILE)
  cmake_minimum_required(VERSION 3.25)
  page(laser laser)
  page(occupancy occupancy)
  page(stereo stereo)
  file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT
"// Generated from apps/pages/ by apps/pages/embed.cmake.
#include \"page_parts.hpp\"

namespace raybundle::apps {

const std::string_view kLaserPage = R\"page(@laser@)page\";
const std::string_view kOccupancyPage = R\"page(@occupancy@)page\";
const std::string_view kStereoPage = R\"page(@stereo@)page\";

}  // namespace raybundle::apps
")
endif()
