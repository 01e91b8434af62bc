#pragma once
// The parts of the module `_cxlab`: each adds its classes and functions. The package (python/cxlab) wraps them; users
// do not see them.

#include <nanobind/nanobind.h>

#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <tuple>
#include <utility>

#include "cx/base/expected.h"
#include "cx/bus/message.h"
#include "cx/engine/value.h"

namespace cxlab {
class Episode;
class SeatBus;
struct Scene;
struct Seat;
namespace lab {
class Frames;
}
}  // namespace cxlab

namespace cxlab::python {

namespace nb = nanobind;

void bind_choice(nb::module_& module);
void bind_episode(nb::module_& module);
void bind_training(nb::module_& module);
void bind_run(nb::module_& module);
void bind_seats(nb::module_& module);

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
/// int, float, str or list; None for nothing. Facts and instances are their names.
nb::object to_python(const Value& value);
/// A dict of all fields; messages inside are dicts, arrays lists.
nb::object to_python(const bus::MessageView& message);
/// Arrays of NumPy, one row for each entity (cxlab/episode.py names them).
nb::dict to_python(const Scene& scene);

/// An object that C++ keeps, and may let go of without the lock of the interpreter.
using SharedObject = std::shared_ptr<nb::object>;
SharedObject share(nb::object object);

/// What an episode, its seats and their buses know of a step that is going on.
class Play {
 public:
  // --- Who plays: changed with the lock of the interpreter held
  bool begin() { return !playing_.exchange(true) && (player_ = std::this_thread::get_id(), true); }
  void end() { playing_ = false; }
  /// Whether another thread plays at the moment.
  bool is_elsewhere() const { return playing_ && player_.load() != std::this_thread::get_id(); }

  // --- What code of Python raised while it was called
  /// Keeps what was raised. KeyboardInterrupt ends a step, everything else the run: then it returns the error of it.
  Status keep(nb::python_error& error, const std::string& who);
  bool has_raised() const { return raised_ != nullptr; }
  /// The error of what `who` raised; none if another one did.
  Status error_of(const std::string& who) const { return who == who_ ? status_ : Status(); }
  /// Raises it, if there is anything, and forgets it.
  void raise_again();

 private:
  std::atomic<bool> playing_ = false;
  std::atomic<std::thread::id> player_;
  SharedObject raised_;
  Status status_;
  std::string who_;
};

/// Keeps other calls of the same episode out as long as it lives: it raises where one is at work.
class InUse {
 public:
  explicit InUse(Play& play) : play_(play) {
    if (!play_.begin())
      raise(usage_error("the episode is in use: by another thread, or by a seat that calls it from its turn"));
  }
  ~InUse() { play_.end(); }
  InUse(const InUse&) = delete;
  InUse& operator=(const InUse&) = delete;

 private:
  Play& play_;
};

/// How long Python waits for the lock of the interpreter, at most, and for a look at Ctrl-C.
constexpr auto kStretch = std::chrono::milliseconds(50);

/// Calls `play(pause)` without the lock of the interpreter until it ends by itself, not because `pause` said so, which
/// any thread may ask. After each call it calls `after()`, raises the error of `play`, and looks for Ctrl-C.
template <class F, class After>
auto in_stretches(F play, After after) {
  using Clock = std::chrono::steady_clock;
  while (true) {
    std::atomic<bool> paused = false;
    auto played = [&] {
      const nb::gil_scoped_release others_may_run;
      return play([&paused, until = Clock::now() + kStretch] {
        if (Clock::now() < until) return false;
        return paused = true;
      });
    }();
    after();
    auto value = value_or_raise(std::move(played));
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (!paused) return value;
  }
}
template <class F>
auto in_stretches(F play) {
  return in_stretches(std::move(play), [] {});
}

/// The seat of an object with the methods of cxlab.Seat; it gets its bus as attribute `bus`.
Seat seat_of_object(const nb::object& object, std::shared_ptr<Play> play);

/// The bus of a seat, for code of Python; of no use any more when the episode is closed.
class PythonBus {
 public:
  explicit PythonBus(SeatBus& bus, std::shared_ptr<Play> play, std::string who)
      : bus_(&bus), play_(std::move(play)), who_(std::move(who)) {}
  void close() { bus_ = nullptr; }

  double now() const;
  void read(const std::string& topic, const std::string& type, nb::object reader);
  void publish(const std::string& topic, const std::string& type, const std::string& yaml);
  void call(const std::string& service, const std::string& type, const std::string& yaml, nb::object on_response);
  std::uint32_t send_goal(const std::string& action, const std::string& type, const std::string& yaml,
                          nb::object on_answer, nb::object on_feedback, nb::object on_result);
  void cancel(std::uint32_t goal);

 private:
  SeatBus& open() const;
  /// Calls the object, if it is not None, with what `arguments` makes.
  template <class Arguments>
  void call_back(const SharedObject& callee, const Arguments& arguments);

  SeatBus* bus_;
  std::shared_ptr<Play> play_;
  std::string who_;
};

/// Draws the world of one episode; keeps a view for each size.
class Renderer {
 public:
  /// uint8 of (height, width, 3), top row first. Releases the lock while it draws.
  nb::object draw(Episode& episode, int width, int height, const std::string& camera, bool caption);

 private:
  std::map<std::tuple<int, int, bool>, std::unique_ptr<lab::Frames>> frames_;
};

}  // namespace cxlab::python
