#pragma once
// The second wall around the rules of a stranger. The first one are the checks of `cx::Files` and of the functions that
// rules call; this one holds even if a fault in the program lets rules run code of their own. The process gives up, for
// good and in all its threads, what it does not need. Landlock leaves it only the files that the run names, and seccomp
// only the system calls that a run makes. So nothing starts a process, opens a socket or signals another process any
// more.
//
//   Wall wall;
//   wall.read = {package, configuration};
//   wall.write = {run_folder};
//   if (Status s = raise_wall(wall); !s) warn(s.error());
//
// A run opens what it needs from outside before: sockets, ffmpeg, `Servant`s (cx/base/servant.h).

#include <filesystem>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/sanitized.h"

namespace cxlab {

/// What a process reaches behind the wall, beside the libraries, locales and time zones of the system.
struct Wall {
  std::vector<std::filesystem::path> read;  ///< files, and folders with all below; what is not there is left out
  /// Real paths, read as those of `read` are: one on which somebody has put a link by now is left out.
  std::vector<std::filesystem::path> exact;
  std::vector<std::filesystem::path> list;   ///< folders whose names, and those of folders below, are read
  std::vector<std::filesystem::path> write;  ///< folders: files below are read, made, changed and removed
  std::vector<std::filesystem::path> links;  ///< folders in which symbolic links are made, too
  bool send_to = false;                      ///< open sockets name the address of each datagram (--sockets)
  bool pictures = false;                     ///< are drawn, by a graphics card where there is one
  bool copies = false;                       ///< the process may copy itself, until `forbid_copies`
};

/// What this kernel has to build a wall of.
struct WallParts {
  int landlock = 0;  ///< version of its interface; 0: none
  bool seccomp = false;
  bool whole() const { return landlock > 0 && seccomp; }
  std::string text() const;  ///< "Landlock 7 and seccomp"
};
WallParts wall_parts();

/// A sanitizer does what a wall forbids, as to trace its own process at the end: programs with one play without a wall.
inline constexpr bool kPlaysBehindWalls = !kSanitized;

/// Raises the wall. An error says which part of it is missing, and what that leaves open; the other part stands.
Status raise_wall(const Wall& wall);
/// In a copy of a process behind a wall with `Wall::copies`: takes away what that wall left open, for good. Behind it
/// a process cannot signal even itself.
Status forbid_copies();

}  // namespace cxlab
