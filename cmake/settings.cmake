# Settings for the compilation of all our code, and of CLIPS unless it sets others.

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Release, Debug" FORCE)
endif()

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 11)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# Assertions stay on in release, so a bug of cxlab ends the program.
set(CMAKE_C_FLAGS_RELEASE "-O3")
set(CMAKE_CXX_FLAGS_RELEASE "-O2")
set(CMAKE_C_FLAGS_DEBUG "-Og -g")
set(CMAKE_CXX_FLAGS_DEBUG "-Og -g")

# The same sums on every machine: no fused multiply-add that the source does not name.
add_compile_options(-ffp-contract=off)

set(CXLAB_SANITIZE "" CACHE STRING "Sanitizers, for example address,undefined or thread")
if(CXLAB_SANITIZE)
  add_compile_options(-fsanitize=${CXLAB_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${CXLAB_SANITIZE})
endif()

# ccache, if it is there; the base directory lets a second clone profit from the first.
find_program(CXLAB_CCACHE ccache)
if(CXLAB_CCACHE)
  foreach(language C CXX)
    if(NOT CMAKE_${language}_COMPILER_LAUNCHER)
      set(CMAKE_${language}_COMPILER_LAUNCHER
          env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1
          CCACHE_SLOPPINESS=pch_defines,time_macros ${CXLAB_CCACHE})
    endif()
  endforeach()
endif()
