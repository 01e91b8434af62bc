# Functions for packages outside of cxlab. A package has one name, that of its share folder: <prefix>/share/<package>.
#
#   cxlab_plugin(<target> PACKAGE <package> SOURCES a.cpp... [MANIFEST cxlab_plugins.yaml])
#       A plugin library, and the rules that install it: lib/lib<target>.so, share/<package>/cxlab_plugins.yaml.
#   cxlab_interfaces(<package> DIRECTORY <folder>)
#       Interface definitions, in folders msg, srv and action below <folder>: share/<package>/{msg,srv,action}.
#   cxlab_share(<package> FILES_OR_FOLDERS...)
#       Anything else that belongs to share/<package>: configurations, rules.
#
# Each also links or copies into <build>/share and <build>/lib, so that the build folder is a prefix, too:
# cxlab env --prefix build ...

include_guard(GLOBAL)

function(cxlab_plugin target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "PACKAGE;MANIFEST" "SOURCES")
  if(arg_UNPARSED_ARGUMENTS OR NOT arg_PACKAGE OR NOT arg_SOURCES)
    message(FATAL_ERROR "cxlab_plugin(${target}): needs PACKAGE and SOURCES; not understood: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  if(NOT arg_MANIFEST)
    set(arg_MANIFEST cxlab_plugins.yaml)
  endif()
  get_filename_component(manifest "${arg_MANIFEST}" ABSOLUTE)
  if(NOT EXISTS "${manifest}")
    message(FATAL_ERROR "cxlab_plugin(${target}): there is no manifest ${manifest}")
  endif()
  add_library(${target} MODULE ${arg_SOURCES})
  target_link_libraries(${target} PRIVATE cxlab::cxlab)
  # Unique symbols would keep the library in memory after it has been closed.
  target_compile_options(${target} PRIVATE -fno-gnu-unique -ffp-contract=off)
  target_link_options(${target} PRIVATE -Wl,-z,defs)
  set_target_properties(${target} PROPERTIES
    PREFIX lib SUFFIX .so CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/lib")
  install(TARGETS ${target} LIBRARY DESTINATION lib)
  configure_file("${manifest}" "${PROJECT_BINARY_DIR}/share/${arg_PACKAGE}/cxlab_plugins.yaml" COPYONLY)
  install(FILES "${manifest}" DESTINATION share/${arg_PACKAGE} RENAME cxlab_plugins.yaml)
endfunction()

function(cxlab_interfaces package)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "DIRECTORY" "")
  if(arg_UNPARSED_ARGUMENTS OR NOT arg_DIRECTORY)
    message(FATAL_ERROR "cxlab_interfaces(${package}): needs DIRECTORY; not understood: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  get_filename_component(folder "${arg_DIRECTORY}" ABSOLUTE)
  set(found "")
  foreach(kind msg srv action)
    if(IS_DIRECTORY "${folder}/${kind}")
      list(APPEND found "${folder}/${kind}")
    endif()
  endforeach()
  if(NOT found)
    message(FATAL_ERROR "cxlab_interfaces(${package}): ${folder} has no folder msg, srv or action")
  endif()
  cxlab_share(${package} ${found})
endfunction()

function(cxlab_share package)
  foreach(item IN LISTS ARGN)
    get_filename_component(path "${item}" ABSOLUTE)
    get_filename_component(name "${path}" NAME)
    if(NOT EXISTS "${path}")
      message(FATAL_ERROR "cxlab_share(${package}): there is no ${path}")
    endif()
    file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/share/${package}")
    file(CREATE_LINK "${path}" "${PROJECT_BINARY_DIR}/share/${package}/${name}" SYMBOLIC)
    if(IS_DIRECTORY "${path}")
      install(DIRECTORY "${path}" DESTINATION share/${package})
    else()
      install(FILES "${path}" DESTINATION share/${package})
    endif()
  endforeach()
endfunction()
