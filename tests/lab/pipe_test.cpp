#include "lab/pipe.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <string>
#include <thread>

namespace cxlab::lab {
namespace {

const std::string kText(300'000, 'x');  // more than a pipe holds

TEST(Pipe, TakesATextThatIsLongerThanItHolds) {
  auto pipe = make_pipe();
  ASSERT_TRUE(pipe);
  std::string came;
  std::jthread reader([&] {
    char bytes[5000];
    for (ssize_t n = 0; (n = read(pipe->from.number(), bytes, sizeof bytes)) > 0;)
      came.append(bytes, static_cast<std::size_t>(n));
  });
  EXPECT_EQ(say_to(pipe->to, kText), 0);
  pipe->to = Descriptor();
  reader.join();
  EXPECT_TRUE(came == kText);
}

/// As after a signal: the system takes a part of the text.
TEST(Pipe, ATextThatIsTakenInPartIsNotSaid) {
  auto pipe = make_pipe();
  ASSERT_TRUE(pipe);
  ASSERT_EQ(fcntl(pipe->to.number(), F_SETFL, O_NONBLOCK), 0);
  EXPECT_EQ(say_to(pipe->to, "short"), 0);
  EXPECT_EQ(say_to(pipe->to, kText), static_cast<int>(ErrorKind::kResource));
}

}  // namespace
}  // namespace cxlab::lab
