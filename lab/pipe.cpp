#include "lab/pipe.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace cxlab::lab {

Expected<Pipe> make_pipe() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return resource_error(std::string("cannot make a pipe: ") + std::strerror(errno));
  return Pipe{Descriptor(ends[0]), Descriptor(ends[1])};
}

int say_to(const Descriptor& to, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = write(to.number(), text.data() + done, text.size() - done);
    if (n < 0 && errno != EINTR) return static_cast<int>(ErrorKind::kResource);
    if (n > 0) done += static_cast<std::size_t>(n);
  }
  return 0;
}

}  // namespace cxlab::lab
