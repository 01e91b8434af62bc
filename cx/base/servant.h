#pragma once
// A copy of this process that does one kind of work for it. It keeps the rights that this process gives up afterwards
// (cx/wall/wall.h), so it decides itself on all that it is asked for.

#include <functional>
#include <string>

#include "cx/base/expected.h"

namespace cxlab {

/// A descriptor; closed with the object.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor();
  explicit operator bool() const { return number_ >= 0; }
  int number() const { return number_; }
  int release() {
    const int number = number_;
    number_ = -1;
    return number;
  }

 private:
  int number_;
};

/// Closes all descriptors of this process but the standard streams and `kept`.
void close_all_but(int kept);

class Servant {
 public:
  struct Answer {
    std::string text;
    Descriptor descriptor = Descriptor();  ///< handed over with the text, if there is one
  };
  /// Runs in the servant. `gone` says whether the other process has ended meanwhile.
  using Work = std::function<Answer(const std::string& request, const std::function<bool()>& gone)>;

  /// Forks. `at_end` runs in the servant when this object is destroyed or the process ends, however it does. The
  /// servant has no other descriptor of this process; signals of the terminal do not reach it. kResource if it cannot
  /// be made.
  static Expected<Servant> start(Work work, std::function<void()> at_end = {});

  Servant(Servant&& other) noexcept;
  Servant& operator=(Servant&& other) noexcept;
  /// Waits until `at_end` has run.
  ~Servant();

  Expected<Answer> ask(const std::string& request);

 private:
  Servant(Descriptor line, pid_t pid) : line_(std::move(line)), pid_(pid) {}
  void end();

  Descriptor line_;
  pid_t pid_ = -1;
};

}  // namespace cxlab
