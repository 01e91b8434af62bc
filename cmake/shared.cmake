# The one shared library: all parts of cxlab in libcxlab.so. The program, plugins and outside programs use it, so a process has only one
# copy of the executive. Tests of single parts link these statically.
#
#   cxlab_shared_library(<target> FROM <part>...)   the parts and all that their DEPS name

include_guard(GLOBAL)

# All that the targets name in their DEPS, directly or through others.
function(_cxlab_closure out)
  get_property(pairs GLOBAL PROPERTY CXLAB_DEPENDENCIES)
  set(open ${ARGN})
  set(closure "")
  while(open)
    list(POP_FRONT open target)
    foreach(pair IN LISTS pairs)
      if(pair MATCHES "^([^>]+)>(.+)$" AND CMAKE_MATCH_1 STREQUAL target AND NOT CMAKE_MATCH_2 IN_LIST closure)
        list(APPEND closure ${CMAKE_MATCH_2})
        list(APPEND open ${CMAKE_MATCH_2})
      endif()
    endforeach()
  endwhile()
  set(${out} ${closure} PARENT_SCOPE)
endfunction()

function(cxlab_shared_library target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "FROM")
  _cxlab_closure(parts ${arg_FROM})
  list(APPEND parts ${arg_FROM})
  add_library(${target} SHARED)
  foreach(part IN LISTS parts)
    get_target_property(type ${part} TYPE)
    get_target_property(imported ${part} IMPORTED)
    get_target_property(alias ${part} ALIASED_TARGET)
    if(type STREQUAL "STATIC_LIBRARY" AND NOT imported AND NOT alias)
      target_sources(${target} PRIVATE $<TARGET_OBJECTS:${part}>)
    elseif(imported OR alias)
      target_link_libraries(${target} PUBLIC ${part})
    endif()
    if(NOT imported AND NOT alias)
      target_include_directories(${target} INTERFACE $<TARGET_PROPERTY:${part},INTERFACE_INCLUDE_DIRECTORIES>)
    endif()
  endforeach()
  target_link_libraries(${target} PRIVATE ${CMAKE_DL_LIBS})
  # Calls inside the library are bound when it is linked.
  target_link_options(${target} PRIVATE -Wl,-Bsymbolic-functions -Wl,-z,defs)
endfunction()
