# Run by the installation: for each library in `folder` that came from a Debian package, the package's copyright file
# goes to `licences`/PACKAGE.
file(GLOB libraries "$ENV{DESTDIR}${folder}/lib*.so.*")
foreach(library IN LISTS libraries)
  if(IS_SYMLINK "${library}")
    continue()
  endif()
  get_filename_component(name "${library}" NAME)
  execute_process(COMMAND dpkg-query --search "*/${name}" OUTPUT_VARIABLE owners ERROR_QUIET)
  if(owners MATCHES "^([^:, \n]+)")
    set(package "${CMAKE_MATCH_1}")
    file(INSTALL "/usr/share/doc/${package}/copyright" DESTINATION "${licences}/${package}")
  endif()
endforeach()
