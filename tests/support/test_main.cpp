#include <gmock/gmock.h>
#include <stdlib.h>

/// Runs the tests; also by hand, outside of ctest, they find the project's sources.
int main(int argc, char** argv) {
  setenv("CXLAB_SOURCE_DIR", CXLAB_SOURCE_DIR, 0);
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
