#include "lab/story_stage.h"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <list>
#include <optional>
#include <utility>

#include "cx/base/number_text.h"
#include "cx/base/process.h"
#include "cx/base/servant.h"
#include "lab/pipe.h"
#include "lab/story_answer.h"

namespace cxlab::lab {

namespace {

using StageClock = std::chrono::steady_clock;

double seconds_since_stage(StageClock::time_point start) {
  return std::chrono::duration<double>(StageClock::now() - start).count();
}

// --- In the process that has loaded the agent. It is asked for a story in a line, `STORY SEED`; its copy answers in a
// line, and itself after it in another one, `=CODE`, with how the copy ended.

int exit_code_of(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

std::optional<std::string> asked_line() {
  std::string line;
  for (char c = 0;;) {
    const ssize_t n = read(STDIN_FILENO, &c, 1);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return std::nullopt;
    if (c == '\n') return line;
    line += c;
  }
}

int play_copy(testing::Stage& stage, testing::StorySpec spec, std::uint64_t seed, pid_t parent, const Descriptor& to) {
  if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0 || getppid() != parent) return 1;
  if (kPlaysBehindWalls && !forbid_copies() && wall_parts().seccomp) return static_cast<int>(ErrorKind::kResource);
  spec.seed = seed;
  return say_to(to, story_answer(stage.play(spec)));
}

int keep_stage(const std::vector<PlayedStory>& stories, std::size_t first, std::uint64_t seed,
               testing::StorySetup setup, const Descriptor& to) {
  if (kPlaysBehindWalls)
    setup.confine = [](Wall wall) {
      wall.copies = true;
      (void)raise_wall(wall);
    };
  testing::StorySpec agent = stories[first].spec;
  agent.seed = seed;
  testing::Stage stage(agent, setup);
  while (const auto asked = asked_line()) {
    const std::size_t blank = asked->find(' ');
    const auto story = read_number<std::size_t>(asked->substr(0, blank));
    const auto its_seed = read_number<std::uint64_t>(asked->substr(blank + 1));
    if (!story || !its_seed) return 1;
    const pid_t stage_process = getpid(), copy = fork();
    if (copy == 0) _exit(play_copy(stage, stories[*story].spec, *its_seed, stage_process, to));
    int status = 1 << 8;
    while (copy > 0 && waitpid(copy, &status, 0) < 0 && errno == EINTR) {
    }
    if (const int code = say_to(to, "\n=" + std::to_string(exit_code_of(status)) + '\n'); code != 0) return code;
  }
  return 0;
}

// --- In the process that asks

struct StageProcess {
  testing::StorySpec agent;
  Descriptor answers;
  Process process;
  std::string said = {};
};

class Stages {
 public:
  Stages(std::vector<PlayedStory>& stories, const StoryPlan& plan, const Host& host)
      : stories_(stories), plan_(plan), host_(host) {}

  Status play() {
    for (std::size_t i = 0; i < stories_.size() && !host_.stopped(); ++i) {
      PlayedStory& story = stories_[i];
      if (Status s = play(i); !s) return s;
      if (host_.stopped()) break;
      story.played = true;
      if (plan_.ended) plan_.ended(story);
      if (plan_.stop_at_failure && !story.passed()) break;
    }
    return {};
  }

 private:
  Status play(std::size_t i) {
    PlayedStory& story = stories_[i];
    if (story.unreadable) return {};
    if (plan_.begins) plan_.begins(story);
    for (const std::uint64_t seed : story.spec.seeds.empty() ? std::vector{story.spec.seed} : story.spec.seeds) {
      if (Status s = play(i, seed); !s) return s;
      if (plan_.stop_at_failure && !story.passed()) break;
    }
    return {};
  }

  Status play(std::size_t i, std::uint64_t seed) {
    PlayedStory& story = stories_[i];
    const auto begun = StageClock::now();
    testing::StorySpec agent = story.spec;
    agent.seed = seed;
    auto stage = std::ranges::find_if(stages_, [&](const StageProcess& s) { return same_agent(s.agent, agent); });
    if (stage == stages_.end()) {
      if (Status s = start(i, std::move(agent)); !s) return s;
      stage = std::prev(stages_.end());
    }
    const bool asked = stage->process.write(std::to_string(i) + ' ' + std::to_string(seed) + '\n').ok();
    int code = asked ? ended(*stage, begun) : kStageGone;
    if (host_.stopped()) return {};
    const double wall_s = seconds_since_stage(begun);
    std::string said = stage->said.substr(0, stage->said.find('\n'));
    stage->said.clear();
    if (code == kStageGone) {
      code = stage->process.wait();
      stages_.erase(stage);
    }
    story.wall_s += wall_s;
    add_answer(story, seed, {std::move(said), code, wall_s > plan_.patience_s, plan_.patience_s});
    return {};
  }

  Status start(std::size_t i, testing::StorySpec agent) {
    auto pipe = make_pipe();
    if (!pipe) return pipe.error();
    ProcessOptions options;
    options.in = Stream::pipe();
    auto process = Process::fork(
        options, [&] { return keep_stage(stories_, i, agent.seed, plan_.setup, pipe->to); }, pipe->to.number());
    if (!process) return process.error();
    stages_.push_back({std::move(agent), std::move(pipe->from), *std::move(process)});
    return {};
  }

  static constexpr int kStageGone = -1;

  /// The code with which the copy has ended; `kStageGone` if its stage has, too, or was ended because it is late.
  int ended(StageProcess& stage, StageClock::time_point begun) {
    constexpr int kLookAtHost = 100;  // ms
    while (!host_.stopped()) {
      const std::size_t mark = stage.said.rfind("\n=");
      if (mark != std::string::npos && mark + 1 < stage.said.size() - 1 && stage.said.ends_with('\n'))
        return read_number<int>(stage.said.substr(mark + 2, stage.said.size() - mark - 3)).value_or(1);
      pollfd end{stage.answers.number(), POLLIN, 0};
      (void)poll(&end, 1, kLookAtHost);
      if (end.revents == 0) {
        if (seconds_since_stage(begun) <= plan_.patience_s) continue;
        stage.process.kill();
        return kStageGone;
      }
      char bytes[1 << 14];
      const ssize_t n = read(stage.answers.number(), bytes, sizeof bytes);
      if (n == 0 || (n < 0 && errno != EINTR)) return kStageGone;
      if (n > 0) stage.said.append(bytes, static_cast<std::size_t>(n));
    }
    return kStageGone;
  }

  std::vector<PlayedStory>& stories_;
  const StoryPlan& plan_;
  const Host& host_;
  std::list<StageProcess> stages_;
};

}  // namespace

Status play_on_stages(std::vector<PlayedStory>& stories, const StoryPlan& plan, const Host& host) {
  return Stages(stories, plan, host).play();
}

}  // namespace cxlab::lab
