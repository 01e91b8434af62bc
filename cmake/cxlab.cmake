# Targets of our own code.
#
#   cxlab_library(<target> FOLDER <folder>... [SOURCES a.cpp...] [ALONE a.cpp...] [DEPS targets...] [PRIVATE_DEPS targets...]
#                 [COLD])
#   cxlab_executable(<target> SOURCES a.cpp... [DEPS targets...])
#   cxlab_test(<name> [IN <program>] SOURCES a.cpp... [ALONE a.cpp...] [DEPS targets...] [LONG])
#
# FOLDER is counted from the root of the project. Its headers (not those of folders below it) are included as "<folder>/name.h".
# Only targets that have this one in their DEPS, directly or through the DEPS of another, can include them: the root itself is on
# no include path. A library without SOURCES is an interface.
#
# With CXLAB_UNITY (presets release and asan) the SOURCES of a library or test are compiled together, which takes a third of the
# time; their anonymous namespaces are then one. Those in ALONE, whose names meet those of other files, are compiled alone.
# COLD: no tick runs through it, so it is compiled with -O1, in half the time.

include_guard(GLOBAL)

set(CXLAB_C_WARNINGS -Wall -Wextra -Werror)
set(CXLAB_WARNINGS -Wall -Wextra -Wshadow -Wconversion -Wsign-conversion -Wold-style-cast -Werror)

# Headers that are compiled once for all libraries (CXLAB_UNITY) and for all tests.
set(CXLAB_COMMON_HEADERS <Eigen/Geometry> <algorithm> <any> <array> <atomic> <charconv> <chrono> <cmath> <deque> <filesystem>
  <fstream> <functional> <future> <map> <memory> <mutex> <optional> <random> <ranges> <set> <span> <sstream> <string>
  <string_view> <thread> <unordered_map> <variant> <vector>)

option(CXLAB_UNITY "Compile the sources of a library together: a third of the time for a whole build" OFF)

# Fills build/include/<target> with links to the headers of the folders.
function(_cxlab_publish_headers target out)
  set(public "${CMAKE_BINARY_DIR}/include/${target}")
  file(REMOVE_RECURSE "${public}")
  foreach(folder IN LISTS ARGN)
    file(MAKE_DIRECTORY "${public}/${folder}")
    file(GLOB headers CONFIGURE_DEPENDS "${CMAKE_SOURCE_DIR}/${folder}/*.h")
    foreach(header IN LISTS headers)
      get_filename_component(name "${header}" NAME)
      file(CREATE_LINK "${header}" "${public}/${folder}/${name}" SYMBOLIC)
    endforeach()
  endforeach()
  set(${out} "${public}" PARENT_SCOPE)
endfunction()

function(_cxlab_note_dependencies target)
  foreach(dependency IN LISTS ARGN)
    set_property(GLOBAL APPEND PROPERTY CXLAB_DEPENDENCIES "${target}>${dependency}")
  endforeach()
endfunction()

# A misspelt name in DEPS would else become a library to search for.
function(cxlab_check_dependencies)
  get_property(pairs GLOBAL PROPERTY CXLAB_DEPENDENCIES)
  foreach(pair IN LISTS pairs)
    string(REGEX MATCH "^([^>]+)>(.+)$" _ "${pair}")
    if(NOT TARGET ${CMAKE_MATCH_2})
      message(SEND_ERROR "${CMAKE_MATCH_1}: ${CMAKE_MATCH_2}, named in its DEPS, is not a target")
    endif()
  endforeach()
endfunction()

