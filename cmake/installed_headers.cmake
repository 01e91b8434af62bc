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
# find_package(cxlab) finds; a header of another Debian package is an error.
function(cxlab_check_installed_headers)
  get_property(installed_headers GLOBAL PROPERTY CXLAB_INSTALLED_HEADERS)
  get_target_property(eigen Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
  set(stamps "")
  foreach(pair IN LISTS installed_headers)
    string(REGEX MATCH "^([^>]+)>(.+)$" _ "${pair}")
    set(header "${CMAKE_MATCH_1}")
    set(file "${CMAKE_MATCH_2}")
    string(MAKE_C_IDENTIFIER "${header}" name)
    set(stem "${PROJECT_BINARY_DIR}/installed/check/${name}")
    file(CONFIGURE OUTPUT "${stem}.cpp" CONTENT "#include \"${header}\"\n")
    add_custom_command(OUTPUT "${stem}.stamp"
      COMMAND ${CMAKE_CXX_COMPILER} -std=c++20 ${CXLAB_WARNINGS} -fsyntax-only -MD -MF "${stem}.d" -MT "${stem}.stamp"
              "-I${CXLAB_INSTALLED_INCLUDE}" -isystem "${eigen}" "${stem}.cpp"
      COMMAND ${CMAKE_COMMAND} -D "dependencies=${stem}.d" -D "header=${header}" -P "${PROJECT_SOURCE_DIR}/cmake/package/check_header.cmake"
      COMMAND ${CMAKE_COMMAND} -E touch "${stem}.stamp"
      DEPENDS "${file}" "${stem}.cpp" "${PROJECT_BINARY_DIR}/include/cx_abi/cx/executive/abi.h" "${PROJECT_SOURCE_DIR}/cmake/package/check_header.cmake"
      DEPFILE "${stem}.d"
      COMMENT "Compiling ${header} alone")
    list(APPEND stamps "${stem}.stamp")
  endforeach()
  add_custom_target(installed_headers ALL DEPENDS ${stamps})
  add_test(NAME installed_headers COMMAND ${CMAKE_COMMAND} --build "${PROJECT_BINARY_DIR}" --target installed_headers)
  set_tests_properties(installed_headers PROPERTIES LABELS short TIMEOUT 600)
endfunction()
