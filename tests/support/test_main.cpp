#include <gmock/gmock.h>
#include <stdlib.h>

#include <iostream>
#include <sstream>
#include <string>
#include <string_view>

namespace {

constexpr std::string_view kFiles = "--files=";

/// A filter for the tests of one source file, named by the end of its path; empty if there are none.
std::string tests_of(const std::string& name) {
  const std::string file = '/' + name;
  std::string filter;
  const testing::UnitTest& all = *testing::UnitTest::GetInstance();
  for (int s = 0; s < all.total_test_suite_count(); ++s) {
    const testing::TestSuite& suite = *all.GetTestSuite(s);
    for (int t = 0; t < suite.total_test_count(); ++t) {
      const testing::TestInfo& test = *suite.GetTestInfo(t);
      if (std::string_view(test.file()).ends_with(file)) filter += std::string(suite.name()) + '.' + test.name() + ':';
    }
  }
  return filter;
}

}  // namespace

/// Runs the tests, with `--files=a.cpp,b.cpp` those of some source files; also by hand, outside of ctest, they find the
/// project's sources.
int main(int argc, char** argv) {
  setenv("CXLAB_SOURCE_DIR", CXLAB_SOURCE_DIR, 0);
  testing::InitGoogleMock(&argc, argv);
  for (int i = 1; i < argc; ++i) {
    if (!std::string_view(argv[i]).starts_with(kFiles)) continue;
    std::istringstream files(argv[i] + kFiles.size());
    std::string filter;
    for (std::string file; std::getline(files, file, ',');) filter += tests_of(file);
    if (filter.empty()) {
      std::cerr << argv[i] << ": there is no test in these files\n";
      return 2;
    }
    GTEST_FLAG_SET(filter, filter);
  }
  return RUN_ALL_TESTS();
}
