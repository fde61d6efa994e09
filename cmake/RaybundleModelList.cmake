# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0

# Writes <output> with one #include per file of camera/models/ and `using Models = TypeList<...>`.
# models/kannala_brandt.hpp must define raybundle::KannalaBrandt. This is the only list of models there is.
function(raybundle_generate_model_list folder output)
  file(GLOB files CONFIGURE_DEPENDS RELATIVE ${folder} ${folder}/*.hpp)
  list(SORT files)
  set(includes "")
  set(types "")
  foreach(file IN LISTS files)
    string(APPEND includes "#include \"raybundle/camera/models/${file}\"\n")
    string(REPLACE ".hpp" "" words ${file})
    string(REPLACE "_" ";" words ${words})
    set(type "")
    foreach(word IN LISTS words)
      string(SUBSTRING ${word} 0 1 head)
      string(SUBSTRING ${word} 1 -1 tail)
      string(TOUPPER ${head} head)
      string(APPEND type ${head}${tail})
    endforeach()
    list(APPEND types ${type})
  endforeach()
  list(JOIN types ", " types)
  file(CONFIGURE OUTPUT ${output} @ONLY CONTENT
"// Generated from calib_core/camera/include/raybundle/camera/models/ by cmake/RaybundleModelList.cmake.
#pragma once

@includes@
#include \"raybundle/camera/type_list.hpp\"

namespace raybundle {

using Models = TypeList<@types@>;

}  // namespace raybundle
")
endfunction()
