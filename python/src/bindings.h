#pragma once
// The parts of the module `_cxlab`: each adds its classes and functions. The package (python/cxlab) wraps them; users
// do not see them.

#include <nanobind/nanobind.h>

#include <string>
#include <string_view>
#include <utility>

#include "cx/base/expected.h"

namespace cxlab::python {

namespace nb = nanobind;

void bind_choice(nb::module_& module);
void bind_episode(nb::module_& module);

/// Throws the exception of the error's kind (cxlab/errors.py).
[[noreturn]] void raise(const Error& error);

/// The value, or the exception of the error.
template <class T>
T value_or_raise(Expected<T> expected) {
  if (!expected) raise(expected.error());
  return *std::move(expected);
}
inline void check(const Status& status) {
  if (!status) raise(status.error());
}

/// A text of rules or files as `str`: what is no UTF-8 becomes U+FFFD.
nb::str text(std::string_view bytes);
/// The value of a JSON text.
nb::object from_json(std::string_view json);

}  // namespace cxlab::python
