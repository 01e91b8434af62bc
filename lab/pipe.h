#pragma once
// How copies of this process answer it: each writes into a pipe, and ends.

#include <string>

#include "cx/base/expected.h"
#include "cx/base/servant.h"

namespace cxlab::lab {

struct Pipe {
  Descriptor from, to;
};
/// No other program inherits it.
Expected<Pipe> make_pipe();

/// Writes all of it; the exit code of a process that does nothing else.
int say_to(const Descriptor& to, const std::string& text);

}  // namespace cxlab::lab
