// Seats: agents that are programs in Python, and what they can do on the bus.

#include "scenarios/seat.h"

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <cmath>
#include <memory>
#include <utility>

#include "bindings.h"

namespace cxlab::python {

// --- What was raised

Status Play::keep(nb::python_error& error, const std::string& who) {
  const nb::object value = nb::borrow(error.value());
  std::string what = Py_TYPE(value.ptr()) ? nb::cast<std::string>(value.type().attr("__name__")) : "something";
  try {
    const nb::str said(value);
    const auto utf8 =
        nb::steal<nb::bytes>(PyUnicode_AsEncodedString(said.ptr(), "utf-8", "backslashreplace"));  // lone surrogates
    if (!utf8.is_valid()) throw nb::python_error();
    if (utf8.size() > 0) what += ": " + std::string(utf8.c_str(), utf8.size());
  } catch (nb::python_error&) {  // it cannot be printed
  }
  if (raised_) return error_of(who);
  raised_ = share(value);
  who_ = who;
  status_ = error.matches(PyExc_KeyboardInterrupt) ? Status()
                                                   : Error(run_error("its program raised " + what)).with_code("python");
  return status_;
}

void Play::raise_again() {
  if (!raised_) return;
  const nb::object value = *std::exchange(raised_, nullptr);
  PyErr_SetObject(value.type().ptr(), value.ptr());
  throw nb::python_error();
}

// --- The bus

SeatBus& PythonBus::open() const {
  if (!bus_) raise(usage_error("the episode of this bus is closed"));
  if (play_->is_elsewhere()) raise(usage_error("the episode of this bus is played by another thread at the moment"));
  return *bus_;
}

template <class Arguments>
void PythonBus::call_back(const SharedObject& callee, const Arguments& arguments) {
  if (play_->has_raised()) return;  // the run ends with what was raised first
  const nb::gil_scoped_acquire lock;
  if (callee->is_none()) return;
  try {
    arguments(*callee);
  } catch (nb::python_error& error) {
    (void)play_->keep(error, who_);
  }
}

double PythonBus::now() const { return to_seconds(open().now()); }

void PythonBus::read(const std::string& topic, const std::string& type, nb::object reader) {
  check(open().read(topic, type, [this, callee = share(std::move(reader))](const bus::MessageView& message) {
    call_back(callee, [&](nb::object& call) { call(to_python(message)); });
  }));
}

void PythonBus::publish(const std::string& topic, const std::string& type, const std::string& yaml) {
  check(open().publish(topic, type, yaml));
}

void PythonBus::call(const std::string& service, const std::string& type, const std::string& yaml,
                     nb::object on_response) {
  check(open().call(service, type, yaml,
                    [this, callee = share(std::move(on_response))](const bus::MessageView& response) {
                      call_back(callee, [&](nb::object& call) { call(to_python(response)); });
                    }));
}

std::uint32_t PythonBus::send_goal(const std::string& action, const std::string& type, const std::string& yaml,
                                   nb::object on_answer, nb::object on_feedback, nb::object on_result) {
  GoalReaders readers;
  readers.answer = [this, callee = share(std::move(on_answer))](bool accepted) {
    call_back(callee, [&](nb::object& call) { call(accepted); });
  };
  readers.feedback = [this, callee = share(std::move(on_feedback))](const bus::MessageView& feedback) {
    call_back(callee, [&](nb::object& call) { call(to_python(feedback)); });
  };
  readers.result = [this, callee = share(std::move(on_result))](bool succeeded, const bus::MessageView& result) {
    call_back(callee, [&](nb::object& call) { call(succeeded, to_python(result)); });
  };
  return static_cast<std::uint32_t>(value_or_raise(open().send_goal(action, type, yaml, std::move(readers))));
}

void PythonBus::cancel(std::uint32_t goal) { check(open().cancel(static_cast<SeatGoal>(goal))); }

// --- The agent

namespace {

/// Calls the methods of an object of Python in the turn of its seat.
class PythonAgent final : public Agent {
 public:
  PythonAgent(SharedObject object, std::shared_ptr<PythonBus> bus, std::shared_ptr<Play> play, std::string who)
      : object_(std::move(object)), bus_(std::move(bus)), play_(std::move(play)), who_(std::move(who)) {}
  ~PythonAgent() override { bus_->close(); }
  PythonAgent(const PythonAgent&) = delete;
  PythonAgent& operator=(const PythonAgent&) = delete;

