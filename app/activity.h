#pragma once
// What a person sees of a command that takes long.

#include <string_view>

namespace cxlab::app {

/// From here on a command that prints nothing for 3 s reports on stderr what it is doing: this, how far it has come,
/// and whose rules are at work. Silence that goes on is reported after 6, 12, 24 s, then every 30 s. For people only:
/// it goes by the clock on the wall. An empty text: it does nothing, and waits.
void doing(std::string_view what);
/// No more of these lines: `--quiet`.
void stop_reporting();

/// Which lines of level debug a console shows: `lives` are those of nodes, which are loaded, activated and so on.
struct Shown {
  bool lives = false, others = false;
};
void show_debug_lines(Shown shown);

}  // namespace cxlab::app
