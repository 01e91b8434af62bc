// Stories played in processes: each in a copy of this one, several at a time.

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <deque>
#include <list>
#include <optional>
#include <set>

#include "cx/base/file.h"
#include "cx/base/process.h"
#include "cx/base/servant.h"
#include "lab/golden.h"
#include "lab/pipe.h"
#include "lab/stories.h"
#include "lab/story_answer.h"
#include "lab/story_run.h"
#include "lab/story_stage.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// What a process does: it plays a story with a seed, or keeps a run of that.
struct Job {
  std::size_t story = 0;
  std::uint64_t seed = 1;
  fs::path keep = {};
};

/// A process that plays one story, and its end of a pipe with what it has said so far.
struct Player {
  std::size_t number;  ///< of its job
  Job job;
  Descriptor results;
  Process process;
  Clock::time_point begun = Clock::now();
  std::string said = {};
  bool late = false;  ///< it took longer than the patience
};

Expected<Player> start_player(std::size_t number, Job job, testing::StorySpec spec, const testing::StorySetup& setup) {
  auto pipe = make_pipe();
  if (!pipe) return pipe.error();
  const Descriptor& to = pipe->to;
  spec.seed = job.seed;
  ProcessOptions options;
  if (!job.keep.empty()) options.out = options.err = Stream::null();  // the first play has printed the same
  auto process = Process::fork(
      options,
      [&] {
        Host confined;
        confined.most = setup.limits;
        confined.confine = true;
        const bool golden = !spec.golden.empty();
        if (job.keep.empty())
          return say_to(
              to, story_answer(golden ? play_golden(spec, setup.coverage, confined) : testing::run_story(spec, setup)));
        const Status kept = golden ? keep_golden(spec, job.keep, confined) : keep_run(spec, setup, job.keep);
        return kept ? 0 : say_to(to, kept.error().text());
      },
      to.number());
  if (!process) return process.error();
  return Player{number, std::move(job), std::move(pipe->from), *std::move(process)};
}

/// Takes what is there; false once the process has closed its end, as it does when it ends.
bool hear(Player& player) {
  char bytes[1 << 14];
  const ssize_t n = read(player.results.number(), bytes, sizeof bytes);
  if (n > 0) player.said.append(bytes, static_cast<std::size_t>(n));
  return n > 0 || (n < 0 && errno == EINTR);
}

class Troupe {
 public:
  Troupe(std::vector<PlayedStory>& stories, const StoryPlan& plan, const Host& host)
      : stories_(stories), plan_(plan), host_(host), setup_(plan.setup), to_play_(stories.size()) {
    if (kPlaysBehindWalls) setup_.confine = [](const Wall& wall) { (void)raise_wall(wall); };
    for (std::size_t i = 0; i < stories.size(); ++i) {
      stories[i].played = stories[i].unreadable;
      if (stories[i].unreadable && plan.stop_at_failure) break;
      if (stories[i].unreadable) continue;
      const std::vector<std::uint64_t>& seeds = stories[i].spec.seeds;
      to_play_[i] = std::max<std::size_t>(seeds.size(), 1);
      for (const std::uint64_t seed : seeds.empty() ? std::vector{stories[i].spec.seed} : seeds)
        jobs_.push_back({i, seed});
    }
    last_ = jobs_.size();
  }

  Status play() {
    tell_played();
    while (next_ < last_ || !to_keep_.empty() || !players_.empty()) {
      if (host_.stopped()) break;
      if (Status s = fill(); !s) return s;
      listen();
    }
    players_.clear();
    for (; told_ < stories_.size(); ++told_) tell(stories_[told_]);
    return {};
  }

 private:
  Status fill() {
    while (players_.size() < static_cast<std::size_t>(std::max(plan_.jobs, 1))) {
      if (to_keep_.empty() && next_ >= last_) break;
      const bool keeps = !to_keep_.empty();
      Job job = keeps ? std::move(to_keep_.front()) : jobs_[next_];
      if (keeps) to_keep_.pop_front();
      const PlayedStory& story = stories_[job.story];
      if (plan_.begins) plan_.begins(story);
      auto player = start_player(keeps ? 0 : next_, std::move(job), story.spec, setup_);
      if (!player) return player.error();
      players_.push_back(*std::move(player));
      if (!keeps) ++next_;
    }
    return {};
  }

