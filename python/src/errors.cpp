#include "bindings.h"

namespace cxlab::python {

void raise(const Error& error) {
  const nb::object made = nb::module_::import_("cxlab.errors")
                              .attr("error_of")(static_cast<int>(error.kind), text(error.message), text(error.file),
                                                error.line, text(error.code));
  PyErr_SetObject(made.type().ptr(), made.ptr());
  throw nb::python_error();
}

nb::str text(std::string_view bytes) {
  PyObject* made = PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), "replace");
  if (!made) throw nb::python_error();
  return nb::steal<nb::str>(made);
}

nb::object from_json(std::string_view json) { return nb::module_::import_("json").attr("loads")(text(json)); }

}  // namespace cxlab::python
