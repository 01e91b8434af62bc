# clang-format from its wheel, for ./dev format: cmake -D downloads=DIR -D folder=DIR -P fetch.cmake
# leaves the program in <folder>/clang_format/data/bin.

include("${CMAKE_CURRENT_LIST_DIR}/../../cmake/wheel.cmake")
file(MAKE_DIRECTORY "${downloads}")
fetch_wheel("${CMAKE_CURRENT_LIST_DIR}/requirements.txt" "${downloads}" "2 MB" wheel)
unpack_wheel("${wheel}" "${folder}" "clang_format/data/bin/clang-format")