  Status perceive() override {
    return call([](nb::object& seat) { seat.attr("perceive")(); });
  }
  Status decide(SimTime now) override {
    return call([now](nb::object& seat) { seat.attr("decide")(to_seconds(now)); });
  }
  Status act() override {
    return call([this](nb::object& seat) {
      seat.attr("act")();
      const double due = nb::cast<double>(seat.attr("next_due")());
      if (std::isnan(due)) raise(usage_error("next_due: " + found_expected("nan", "a time, s")));
      due_ = due < 1e9 ? from_seconds(std::max(due, 0.0)) : kNever;
    });
  }
  SimTime next_due() const override { return due_; }

 private:
  template <class Call>
  Status call(const Call& call_method) {
    if (play_->has_raised()) return play_->error_of(who_);
    const nb::gil_scoped_acquire lock;
    try {
      call_method(*object_);
    } catch (nb::python_error& error) {
      return play_->keep(error, who_);
    } catch (const nb::cast_error&) {
      return usage_error("next_due: " + found_expected("no number", "a time, s"));
    }
    return {};
  }

  SharedObject object_;
  std::shared_ptr<PythonBus> bus_;
  std::shared_ptr<Play> play_;
  std::string who_;
  SimTime due_{};  // the first tick
};

}  // namespace

Seat seat_of_object(const nb::object& object, std::shared_ptr<Play> play) {
  std::string name;
  if (const nb::object given = nb::getattr(object, "name", nb::none()); !nb::try_cast(given, name))
    raise(usage_error(found_expected("a seat without a name", "one whose __init__ calls super().__init__(name)"),
                      "seats"));
  for (const char* method : {"perceive", "decide", "act", "next_due"})
    if (!nb::hasattr(object, method))
      raise(usage_error(found_expected("a seat without the method " + std::string(method), "one of class cxlab.Seat"),
                        "seats"));
  return {name,
          [name, play, shared = share(object)](SeatBus& bus) -> Expected<std::unique_ptr<Agent>> {
            const std::string who = "seat " + name;
            auto for_python = std::make_shared<PythonBus>(bus, play, who);
            auto agent = std::make_unique<PythonAgent>(shared, for_python, play, who);
            const nb::gil_scoped_acquire lock;
            try {
              shared->attr("_sit_down")(for_python);
            } catch (nb::python_error& error) {
              const Status kept = play->keep(error, who);
              return kept ? run_error("its program was interrupted") : kept.error();
            }
            return std::unique_ptr<Agent>(std::move(agent));
          },
          {}};
}

void bind_seats(nb::module_& module) {
  nb::class_<PythonBus>(module, "Bus")
      .def_prop_ro("now", &PythonBus::now)
      .def("read", &PythonBus::read, nb::arg("topic"), nb::arg("type"), nb::arg("reader"))
      .def("publish", &PythonBus::publish, nb::arg("topic"), nb::arg("type"), nb::arg("yaml"))
      .def("call", &PythonBus::call, nb::arg("service"), nb::arg("type"), nb::arg("yaml"),
           nb::arg("on_response").none())
      .def("send_goal", &PythonBus::send_goal, nb::arg("action"), nb::arg("type"), nb::arg("yaml"),
           nb::arg("on_answer").none(), nb::arg("on_feedback").none(), nb::arg("on_result").none())
      .def("cancel", &PythonBus::cancel, nb::arg("goal"));
}

}  // namespace cxlab::python
