#pragma once
// The token with which a program may ask a run over a port of this machine.

#include <string>

#include "cx/base/expected.h"

namespace cxlab::lab {

/// 128 bits of chance, as text.
Expected<std::string> new_token();
/// Takes the same time wherever they differ.
bool same_text(const std::string& a, const std::string& b);

}  // namespace cxlab::lab
