# Libraries of the system (Debian packages in ./dev). Those that are fetched are in third_party/.

find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(spdlog REQUIRED)
find_package(PNG REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(Protobuf REQUIRED)
find_package(Boost 1.74 REQUIRED)
find_package(box2d REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
pkg_check_modules(edit REQUIRED IMPORTED_TARGET libedit)
find_path(asio_include asio.hpp REQUIRED)
pkg_check_modules(xxhash REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(seccomp REQUIRED IMPORTED_TARGET libseccomp)
pkg_check_modules(sqlite REQUIRED IMPORTED_TARGET sqlite3)

if(NOT TARGET yaml-cpp::yaml-cpp)
  add_library(yaml-cpp::yaml-cpp ALIAS yaml-cpp)
endif()
add_library(xxhash::xxhash ALIAS PkgConfig::xxhash)

# Pictures without a display. Optional: whoever draws asks `if(TARGET osmesa::osmesa)`.
pkg_check_modules(osmesa IMPORTED_TARGET osmesa)
if(TARGET PkgConfig::osmesa)
  add_library(osmesa::osmesa ALIAS PkgConfig::osmesa)
endif()

# Where programs get their memory: what rules match lies closer together than with libc's. A sanitizer has its own.
add_library(memory::memory INTERFACE IMPORTED)
if(NOT CXLAB_SANITIZE)
  pkg_check_modules(jemalloc REQUIRED IMPORTED_TARGET jemalloc)
  target_link_libraries(memory::memory INTERFACE PkgConfig::jemalloc)
endif()
