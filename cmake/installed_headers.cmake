# Headers that are installed, and the check that they compile with nothing but what is installed.
#
#   cxlab_install_headers(<folder> a.h...)   installs them below include/cxlab/<folder>
#   cxlab_check_installed_headers()          the target installed_headers, part of a whole build, and the test of its name

include_guard(GLOBAL)

set(CXLAB_INSTALLED_INCLUDE "${PROJECT_BINARY_DIR}/installed/include")
file(REMOVE_RECURSE "${CXLAB_INSTALLED_INCLUDE}")

function(cxlab_install_headers folder)
  install(FILES ${ARGN} DESTINATION ${headers}/${folder})
  foreach(file IN LISTS ARGN)
    get_filename_component(name "${file}" NAME)
    file(MAKE_DIRECTORY "${CXLAB_INSTALLED_INCLUDE}/${folder}")
    file(CREATE_LINK "${file}" "${CXLAB_INSTALLED_INCLUDE}/${folder}/${name}" SYMBOLIC)
    set_property(GLOBAL APPEND PROPERTY CXLAB_INSTALLED_HEADERS "${folder}/${name}>${file}")
  endforeach()
endfunction()

# Files that include headers, compiled without making code. Beside the installed headers they may include Eigen's, which
# find_package(cxlab) finds; a header of another Debian package is an error. In a whole build a file includes the headers of a folder,
# after the common headers of cxlab.cmake; installed_headers_alone, and the long test of its name, compiles each header by itself, which
# takes ten times as long.
function(cxlab_check_installed_headers)
  set(check "${PROJECT_BINARY_DIR}/installed/check")
  get_target_property(eigen Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
  set(compiler ${CMAKE_CXX_COMPILER} -std=c++20 ${CXLAB_WARNINGS})
  list(TRANSFORM CXLAB_COMMON_HEADERS REPLACE "(.+)" "#include \\1\n" OUTPUT_VARIABLE common)
  string(JOIN "" common ${common})
  file(CONFIGURE OUTPUT "${check}/common.h" CONTENT "${common}")
  add_custom_command(OUTPUT "${check}/common.h.gch"
    COMMAND ${compiler} -isystem "${eigen}" -x c++-header "${check}/common.h" -o "${check}/common.h.gch"
    DEPENDS "${check}/common.h"
    COMMENT "Compiling the common headers for the check of installed headers")
  get_property(installed_headers GLOBAL PROPERTY CXLAB_INSTALLED_HEADERS)
  set(folders "")
  foreach(pair IN LISTS installed_headers)
    string(REGEX MATCH "^([^>]+)/[^/>]+>" _ "${pair}")
    list(APPEND folders "${CMAKE_MATCH_1}")
    list(APPEND "headers_of_${CMAKE_MATCH_1}" "${pair}")
  endforeach()
  list(REMOVE_DUPLICATES folders)
  foreach(folder IN LISTS folders)
    _cxlab_check_headers(quick "${folder}" "${headers_of_${folder}}" "${check}/common.h.gch" "-include;${check}/common.h")
  endforeach()
  foreach(pair IN LISTS installed_headers)
    string(REGEX MATCH "^([^>]+)>" _ "${pair}")
    _cxlab_check_headers(alone "${CMAKE_MATCH_1}" "${pair}" "" "")
  endforeach()
  add_custom_target(installed_headers DEPENDS ${stamps_quick})
  add_custom_target(installed_headers_alone DEPENDS ${stamps_alone})
  foreach(target IN ITEMS installed_headers installed_headers_alone)
    add_test(NAME ${target} COMMAND ${CMAKE_COMMAND} --build "${PROJECT_BINARY_DIR}" --target ${target})
  endforeach()
  add_custom_target(installed_headers_in_all ALL DEPENDS installed_headers)
  set_tests_properties(installed_headers PROPERTIES LABELS short TIMEOUT 600)
  set_tests_properties(installed_headers_alone PROPERTIES LABELS long TIMEOUT 3600)
endfunction()

# A stamp, named in stamps_<way>: the headers of a folder, or one, compile together with those options.
macro(_cxlab_check_headers way name pairs needed options)
  string(MAKE_C_IDENTIFIER "${name}" stem)
  set(stem "${check}/${way}/${stem}")
  set(text "")
  set(files "")
  foreach(one ${pairs})
    string(REGEX MATCH "^([^>]+)>(.+)$" _ "${one}")
    string(APPEND text "#include \"${CMAKE_MATCH_1}\"\n")
    list(APPEND files "${CMAKE_MATCH_2}")
  endforeach()
  file(CONFIGURE OUTPUT "${stem}.cpp" CONTENT "${text}")
  add_custom_command(OUTPUT "${stem}.stamp"
    COMMAND ${compiler} ${options} -fsyntax-only -MD -MF "${stem}.d" -MT "${stem}.stamp"
            "-I${CXLAB_INSTALLED_INCLUDE}" -isystem "${eigen}" "${stem}.cpp"
    COMMAND ${CMAKE_COMMAND} -D "dependencies=${stem}.d" -D "header=${name}" -P "${PROJECT_SOURCE_DIR}/cmake/package/check_header.cmake"
    COMMAND ${CMAKE_COMMAND} -E touch "${stem}.stamp"
    DEPENDS ${files} "${stem}.cpp" "${PROJECT_BINARY_DIR}/include/cx_abi/cx/executive/abi.h" "${PROJECT_SOURCE_DIR}/cmake/package/check_header.cmake"
            ${needed}
    DEPFILE "${stem}.d"
    COMMENT "Compiling the headers of ${name}")
  list(APPEND stamps_${way} "${stem}.stamp")
endmacro()