  void listen() {
    std::vector<pollfd> ends;
    for (const Player& player : players_) ends.push_back({player.results.number(), POLLIN, 0});
    constexpr int kLookAtHost = 100;  // ms
    (void)poll(ends.data(), ends.size(), kLookAtHost);
    auto end = ends.begin();
    for (auto player = players_.begin(); player != players_.end();) {
      const bool ready = (end++)->revents != 0;
      if (!player->late && seconds_since(player->begun) > plan_.patience_s) {  // also if it has ended meanwhile
        player->late = true;
        player->process.kill();
      }
      if (!ready || hear(*player)) {
        ++player;
        continue;
      }
      take(*player);
      player = players_.erase(player);
    }
    std::erase_if(players_, [this](const Player& p) { return p.job.keep.empty() && p.number >= last_; });
  }

  void take(Player& player) {
    PlayedStory& story = stories_[player.job.story];
    story.wall_s += seconds_since(player.begun);
    if (!player.job.keep.empty() && last_ > 0 && player.job.story > jobs_[last_ - 1].story) return;
    if (!player.job.keep.empty()) {
      (void)player.process.wait();
      if (is_file(player.job.keep / "manifest.json"))
        story.run = player.job.keep;
      else
        story.result.notes.push_back("no run was kept: " +
                                     (player.said.empty() ? "its process ended before it began" : player.said));
      return end(story);
    }
    if (player.number >= last_) return;  // it was on its way when an earlier one failed
    const int code = player.process.wait();
    add_answer(story, player.job.seed, {std::move(player.said), code, player.late, plan_.patience_s});
    --to_play_[player.job.story];
    if (plan_.stop_at_failure && !story.passed()) stop_after(player.number);
    for (std::size_t i = told_; i < stories_.size() && (last_ == 0 || i <= jobs_[last_ - 1].story); ++i)
      if (to_play_[i] == 0 && !stories_[i].played && !ending_.contains(i)) complete(i);
  }

  /// Jobs after this one are not done any more; stories after it that were faster were not played.
  void stop_after(std::size_t job) {
    for (; last_ > job + 1; --last_)
      if (const std::size_t story = jobs_[last_ - 1].story; story > jobs_[job].story)
        stories_[story] = PlayedStory{std::move(stories_[story].spec)};
    const std::size_t story = jobs_[job].story;
    to_play_[story] = 0;
    std::erase_if(to_keep_, [story](const Job& keep) { return keep.story > story; });
  }

  /// All of its seeds have been played.
  void complete(std::size_t i) {
    PlayedStory& story = stories_[i];
    if (story.seeds_played == 0) return;
    ending_.insert(i);
    if (story.passed() || story.result.bad || plan_.runs.empty()) return end(story);
    const std::string name = run_name(story.spec);
    const bool alone = std::ranges::count_if(stories_, [&](const PlayedStory& other) {
                         return !other.unreadable && run_name(other.spec) == name;
                       }) == 1;
    auto folder = folder_for(story.spec, alone, plan_.runs);
    if (!folder) {
      story.result.notes.push_back("no run was kept: " + folder.error().text());
      return end(story);
    }
    to_keep_.push_back({i, story.seed, *std::move(folder)});
  }

  void end(PlayedStory& story) {
    story.played = true;
    tell_played();
  }

  /// The stories that have ended, up to the first that has not.
  void tell_played() {
    while (told_ < stories_.size() && stories_[told_].played) tell(stories_[told_++]);
  }

  void tell(const PlayedStory& story) {
    if (story.played && plan_.ended) plan_.ended(story);
  }

  std::vector<PlayedStory>& stories_;
  const StoryPlan& plan_;
  const Host& host_;
  testing::StorySetup setup_;
  std::vector<Job> jobs_;
  std::vector<std::size_t> to_play_;  // by story: jobs that are left
  std::deque<Job> to_keep_;
  std::set<std::size_t> ending_;  // stories that have been played, whose run may still be kept
  std::list<Player> players_;
  std::size_t next_ = 0, told_ = 0;
  std::size_t last_ = 0;  // jobs before it are done
};

}  // namespace

Status play_stories(std::vector<PlayedStory>& stories, const StoryPlan& plan, const Host& host) {
  return plan.load_once ? play_on_stages(stories, plan, host) : Troupe(stories, plan, host).play();
}

}  // namespace cxlab::lab
