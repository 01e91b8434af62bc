# Where the sources of CLIPS come from.

set(CLIPS_MENDS "${CMAKE_CURRENT_LIST_DIR}/mends.patch")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${CLIPS_MENDS}")

# One digest over the names and contents of all files of a folder.
function(clips_digest folder out)
  file(GLOB_RECURSE files RELATIVE "${folder}" "${folder}/*")
  list(SORT files)
  set(names_and_hashes "")
  foreach(file IN LISTS files)
    file(SHA256 "${folder}/${file}" hash)
    string(APPEND names_and_hashes "${hash} ${file}\n")
  endforeach()
  string(SHA256 digest "${names_and_hashes}")
  set(${out} "${digest}" PARENT_SCOPE)
endfunction()

# Mends what CLIPS 6.40 does wrong: mends.patch says what.
function(mend_clips folder)
  find_program(GIT git REQUIRED)
  # Not as part of the repository around the build folder, where git would look for the files elsewhere.
  get_filename_component(parent "${folder}" DIRECTORY)
  execute_process(
    COMMAND "${CMAKE_COMMAND}" -E env --unset=GIT_DIR --unset=GIT_WORK_TREE "GIT_CEILING_DIRECTORIES=${parent}"
            "${GIT}" apply --whitespace=nowarn "${CLIPS_MENDS}"
    WORKING_DIRECTORY "${folder}" RESULT_VARIABLE result ERROR_VARIABLE error)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "CLIPS: ${folder} cannot be mended.\n${error}")
  endif()
endfunction()

# Sets out to a folder with core/, test_suite/ and examples/ of the crate that Cargo.lock pins, downloaded
# by cargo if the cache has no intact copy.
function(fetch_clips out)
  set(name clips-sys-0.4.0)
  set(digest 880547a6c9bfc9edadafd373e0d649da47297ad958b559c9e2e54e55f592627e)
  set(cached "${CXLAB_DOWNLOADS}/${name}")
  file(SHA256 "${CLIPS_MENDS}" mends)
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/source")
  set(${out} "${folder}" PARENT_SCOPE)

  if(EXISTS "${folder}/digest")
    file(READ "${folder}/digest" found)
    if(found STREQUAL "${digest} ${mends}")
      return()
    endif()
  endif()

  file(LOCK "${CXLAB_DOWNLOADS}/clips.lock" GUARD FUNCTION TIMEOUT 600)
  clips_digest("${cached}" found)
  if(NOT found STREQUAL digest)
    message(STATUS "CLIPS: downloading ${name} (2 MB)")
    find_program(CARGO cargo REQUIRED)
    set(crates "${CMAKE_CURRENT_BINARY_DIR}/crates")
    execute_process(
      COMMAND "${CARGO}" vendor --quiet --locked --versioned-dirs
              --manifest-path "${CMAKE_CURRENT_SOURCE_DIR}/Cargo.toml" "${crates}"
      RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE error)
    if(NOT result EQUAL 0)
      message(FATAL_ERROR "CLIPS: cargo could not fetch it (Debian: cargo-web, or rustup's cargo).\n${error}\n"
                          "Or give -DCXLAB_CLIPS_SOURCE=DIR with the sources of CLIPS 6.4.")
    endif()
    file(REMOVE_RECURSE "${cached}")
    foreach(part core test_suite examples)
      file(COPY "${crates}/${name}/CLIPS/${part}" DESTINATION "${cached}")
    endforeach()
    clips_digest("${cached}" found)
    if(NOT found STREQUAL digest)
      message(FATAL_ERROR "CLIPS: ${cached} has the digest ${found}, expected ${digest}")
    endif()
  endif()

  file(REMOVE_RECURSE "${folder}")
  file(COPY "${cached}/" DESTINATION "${folder}")
  mend_clips("${folder}")
  file(WRITE "${folder}/digest" "${digest} ${mends}")
endfunction()
