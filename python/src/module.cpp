#include "bindings.h"

#include "lab/versions.h"

NB_MODULE(_cxlab, module) {
  module.doc() = "What of the package cxlab is written in C++.";
  module.attr("__version__") = cxlab::lab::cxlab_version();
  cxlab::python::bind_choice(module);
  cxlab::python::bind_episode(module);
  cxlab::python::bind_training(module);
  cxlab::python::bind_run(module);
  cxlab::python::bind_seats(module);
}
