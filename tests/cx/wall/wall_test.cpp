#include "cx/wall/wall.h"

#include <arpa/inet.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>
#include <thread>

#include "cx/base/file.h"
#include "cx/base/process.h"
#include "cx/base/scratch_folder.h"
#include "cx/base/servant.h"
#include "escapes.h"

namespace cxlab::test {
namespace {

namespace fs = std::filesystem;

class Walls : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!wall_parts().whole()) GTEST_SKIP() << "this kernel has " << wall_parts().text();
    const fs::path root = scratch_->path();
    targets_ = {root / "outside", root / "package", root / "run", 0, 0};
    for (const fs::path& folder : {targets_.outside / "empty", targets_.package, targets_.run})
      fs::create_directories(folder);
    lay_out();
    server_ = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, (targets_.outside / "server.sock").c_str(), sizeof address.sun_path - 1);
    ASSERT_EQ(bind(server_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(listen(server_, 256), 0);
    internet_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof here;
    ASSERT_EQ(bind(internet_, reinterpret_cast<sockaddr*>(&here), size), 0);
    ASSERT_EQ(listen(internet_, 256), 0);
    getsockname(internet_, reinterpret_cast<sockaddr*>(&here), &size);
    targets_.port = ntohs(here.sin_port);
  }
  void TearDown() override {
    close(server_);
    close(internet_);
  }

  /// As they are before each try.
  void lay_out() {
    fs::create_directories(targets_.outside / "empty");
    for (const fs::path& file : {targets_.outside / "secret.txt", targets_.outside / "victim.txt",
                                 targets_.package / "known.txt", targets_.run / "own.txt"})
      std::ofstream(file) << "text\n";
    for (const char* made : {"link", "moved", "fifo", "program", "device"}) fs::remove(targets_.run / made);
    for (const char* made : {"link", "moved", "new.txt", "folder"}) fs::remove(targets_.outside / made);
  }

  Wall wall() const {
    Wall wall;
    wall.read = {targets_.package};
    wall.write = {targets_.run};
    return wall;
  }

  /// What `work` gives in a process of its own, behind the wall if there is one; -1 where it was killed.
  int in_child(const Wall* wall, const std::function<bool()>& work) {
    const pid_t child = fork();
    if (child == 0) {
      setpgid(0, 0);
      if (wall)
        if (const Status raised = raise_wall(*wall); !raised) {
          std::fprintf(stderr, "%s\n", raised.error().message.c_str());
          _exit(2);
        }
      _exit(work() ? 1 : 0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  std::unique_ptr<ScratchFolder> scratch_ = *ScratchFolder::create();
  Targets targets_;
  int server_ = -1, internet_ = -1;
};

TEST_F(Walls, NoEscapeComesThrough) {
  Process other = *Process::start({.argv = {"sleep", "600"}});
  targets_.other = other.pid();
  const Wall around = wall();
  for (const Escape& escape : escapes()) {
    lay_out();
    EXPECT_NE(in_child(&around, [&] { return escape.succeeds(targets_); }), 1) << escape.name;
  }
  EXPECT_EQ(*read_file(targets_.outside / "victim.txt"), "text\n");
  EXPECT_EQ(*read_file(targets_.package / "known.txt"), "text\n");
}

TEST_F(Walls, MostEscapesComeThroughWhereThereIsNoWall) {
  Process other = *Process::start({.argv = {"sleep", "600"}});
  targets_.other = other.pid();
  for (const Escape& escape : escapes()) {
    lay_out();
    if (!escape.open_without_wall) continue;
    EXPECT_EQ(in_child(nullptr, [&] { return escape.succeeds(targets_); }), 1) << escape.name;
  }
}

/// Whether this process can make a copy of itself.
bool can_copy_itself() {
  const pid_t copy = fork();
  if (copy == 0) _exit(0);
  int status = 0;
  return copy > 0 && waitpid(copy, &status, 0) == copy;
}

TEST_F(Walls, AProcessCopiesItselfOnlyWhereTheWallSaysSoAndItsCopiesDoNot) {
  Wall around = wall();
  EXPECT_EQ(in_child(&around, can_copy_itself), 0);
  around.copies = true;
  EXPECT_EQ(in_child(&around, can_copy_itself), 1);
  EXPECT_EQ(in_child(&around, [] { return forbid_copies().ok() && !can_copy_itself(); }), 1);
}

TEST_F(Walls, NoEscapeComesThroughInACopy) {
  Process other = *Process::start({.argv = {"sleep", "600"}});
  targets_.other = other.pid();
  Wall around = wall();
  around.copies = true;
  for (const Escape& escape : escapes()) {
    lay_out();
    const auto in_copy = [&] {
      const pid_t copy = fork();
      if (copy == 0) _exit(forbid_copies().ok() && escape.succeeds(targets_) ? 1 : 0);
      int status = 0;
      return copy < 0 || waitpid(copy, &status, 0) != copy || (WIFEXITED(status) && WEXITSTATUS(status) == 1);
    };
    EXPECT_EQ(in_child(&around, in_copy), 0) << escape.name;
  }
}

TEST_F(Walls, ThreadsThatWereThereBeforeAreConfinedToo) {
  const Wall around = wall();
  const auto escaped = [&] {
    std::atomic<bool> raised = false, read = false;
    std::thread before([&] {
      sigset_t all;  // as Mesa's threads do
      sigfillset(&all);
      sigdelset(&all, SIGSYS);
      pthread_sigmask(SIG_BLOCK, &all, nullptr);
      while (!raised) std::this_thread::yield();
      read = read_file(targets_.outside / "secret.txt").ok();
    });
    if (!raise_wall(around)) return true;
    raised = true;
    before.join();
    return read.load();
  };
  EXPECT_EQ(in_child(nullptr, escaped), 0);
}

TEST_F(Walls, ARunDoesWhatItNeedsTo) {
  const Wall around = wall();
  auto servant = Servant::start([](const std::string& request, const auto&) { return Servant::Answer{request + "!"}; });
  ASSERT_TRUE(servant);
  const auto works = [&] {
    bool fine = read_file(targets_.package / "known.txt").ok() && write_file(targets_.run / "new.txt", "new").ok();
    fs::rename(targets_.run / "new.txt", targets_.run / "newer.txt");
    fs::create_directory(targets_.run / "folder");
    fs::rename(targets_.run / "newer.txt", targets_.run / "folder" / "newest.txt");
    fine = fine && fs::remove_all(targets_.run / "folder") == 2;
    bool threaded = false;
    std::thread([&] { threaded = read_file("/proc/self/maps").ok(); }).join();
    fine = fine && threaded && dlopen("libz.so.1", RTLD_NOW) != nullptr;
    const auto answer = servant->ask("well");
    return fine && answer && answer->text == "well!" && write_file("/dev/null", "gone").ok() && raise(SIGWINCH) == 0;
  };
  EXPECT_EQ(in_child(&around, works), 1);
}

TEST_F(Walls, LinksAreMadeWhereTheyAreAllowed) {
  fs::create_directory(targets_.run / "logs");
  Wall around = wall();
  around.links = {targets_.run / "logs"};
  EXPECT_EQ(in_child(&around, [&] { return symlink("a.log", (targets_.run / "logs" / "b.log").c_str()) == 0; }), 1);
  EXPECT_EQ(in_child(&around, [&] { return symlink("a.log", (targets_.run / "c.log").c_str()) == 0; }), 0);
}

TEST_F(Walls, NamesOfAFolderAreListedWithoutItsFiles) {
  Wall around = wall();
  around.list = {targets_.outside};
  EXPECT_EQ(in_child(&around, [&] { return !fs::is_empty(targets_.outside); }), 1);
  EXPECT_EQ(in_child(&around, [&] { return read_file(targets_.outside / "secret.txt").ok(); }), 0);
}

TEST_F(Walls, WhatIsNotThereIsLeftOut) {
  Wall around = wall();
  around.read.push_back(targets_.outside / "nowhere");
  EXPECT_EQ(in_child(&around, [] { return true; }), 1);
}

TEST(WallParts, NameWhatTheKernelHas) {
  EXPECT_EQ((WallParts{7, true}.text()), "Landlock 7 and seccomp");
  EXPECT_EQ((WallParts{0, true}.text()), "seccomp, no Landlock");
  EXPECT_EQ((WallParts{2, false}.text()), "Landlock 2, no seccomp");
  EXPECT_EQ((WallParts{0, false}.text()), "neither Landlock nor seccomp");
  EXPECT_FALSE((WallParts{0, true}.whole()));
  EXPECT_FALSE((WallParts{1, false}.whole()));
  EXPECT_TRUE((WallParts{1, true}.whole()));
}

}  // namespace
}  // namespace cxlab::test