# With CXLAB_UNITY: all sources of the target but the named ones are one file.
function(cxlab_compile_together target)
  if(CXLAB_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
    set_source_files_properties(${ARGN} TARGET_DIRECTORY ${target} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    # A class of a source file is then a class of an included file, which may not have members of anonymous types. A local
    # name may also appear in another file.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage -Wno-shadow -Wshadow=local)
  endif()
endfunction()

function(cxlab_library target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "COLD" "" "FOLDER;SOURCES;ALONE;DEPS;PRIVATE_DEPS")
  if(arg_UNPARSED_ARGUMENTS OR NOT arg_FOLDER)
    message(FATAL_ERROR "cxlab_library(${target}): needs FOLDER; not understood: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  _cxlab_publish_headers(${target} headers ${arg_FOLDER})
  _cxlab_note_dependencies(${target} ${arg_DEPS} ${arg_PRIVATE_DEPS})
  if(arg_SOURCES)
    add_library(${target} STATIC ${arg_SOURCES} ${arg_ALONE})
    target_include_directories(${target} PUBLIC "${headers}")
    target_link_libraries(${target} PUBLIC ${arg_DEPS} PRIVATE ${arg_PRIVATE_DEPS})
    target_compile_options(${target} PRIVATE
      "$<$<COMPILE_LANGUAGE:CXX>:${CXLAB_WARNINGS}>" "$<$<COMPILE_LANGUAGE:C>:${CXLAB_C_WARNINGS}>")
    # A precompiled header costs each of its users time: GCC makes again the templates that it leaves open. Most of that is JSON, and
    # what is not cold has little of it.
    set(precompiled precompiled_for_libraries)
    if(arg_COLD)
      target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
      set(precompiled precompiled_for_cold_libraries HEADERS <nlohmann/json.hpp>)
    endif()
    if(CXLAB_UNITY AND arg_SOURCES MATCHES "\\.cpp")
      cxlab_compile_together(${target} ${arg_ALONE})
      list(POP_FRONT precompiled name)
      cxlab_precompiled(${name} ${target} ${precompiled})
    endif()
  else()
    add_library(${target} INTERFACE)
    target_include_directories(${target} INTERFACE "${headers}")
    target_link_libraries(${target} INTERFACE ${arg_DEPS})
  endif()
endfunction()

# LINKED: a library that has parts of the DEPS, too; the program takes them from there.
function(cxlab_executable target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "LINKED" "SOURCES;DEPS")
  if(arg_UNPARSED_ARGUMENTS OR NOT arg_SOURCES)
    message(FATAL_ERROR "cxlab_executable(${target}): needs SOURCES; not understood: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  _cxlab_note_dependencies(${target} ${arg_DEPS})
  add_executable(${target} ${arg_SOURCES})
  if(arg_LINKED)
    target_link_libraries(${target} PRIVATE $<LINK_ONLY:${arg_LINKED}>)
  endif()
  target_link_libraries(${target} PRIVATE ${arg_DEPS})
  target_compile_options(${target} PRIVATE ${CXLAB_WARNINGS})
  if(CXLAB_SANITIZE MATCHES "address" AND NOT CXLAB_SANITIZE MATCHES "fuzzer")
    target_sources(${target} PRIVATE "${PROJECT_SOURCE_DIR}/cmake/leaks_of_others.cpp")
  endif()
endfunction()

# Gives a target the common headers and <header.h>..., compiled once for all targets with the same `name`. They are compiled like the
# first of these targets, and GCC takes the level of optimisation from there, too. LIBRARIES have the headers.
function(cxlab_precompiled name target)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "HEADERS;LIBRARIES")
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -fpch-preprocess)  # for ccache
  endif()
  if(NOT TARGET ${name})
    file(WRITE "${CMAKE_BINARY_DIR}/${name}.cpp" "int main() {}\n")
    get_target_property(type ${target} TYPE)
    if(type STREQUAL "EXECUTABLE")
      add_executable(${name} EXCLUDE_FROM_ALL "${CMAKE_BINARY_DIR}/${name}.cpp")
    else()
      add_library(${name} OBJECT EXCLUDE_FROM_ALL "${CMAKE_BINARY_DIR}/${name}.cpp")
    endif()
    get_target_property(options ${target} COMPILE_OPTIONS)
    target_compile_options(${name} PRIVATE ${options})
    target_link_libraries(${name} PRIVATE Eigen3::Eigen ${arg_LIBRARIES})
    target_precompile_headers(${name} PRIVATE ${arg_HEADERS} ${CXLAB_COMMON_HEADERS})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${name})
endfunction()

# The target of a test in CXLAB_CORE_TESTS (tests/CMakeLists.txt) belongs to core_tests, and the test has the label core.
add_custom_target(core_tests)
function(cxlab_core_test name target)
  if(name IN_LIST CXLAB_CORE_TESTS)
    set_property(TEST ${name} APPEND PROPERTY LABELS core)
    add_dependencies(core_tests ${target})
  endif()
endfunction()

# Makes a program of tests, build/<preset>/tests/<program>, whose SOURCES are compiled together; or adds SOURCES and DEPS to it.
function(cxlab_test_program program)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPS")
  if(TARGET ${program})
    _cxlab_note_dependencies(${program} ${arg_DEPS})
    target_sources(${program} PRIVATE ${arg_SOURCES})
    target_link_libraries(${program} PRIVATE ${arg_DEPS})
    return()
  endif()
  # Code of cxlab in the program itself would call the inline functions that the linker finds first: those of the tests,
  # which are not optimised.
  cxlab_executable(${program} LINKED cxlab_shared SOURCES ${arg_SOURCES} DEPS ${arg_DEPS} test_support GTest::gmock GTest::gtest)
  set_target_properties(${program} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/tests")
  target_compile_options(${program} PRIVATE -O0)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")  # it collects its garbage at 128 MB by default, again and again
    target_compile_options(${program} PRIVATE "SHELL:--param ggc-min-heapsize=500000")
  endif()
  cxlab_compile_together(${program})
  cxlab_precompiled(precompiled_for_tests ${program} HEADERS <gmock/gmock.h> <gtest/gtest.h> LIBRARIES GTest::gmock GTest::gtest)
endfunction()

# One entry of ctest, label short or long: the tests in these sources, with the headers of tests/support. The target <name> makes its
# program, build/<preset>/tests/<program>. Tests IN one program are compiled together, so that the templates of GoogleTest, JSON and the
# standard library are made once for all of them. They find data under $CXLAB_SOURCE_DIR, by default the sources that they were made
# from. <name>_command is set to what runs the test.
function(cxlab_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "LONG" "IN" "SOURCES;ALONE;DEPS")
  if(arg_UNPARSED_ARGUMENTS OR NOT arg_SOURCES)
    message(FATAL_ERROR "cxlab_test(${name}): needs SOURCES; not understood: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  foreach(list IN ITEMS arg_SOURCES arg_ALONE)
    list(TRANSFORM ${list} PREPEND "${CMAKE_CURRENT_SOURCE_DIR}/" REGEX "^[^/$]")
  endforeach()
  set(program ${name})
  if(arg_IN)
    set(program ${arg_IN})
    add_custom_target(${name})
    add_dependencies(${name} ${program})
  endif()
  cxlab_test_program(${program} SOURCES ${arg_SOURCES} ${arg_ALONE} DEPS ${arg_DEPS} test_main)
  if(arg_ALONE)
    set_source_files_properties(${arg_ALONE} TARGET_DIRECTORY ${program} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
  set(command ${program})
  if(arg_IN)
    list(TRANSFORM arg_SOURCES REPLACE "^${CMAKE_SOURCE_DIR}/" "")
    list(TRANSFORM arg_ALONE REPLACE "^${CMAKE_SOURCE_DIR}/" "")
    list(JOIN arg_SOURCES "," files)
    foreach(file IN LISTS arg_ALONE)
      string(APPEND files ",${file}")
    endforeach()
    list(APPEND command --files=${files})
  endif()
  set(${name}_command ${command} PARENT_SCOPE)
  add_test(NAME ${name} COMMAND ${command})
  set(label short)
  set(timeout 120)
  if(CXLAB_SANITIZE)  # several times slower
    set(timeout 480)
  endif()
  if(arg_LONG)
    set(label long)
    set(timeout 3600)
  endif()
  set_tests_properties(${name} PROPERTIES
    LABELS ${label} TIMEOUT ${timeout} ENVIRONMENT "CXLAB_SOURCE_DIR=${CMAKE_SOURCE_DIR}")
  cxlab_core_test(${name} ${program})
endfunction()
