// A replay finds a message that was changed in a log that is whole otherwise.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "cx/journal/input_log.h"

namespace cxlab {
namespace {

namespace fs = std::filesystem;

class TamperedLog : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "cxlab-tampered-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Exit code of `cxlab ARGUMENTS`; what it said is in `said_`.
  int cxlab(const std::string& arguments) {
    const std::string command =
        std::string(std::getenv("CXLAB")) + ' ' + arguments + " >" + (folder_ / "said").string() + " 2>&1";
    const int status = std::system(command.c_str());
    std::ifstream in(folder_ / "said");
    said_.assign(std::istreambuf_iterator<char>(in), {});
    return WEXITSTATUS(status);
  }

  /// Writes the log again, with the text of the first message that holds `from` changed to `to`.
  void change_message(const std::string& from, const std::string& to) {
    const fs::path path = folder_ / "run/inputs.bin";
    auto reader = InputLogReader::open(path);
    ASSERT_TRUE(reader);
    auto writer = InputLogWriter::create(folder_ / "changed.bin");
    ASSERT_TRUE(writer);
    std::string message;
    while (auto entry = reader->next()) {
      if (auto* take = std::get_if<LoggedTake>(&*entry)) {
        for (LoggedDelivery& delivery : take->deliveries) {
          const std::size_t at = delivery.message.find(from);
          if (at == std::string_view::npos || !message.empty()) continue;
          message = std::string(delivery.message).replace(at, from.size(), to);
          delivery.message = message;
        }
        writer->add(*take);
      } else if (const auto* result = std::get_if<LoggedResult>(&*entry)) {
        writer->add(*result);
      } else {
        writer->add(std::get<LoggedWorld>(*entry));
      }
    }
    ASSERT_TRUE(writer->close(reader->reached()));
    ASSERT_FALSE(message.empty()) << "no message holds " << from;
    fs::rename(folder_ / "changed.bin", path);
  }

  fs::path folder_;
  std::string said_;
};

TEST_F(TamperedLog, IsADifferenceWithItsPlace) {
  const std::string game = std::string(std::getenv("CXLAB_SOURCE_DIR")) + "/scenarios/rcll/game.yaml";
  ASSERT_EQ(cxlab("run " + game + " --tier timed --until 60 --quiet --out " + (folder_ / "run").string()), 0) << said_;
  ASSERT_EQ(cxlab("replay " + (folder_ / "run").string()), 0) << said_;
  change_message("robot1", "robotX");
  EXPECT_EQ(cxlab("replay " + (folder_ / "run").string()), 1) << said_;
  EXPECT_NE(said_.find("first difference: "), std::string::npos) << said_;
  EXPECT_NE(said_.find("robotX"), std::string::npos) << said_;
}

}  // namespace
}  // namespace cxlab
