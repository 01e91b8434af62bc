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
# find_package(cxlab) finds; a header of another Debian package is an error. In a whole build one file includes all of them;
# installed_headers_alone, and the long test of its name, compiles each header by itself, which takes minutes.
function(cxlab_check_installed_headers)
  set(check "${PROJECT_BINARY_DIR}/installed/check")
  get_target_property(eigen Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
  get_property(installed_headers GLOBAL PROPERTY CXLAB_INSTALLED_HEADERS)
  _cxlab_check_headers(together "all installed headers" "${installed_headers}")
  foreach(pair IN LISTS installed_headers)
    string(REGEX MATCH "^([^>]+)>" _ "${pair}")
    _cxlab_check_headers(alone "${CMAKE_MATCH_1}" "${pair}")
  endforeach()
  add_custom_target(installed_headers DEPENDS ${stamps_together})
  add_custom_target(installed_headers_alone DEPENDS ${stamps_alone})
  foreach(target IN ITEMS installed_headers installed_headers_alone)
    add_test(NAME ${target} COMMAND ${CMAKE_COMMAND} --build "${PROJECT_BINARY_DIR}" --target ${target})
  endforeach()
  add_custom_target(installed_headers_in_all ALL DEPENDS installed_headers)
  set_tests_properties(installed_headers PROPERTIES LABELS short TIMEOUT 600)
  set_tests_properties(installed_headers_alone PROPERTIES LABELS long TIMEOUT 3600)
endfunction()

# A stamp, named in stamps_<way>: those headers compile.
macro(_cxlab_check_headers way name pairs)
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
    COMMAND ${CMAKE_CXX_COMPILER} -std=c++20 ${CXLAB_WARNINGS} -fsyntax-only -MD -MF "${stem}.d" -MT "${stem}.stamp"
            "-I${CXLAB_INSTALLED_INCLUDE}" -isystem "${eigen}" "${stem}.cpp"
    COMMAND ${CMAKE_COMMAND} -D "dependencies=${stem}.d" -D "header=${name}" -P "${PROJECT_SOURCE_DIR}/cmake/package/check_header.cmake"
    COMMAND ${CMAKE_COMMAND} -E touch "${stem}.stamp"
    DEPENDS ${files} "${stem}.cpp" "${PROJECT_BINARY_DIR}/include/cx_abi/cx/executive/abi.h" "${PROJECT_SOURCE_DIR}/cmake/package/check_header.cmake"
    DEPFILE "${stem}.d"
    COMMENT "Compiling ${name}")
  list(APPEND stamps_${way} "${stem}.stamp")
endmacro()
