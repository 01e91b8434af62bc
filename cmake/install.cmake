# cmake --install build/release --prefix P, and cpack --config build/release/CPackConfig.cmake for a tarball:
#
#   bin/cxlab           the program; finds all else from its own place, so the prefix may move
#   lib/cxlab/          libcxlab.so and the libraries it needs that a bare Debian does not have
#   lib/cmake/cxlab/    find_package(cxlab): cmake/package
#   include/cxlab/      headers for plugins and for programs that play episodes
#   share/cxlab/        interfaces, models, scenarios, docs with examples and templates
#   share/              man page, completion for bash and zsh

include_guard(GLOBAL)

set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # installs what is built; tests need not be
set(libraries lib/cxlab)
file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/${libraries}")
set(headers include/cxlab)
set(share share/cxlab)
set(doc share/doc/cxlab)

# --- Program and libraries
# The build folder has the layout of the prefix and the same RPATH. The RPATH that CMake gives a build would end with an empty element,
# which means the current directory.
set_target_properties(cxlab cxlab_first PROPERTIES BUILD_WITH_INSTALL_RPATH ON INSTALL_RPATH "$ORIGIN/../${libraries};$ORIGIN/${libraries}")
set_target_properties(cxlab_shared PROPERTIES BUILD_WITH_INSTALL_RPATH ON INSTALL_RPATH "$ORIGIN"
  LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/${libraries}")
# DT_RPATH, not DT_RUNPATH: the libraries of Debian beside libcxlab.so need each other, and the latter holds for one step only.
foreach(target cxlab cxlab_first cxlab_shared)
  target_link_options(${target} PRIVATE -Wl,--disable-new-dtags)
endforeach()
get_target_property(mujoco mujoco::mujoco IMPORTED_LOCATION)
get_filename_component(name "${mujoco}" NAME)
file(CREATE_LINK "${mujoco}" "${PROJECT_BINARY_DIR}/${libraries}/${name}" SYMBOLIC)
install(TARGETS cxlab cxlab_shared RUNTIME_DEPENDENCY_SET needed
  RUNTIME DESTINATION bin LIBRARY DESTINATION ${libraries})
# Those of the compiler are everywhere that a plugin can be built; zlib is part of every Debian.
install(RUNTIME_DEPENDENCY_SET needed
  PRE_EXCLUDE_REGEXES "^ld-linux" "^lib(c|m|dl|rt|pthread|stdc\\+\\+|gcc_s|z|[a-z]+san)\\.so"
  LIBRARY DESTINATION ${libraries})

# --- Headers: all but those of the plugins that come with cxlab, and those that need headers of MuJoCo or nlohmann-json
include(installed_headers)
file(GLOB folders RELATIVE "${PROJECT_SOURCE_DIR}" cx/* sim sim/* scenarios scenarios/* scenarios/rcll/* lab lab/*)
list(FILTER folders EXCLUDE REGEX "^(cx/plugins|sim/mujoco|scenarios/rcll/refbox)$")
foreach(folder IN LISTS folders)
  file(GLOB files CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/${folder}/*.h")
  list(FILTER files EXCLUDE REGEX "/(cx/base/json|cx/explain/json|lab/(answers|base64|child|control/debugger|coverage|coverage_of_runs|json_fields|profile|report|export/[a-z_]*|run_page|scene_answer|table_text|trace_writer|why_not|world_answer)|scenarios/rcll/floor_view|lab/(physics_replay|pictures|shown_run|view/[a-z_]*))\\.h$")
  cxlab_install_headers(${folder} ${files})
endforeach()
cxlab_install_headers(app "${PROJECT_SOURCE_DIR}/app/program.h")
cxlab_install_headers(cx/executive "${PROJECT_BINARY_DIR}/include/cx_abi/cx/executive/abi.h")
get_target_property(clips_core clips_c INTERFACE_INCLUDE_DIRECTORIES)
get_target_property(clips_kind clips_c TYPE)
if(clips_kind STREQUAL "SHARED_LIBRARY")  # else the system's
  set_target_properties(clips_c PROPERTIES LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/${libraries}")
  install(TARGETS clips_c LIBRARY DESTINATION ${libraries})
  file(GLOB files "${clips_core}/*.h")
  install(FILES ${files} DESTINATION ${headers}/clips)
  set(clips_core "../clips")
endif()
set(installed "${PROJECT_BINARY_DIR}/installed")
configure_file(third_party/clips/clips_ns.h.in "${installed}/clips_ns/clips.h" @ONLY)
install(FILES "${installed}/clips_ns/clips.h" DESTINATION ${headers}/clips_ns)
cxlab_check_installed_headers()

# --- find_package(cxlab)
include(CMakePackageConfigHelpers)
configure_file(cmake/package/cxlabConfig.cmake.in "${installed}/cxlabConfig.cmake" @ONLY)
write_basic_package_version_file("${installed}/cxlabConfigVersion.cmake" COMPATIBILITY ExactVersion)
install(FILES "${installed}/cxlabConfig.cmake" "${installed}/cxlabConfigVersion.cmake" cmake/package/cxlabPackage.cmake
  DESTINATION lib/cmake/cxlab)

# --- Man page and completion, made by the program
install(CODE "
  function(cxlab_write file)
    set(path \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/share/\${file}\")
    get_filename_component(folder \"\${path}\" DIRECTORY)
    file(MAKE_DIRECTORY \"\${folder}\")
    execute_process(COMMAND \"$<TARGET_FILE:cxlab>\" \${ARGN} OUTPUT_FILE \"\${path}\" COMMAND_ERROR_IS_FATAL ANY)
  endfunction()
  cxlab_write(man/man1/cxlab.1 man)
  cxlab_write(bash-completion/completions/cxlab completion bash)
  cxlab_write(zsh/site-functions/_cxlab completion zsh)")

# --- Data
install(DIRECTORY cx/interfaces cx/packages models docs planner/engines lab/pages DESTINATION ${share} PATTERN __pycache__ EXCLUDE)
install(DIRECTORY scenarios DESTINATION ${share}
  FILES_MATCHING PATTERN "*.yaml" PATTERN "*.clp" PATTERN "*.pddl" PATTERN "*.jinja" PATTERN "package.xml")
install(FILES README.md LICENSE DESTINATION ${doc})
install(FILES docs/how-to/install.md DESTINATION ${doc} RENAME INSTALL.md)
get_filename_component(wheel "${mujoco}" DIRECTORY)
file(GLOB files "${wheel}/../*.dist-info/licenses/*")
install(FILES ${files} DESTINATION ${doc}/mujoco)
get_target_property(licences minijinja::minijinja CXLAB_LICENCES)
install(DIRECTORY "${licences}/" DESTINATION ${doc}/minijinja)
get_target_property(licence three CXLAB_LICENCE)
install(FILES "${licence}" DESTINATION ${doc}/three)
# The licences of the Debian libraries that were copied.
install(CODE "set(folder \"\${CMAKE_INSTALL_PREFIX}/${libraries}\")\nset(licences \"\${CMAKE_INSTALL_PREFIX}/${doc}\")")
install(SCRIPT cmake/package/licences.cmake)

# --- Tarball
set(CPACK_GENERATOR TGZ)
set(CPACK_PACKAGE_FILE_NAME "cxlab-${PROJECT_VERSION}-debian12-${CMAKE_SYSTEM_PROCESSOR}")
include(CPack)
