# The readers of tests/readers: cmake -D downloads=DIR -D folder=DIR [-D torch=yes] -P fetch.cmake
#   <folder>/venv   a virtual environment with what requirements.txt pins
#   <folder>/torch  with torch=yes, instead of the others: a virtual environment with what torch.txt pins
#   <folder>/lcov   lcov 2, because Debian 12 has version 1: its programs are in usr/bin, its modules in usr/lib/lcov

set(lcov_version 2.3.1-1)
set(lcov_hash b89bfb28e8a6dee12b25ca63d269733909eaebb6b737958d4fb8b47b23ea4926)
set(lcov_package "pool/main/l/lcov/lcov_${lcov_version}_all.deb")
set(debian "http://deb.debian.org/debian" "http://snapshot.debian.org/archive/debian/20250901T000000Z")

# Calls a program that must end well; `remedy` is what to do otherwise.
function(call remedy)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}: ${result}\n${said}\n${remedy}")
  endif()
endfunction()

# Sets out to whether `folder` was made from this stamp; else empties it.
function(is_made folder stamp out)
  set(found "")
  if(EXISTS "${folder}/made_from")
    file(READ "${folder}/made_from" found)
  endif()
  if(found STREQUAL stamp)
    set(${out} TRUE PARENT_SCOPE)
  else()
    set(${out} FALSE PARENT_SCOPE)
    file(REMOVE_RECURSE "${folder}")
    file(MAKE_DIRECTORY "${folder}")
  endif()
endfunction()

function(fetch_lcov)
  is_made("${folder}/lcov" "${lcov_hash}" made)
  if(made)
    return()
  endif()
  file(MAKE_DIRECTORY "${downloads}")
  set(package "${downloads}/lcov_${lcov_version}_all.deb")
  set(found "")
  if(EXISTS "${package}")
    file(SHA256 "${package}" found)
  endif()
  foreach(archive IN LISTS debian)
    if(NOT found STREQUAL lcov_hash)
      message(STATUS "lcov: downloading ${archive}/${lcov_package} (0.4 MB)")
      execute_process(
        COMMAND /usr/lib/apt/apt-helper download-file "${archive}/${lcov_package}" "${package}" "SHA256:${lcov_hash}"
        RESULT_VARIABLE result OUTPUT_VARIABLE said ERROR_VARIABLE said)
      if(result EQUAL 0)
        set(found "${lcov_hash}")
      else()
        string(APPEND failures "${said}")
      endif()
    endif()
  endforeach()
  if(NOT found STREQUAL lcov_hash)
    message(FATAL_ERROR "lcov: it could not be downloaded.\n${failures}\nWithout a network: put the package at ${package}.")
  endif()
  call("Is ${package} whole?" dpkg-deb --extract "${package}" "${folder}/lcov")
  file(WRITE "${folder}/lcov/made_from" "${lcov_hash}")
endfunction()

# Makes the virtual environment <folder>/<name> with the packages that `list` pins.
function(fetch_python_packages name list size)
  find_program(PYTHON3 python3 REQUIRED)
  # The one behind an active environment, which could be the one that is made.
  execute_process(COMMAND "${PYTHON3}" -c "import os, sys; print(os.path.realpath(sys._base_executable))"
                  OUTPUT_VARIABLE PYTHON3 OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  file(SHA256 "${CMAKE_CURRENT_LIST_DIR}/${list}" requirements)
  execute_process(COMMAND "${PYTHON3}" --version OUTPUT_VARIABLE version OUTPUT_STRIP_TRAILING_WHITESPACE)
  set(stamp "${PYTHON3} ${version} ${requirements}")
  is_made("${folder}/${name}" "${stamp}" made)
  if(made)
    return()
  endif()
  message(STATUS "downloading what tests/readers/${list} lists (${size})")
  call("Debian: apt-get install python3-venv" "${PYTHON3}" -m venv "${folder}/${name}")
  call("These packages are on PyPI; pip needs a network." "${folder}/${name}/bin/python" -m pip install --quiet --disable-pip-version-check
       --only-binary=:all: -r "${CMAKE_CURRENT_LIST_DIR}/${list}")
  file(WRITE "${folder}/${name}/made_from" "${stamp}")
endfunction()

if(torch)
  fetch_python_packages(torch torch.txt "3.2 GB, 6.1 GB on the disk")
else()
  fetch_lcov()
  fetch_python_packages(venv requirements.txt "150 MB")
endif()
