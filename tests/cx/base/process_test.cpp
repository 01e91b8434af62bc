#include "cx/base/process.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <thread>
#include <utility>

#include "cx/base/scratch_folder.h"
#include "cx/base/servant.h"

namespace cxlab {
namespace {

namespace fs = std::filesystem;

class ProcessTest : public testing::Test {
 protected:
  Process started(ProcessOptions options) {
    auto process = Process::start(options);
    EXPECT_TRUE(process) << (process ? "" : process.error().text());
    return *std::move(process);
  }
  ProcessOptions shell(const std::string& script) { return {.argv = {"sh", "-c", script}}; }
  std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path path(const std::string& name) const { return scratch_->path() / name; }

  std::unique_ptr<ScratchFolder> scratch_ = *ScratchFolder::create();
};

/// Whether a process exists that is no zombie.
bool runs(pid_t pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
  std::string word;
  char state = 'X';
  in >> word >> word >> state;
  return in && state != 'Z' && state != 'X';
}

bool ends_soon(pid_t pid) {
  for (int i = 0; i < 500 && runs(pid); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return !runs(pid);
}

TEST_F(ProcessTest, ReportsTheExitCodeAndTheSignal) {
  EXPECT_EQ(started(shell("exit 7")).wait(), 7);
  EXPECT_EQ(started(shell("kill -9 $$")).wait(), 128 + 9);
}

TEST_F(ProcessTest, AnswersTheSameCodeWhenAskedAgain) {
  Process process = started(shell("exit 3"));
  EXPECT_EQ(process.wait(), 3);
  EXPECT_EQ(process.wait(), 3);
  EXPECT_EQ(process.wait_for(0), 3);
}

TEST_F(ProcessTest, IsAnErrorIfTheProgramIsMissing) {
  auto process = Process::start({.argv = {"no-such-program-here"}});
  ASSERT_FALSE(process);
  EXPECT_EQ(process.error().kind, ErrorKind::kResource);
  EXPECT_EQ(process.error().text(), "cannot start no-such-program-here: No such file or directory");
}

TEST_F(ProcessTest, IsAnErrorIfAFileOrFolderIsMissing) {
  ProcessOptions options{.argv = {"true"}};
  options.folder = path("missing");
  EXPECT_FALSE(Process::start(options));
  options.folder.clear();
  options.in = Stream::file(path("missing"));
  EXPECT_FALSE(Process::start(options));
  EXPECT_FALSE(Process::fork(options, [] { return 0; }));
}

TEST_F(ProcessTest, PassesArgumentsAsTheyAre) {
  ProcessOptions options{.argv = {"printf", "%s|", "a b", "$HOME", "'\"", ""}};
  options.out = Stream::file(path("out"));
  Process process = started(options);
  EXPECT_EQ(process.wait(), 0);
  EXPECT_EQ(text_of(path("out")), "a b|$HOME|'\"||");
}

TEST_F(ProcessTest, ChangesVariablesAndFolder) {
  setenv("CXLAB_KEPT", "kept", 1);
  setenv("CXLAB_CHANGED", "old", 1);
  ProcessOptions options = shell("echo $CXLAB_KEPT $CXLAB_CHANGED $CXLAB_NEW; pwd");
  options.environment = {{"CXLAB_CHANGED", "changed"}, {"CXLAB_NEW", "new"}};
  options.folder = scratch_->path();
  options.out = Stream::file(path("out"));
  started(options).wait();
  EXPECT_EQ(text_of(path("out")), "kept changed new\n" + fs::canonical(scratch_->path()).string() + "\n");
}

TEST_F(ProcessTest, GivesWhatIsWrittenToTheProgram) {
  ProcessOptions options{.argv = {"tr", "a-z", "A-Z"}};
  options.in = Stream::pipe();
  options.out = Stream::file(path("out"));
  Process process = started(options);
  ASSERT_TRUE(process.write("over and "));
  ASSERT_TRUE(process.write("out"));
  process.close_input();
  process.wait();
  EXPECT_EQ(text_of(path("out")), "OVER AND OUT");
}

TEST_F(ProcessTest, InputForAProgramThatHasEndedIsAnError) {
  ProcessOptions options{.argv = {"true"}};
  options.in = Stream::pipe();
  Process process = started(options);
  process.wait();
  EXPECT_FALSE(process.write("anybody?"));
}

TEST_F(ProcessTest, WritesBothStreamsIntoOneFileInOrder) {
  std::ofstream(path("log")) << "of an earlier process\n";
  ProcessOptions options = shell("echo first; echo second >&2; echo third");
  options.out = options.err = Stream::file(path("log"));
  started(options).wait();
  EXPECT_EQ(text_of(path("log")), "first\nsecond\nthird\n");
}

TEST_F(ProcessTest, ReadsAFile) {
  std::ofstream(path("in")) << "line\n";
  ProcessOptions options{.argv = {"cat"}};
  options.in = Stream::file(path("in"));
  options.out = Stream::file(path("out"));
  started(options).wait();
  EXPECT_EQ(text_of(path("out")), "line\n");
}

TEST_F(ProcessTest, WaitsNoLongerThanAsked) {
  Process process = started(shell("sleep 60"));
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(process.wait_for(0.05), std::nullopt);
  process.kill();
  EXPECT_EQ(process.wait(), 128 + 9);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST_F(ProcessTest, EndsWithTheObject) {
  pid_t pid = 0;
  {
    const Process process = started(shell("sleep 60"));
    pid = process.pid();
    EXPECT_TRUE(runs(pid));
  }
  EXPECT_FALSE(runs(pid));
}

TEST_F(ProcessTest, EndsWhatTheProgramLeftRunning) {
  ProcessOptions options = shell("sleep 60 >/dev/null & echo $!");
  options.out = Stream::file(path("out"));
  Process process = started(options);
  EXPECT_EQ(process.wait(), 0);
  const pid_t left = static_cast<pid_t>(std::stol(text_of(path("out"))));
  EXPECT_TRUE(ends_soon(left));
}

TEST_F(ProcessTest, EndsWithTheProcessThatStartedIt) {
  ProcessOptions options;
  options.out = Stream::file(path("out"));
  auto parent = Process::fork(options, [&] {
    const Process child = started(shell("exec sleep 60"));
    const std::string text = std::to_string(child.pid()) + "\n";
    if (write(STDOUT_FILENO, text.data(), text.size()) < 0) return 1;
    ::kill(getpid(), SIGKILL);  // no destructor runs
    return 0;
  });
  ASSERT_TRUE(parent);
  EXPECT_EQ(parent->wait(), 128 + 9);
  const pid_t child = static_cast<pid_t>(std::stol(text_of(path("out"))));
  EXPECT_TRUE(ends_soon(child));
}

TEST_F(ProcessTest, ForkRunsAFunctionOnACopy) {
  int here = 1;
  ProcessOptions options;
  options.out = Stream::file(path("out"));
  auto process = Process::fork(options, [&] {
    here = 2;
    std::printf("from the copy");
    return 5;
  });
  ASSERT_TRUE(process);
  EXPECT_EQ(process->wait(), 5);
  EXPECT_EQ(here, 1);
  EXPECT_EQ(text_of(path("out")), "from the copy");
}

TEST_F(ProcessTest, ForkLeavesBehindWhatThisProcessHasOpenButForOneDescriptor) {
  const Descriptor before(open("/dev/null", O_RDONLY)), kept(open("/dev/null", O_RDONLY)),
      after(open("/dev/null", O_RDONLY));
  const auto open_in_copy = [&] {
    int sum = 0;
    for (const auto& [descriptor, value] : {std::pair(&before, 1), {&kept, 2}, {&after, 4}})
      if (fcntl(descriptor->number(), F_GETFD) >= 0) sum += value;
    return sum;
  };
  EXPECT_EQ(open_in_copy(), 7);
  for (const auto& [number, expected] : {std::pair(kept.number(), 2), {-1, 0}, {STDIN_FILENO, 0}}) {
    auto process = Process::fork({}, open_in_copy, number);
    ASSERT_TRUE(process);
    EXPECT_EQ(process->wait(), expected);
  }
}

TEST_F(ProcessTest, ForkReadsItsInputToTheEnd) {
  ProcessOptions options;
  options.in = Stream::pipe();
  auto process = Process::fork(options, [] {
    char buffer[16];
    int bytes = 0;
    for (ssize_t n = 0; (n = read(STDIN_FILENO, buffer, sizeof buffer)) > 0;) bytes += static_cast<int>(n);
    return bytes;
  });
  ASSERT_TRUE(process);
  ASSERT_TRUE(process->write("12345"));
  process->close_input();
  EXPECT_EQ(process->wait(), 5);
}

TEST_F(ProcessTest, CanBeMoved) {
  Process first = started(shell("exit 4")), second = started(shell("sleep 60"));
  const pid_t ended = second.pid();
  second = std::move(first);
  EXPECT_EQ(second.wait(), 4);
  {
    Process last = std::move(first);
  }
  EXPECT_FALSE(runs(ended));
}

TEST(IsOnPath, FindsProgramsOnly) {
  EXPECT_TRUE(is_on_path("sh"));
  EXPECT_FALSE(is_on_path("no-such-program-here"));
}

}  // namespace
}  // namespace cxlab
