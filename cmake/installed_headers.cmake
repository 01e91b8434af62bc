# Headers that are installed, and the check that each of them compiles alone with nothing but what is installed.
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

# A file for each header, compiled without making code. Beside the installed headers it may include Eigen's, which
# find_package(cxlab) finds; a header of another Debian package is an error. The common headers of cxlab.cmake
# are there already, which takes a quarter of the time; the target installed_headers_alone and the long test of its name do without.
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
  _cxlab_check_headers(installed_headers "${check}/quick" "${check}/common.h.gch" "-include;${check}/common.h")
  _cxlab_check_headers(installed_headers_alone "${check}/alone" "" "")
  add_custom_target(installed_headers_in_all ALL DEPENDS installed_headers)
  set_tests_properties(installed_headers PROPERTIES LABELS short TIMEOUT 600)
  set_tests_properties(installed_headers_alone PROPERTIES LABELS long TIMEOUT 3600)
endfunction()

# A target, and a test that builds it: each header compiles with those options.
function(_cxlab_check_headers target folder needed options)
  get_property(installed_headers GLOBAL PROPERTY CXLAB_INSTALLED_HEADERS)
  set(stamps "")
  foreach(pair IN LISTS installed_headers)
    string(REGEX MATCH "^([^>]+)>(.+)$" _ "${pair}")
    set(header "${CMAKE_MATCH_1}")
    set(file "${CMAKE_MATCH_2}")
    string(MAKE_C_IDENTIFIER "${header}" name)
    set(stem "${folder}/${name}")
    file(CONFIGURE OUTPUT "${stem}.cpp" CONTENT "#include \"${header}\"\n")
    add_custom_command(OUTPUT "${stem}.stamp"
      COMMAND ${compiler} ${options} -fsyntax-only -MD -MF "${stem}.d" -MT "${stem}.stamp"
              "-I${CXLAB_INSTALLED_INCLUDE}" -isystem "${eigen}" "${stem}.cpp"
      COMMAND ${CMAKE_COMMAND} -D "dependencies=${stem}.d" -D "header=${header}" -P "${PROJECT_SOURCE_DIR}/cmake/package/check_header.cmake"
      COMMAND ${CMAKE_COMMAND} -E touch "${stem}.stamp"
      DEPENDS "${file}" "${stem}.cpp" "${PROJECT_BINARY_DIR}/include/cx_abi/cx/executive/abi.h" "${PROJECT_SOURCE_DIR}/cmake/package/check_header.cmake"
              ${needed}
      DEPFILE "${stem}.d"
      COMMENT "Compiling ${header} alone")
    list(APPEND stamps "${stem}.stamp")
  endforeach()
  add_custom_target(${target} DEPENDS ${stamps})
  add_test(NAME ${target} COMMAND ${CMAKE_COMMAND} --build "${PROJECT_BINARY_DIR}" --target ${target})
endfunction()
