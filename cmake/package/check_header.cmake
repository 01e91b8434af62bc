# Fails if the compiler's list `dependencies` of a header names one of a Debian library that cxlab only needs itself.
file(READ "${dependencies}" files)
if(files MATCHES "(/usr/include/(yaml-cpp|nlohmann|spdlog|fmt|box2d|CLI|gtest|xxhash|asio|editline)[^ ]*)")
  message(FATAL_ERROR "${header}: an installed header includes ${CMAKE_MATCH_1}, which users of cxlab need not have")
endif()
