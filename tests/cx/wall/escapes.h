#pragma once
// Attempts of an attacker whose code runs inside the process, as after a fault of the program that lets rules write
// anywhere in memory. Each is a few system calls.

#include <sys/types.h>

#include <filesystem>
#include <span>

namespace cxlab::test {

/// What it aims at. All is there before.
struct Targets {
  std::filesystem::path outside;  ///< a folder that nobody named: secret.txt, victim.txt, empty/, server.sock
  std::filesystem::path package;  ///< a folder that may be read: known.txt
  std::filesystem::path run;      ///< the folder that may be written: own.txt
  pid_t other = 0;                ///< a process of the same user
  int port = 0;                   ///< of a server on this machine
};

struct Escape {
  const char* name;
  /// Whether it came through.
  bool (*succeeds)(const Targets&);
  /// Whether it does where there is no wall, also for a user without rights.
  bool open_without_wall = true;
};

std::span<const Escape> escapes();

}  // namespace cxlab::test
