#include "lab/mutate.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <list>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/base/process.h"
#include "cx/base/random.h"
#include "cx/base/scratch_folder.h"
#include "cx/base/servant.h"
#include "cx/engine/form_reader.h"
#include "cx/yaml/yaml.h"
#include "lab/pipe.h"
#include "lab/sweep/remaining_time.h"
#include "scenarios/scenario.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

fs::path place_on_disk(const fs::path& path) {
  const fs::path normal = fs::absolute(path).lexically_normal();
  return normal.has_filename() ? normal : normal.parent_path();
}

/// The innermost package around a file or folder; without one the folder itself.
fs::path package_around(const fs::path& path) {
  const fs::path folder = is_folder(path) ? place_on_disk(path) : place_on_disk(path).parent_path();
  return nearest_package(folder).value_or(folder);
}

/// Whether a file is this one, or lies below it.
bool lies_in(const fs::path& file, const fs::path& place) {
  const fs::path relative = file.lexically_relative(place);
  return !relative.empty() && *relative.begin() != "..";
}

/// The same whatever the stories are chosen by: the path in the package, without a package the name alone.
std::string name_of_rules(const fs::path& file) {
  const auto package = nearest_package(file.parent_path());
  return (package ? file.lexically_relative(*package) : file.filename()).generic_string();
}

std::string title_of_story(const testing::StorySpec& story) { return story.file + "::" + story.name; }

bool has_constructs(const std::string& text, const std::string& file) {
  return std::ranges::any_of(read_forms(text, file).forms,
                             [](const Form& form) { return form.head.starts_with("def"); });
}

/// The configurations of a scenario, or the one that the file is.
Expected<std::vector<fs::path>> configurations_in(const std::string& agent, const Catalogue& catalogue) {
  const auto file = find_scenario(agent);
  if (!file) return file.error();
  auto document = yaml::Document::load(*file);
  if (!document) return document.error();
  yaml::Map root = document->root().as_map();
  if (!root.has("agents") && !root.has("schema") && !root.has("world")) return std::vector{place_on_disk(*file)};
  const auto scenario = Scenario::load(*file, catalogue, {});
  if (!scenario) return scenario.error();
  std::vector<fs::path> out;
  for (const AgentSpec& a : scenario->agents)
    if (!a.config.empty()) out.push_back(place_on_disk(scenario->resolve(a.config)));
  if (out.empty()) return input_error("the scenario has no agent with a configuration", agent);
  return out;
}

/// What the process that plays a mutant answers.
struct MutantAnswer {
  bool loads = true;
  PlayedMutant played;
};

std::string line_of_answer(const MutantAnswer& answer) {
  return json_text(Json{{"loads", answer.loads},
                        {"verdict", static_cast<int>(answer.played.fate)},
                        {"killer", answer.played.killer},
                        {"complaint", answer.played.complaint}});
}

std::optional<MutantAnswer> answer_of_line(const std::string& text) {
  try {
    const Json line = parse_json(text);
    MutantAnswer answer;
    answer.loads = line.at("loads").get<bool>();
    answer.played.fate = static_cast<Fate>(line.at("verdict").get<int>());
    answer.played.killer = line.at("killer").get<std::string>();
    answer.played.complaint = line.at("complaint").get<std::string>();
    return answer;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

/// What stories that were played one after the other until one failed say of the mutant.
MutantAnswer judged_mutant(const std::vector<PlayedStory>& stories) {
  MutantAnswer answer;
  for (const PlayedStory& story : stories) {
    if (!story.played || story.passed()) continue;
    answer.loads = !story.result.bad;
    answer.played.fate = story.late ? Fate::kTimedOut : Fate::kKilled;
    answer.played.killer = title_of_story(story.spec);
    answer.played.complaint = story.complaints().front();
    break;
  }
  return answer;
}

/// The stories of this path; an error if a file of them cannot be read.
Expected<std::vector<PlayedStory>> readable_stories(const std::string& path) {
  auto stories = read_stories({path});
  if (stories)
    for (const PlayedStory& story : *stories)
      if (story.unreadable) return *story.result.bad;
  return stories;
}

}  // namespace

const char* to_string(Fate fate) {
  switch (fate) {
    case Fate::kSurvived: return "survived";
    case Fate::kKilled: return "killed";
    default: return "timed out";
  }
}

Expected<MutationSubject> mutation_subject(const std::string& agent, const Catalogue& catalogue) {
  MutationSubject subject;
  const std::string story_file = agent.substr(0, agent.find("::"));
  if (is_folder(agent) || story_file.ends_with(".story.yaml")) {
    auto stories = readable_stories(agent);
    if (!stories) return stories.error();
    subject.stories = *std::move(stories);
    subject.own = {package_around(is_folder(agent) ? agent : story_file)};
  } else {
    const auto configs = configurations_in(agent, catalogue);
    if (!configs) return configs.error();
    std::set<fs::path> packages, wanted(configs->begin(), configs->end());
    for (const fs::path& config : *configs) packages.insert(package_around(config));
    for (const fs::path& package : packages) {
      auto stories = readable_stories(package.lexically_proximate(fs::current_path()).string());
      if (!stories) return stories.error();
      for (PlayedStory& story : *stories)
        if (wanted.contains(place_on_disk(story.spec.config))) subject.stories.push_back(std::move(story));
      subject.own.push_back(package);
    }
    if (subject.stories.empty())
      return input_error("no story below " + packages.begin()->string() + " plays this configuration", agent);
  }
  subject.golden = std::erase_if(subject.stories, [](const PlayedStory& s) { return !s.spec.golden.empty(); });
  if (subject.stories.empty())
    return input_error("there are only golden runs, which any change of a rule kills", agent);
  return subject;
}

std::size_t MutationResult::count(Fate fate) const {
  return static_cast<std::size_t>(std::ranges::count(played, fate, &PlayedMutant::fate));
}

double MutationResult::score() const {
  if (played.empty()) return 1;
  return static_cast<double>(played.size() - count(Fate::kSurvived)) / static_cast<double>(played.size());
}

std::optional<statistics::Interval> MutationResult::interval() const {
  if (all || played.empty()) return std::nullopt;
  return statistics::share_interval(played.size() - count(Fate::kSurvived), played.size());
}

// --- What there is to change, and which stories can notice it

static constexpr double kFirstPatience = 60;  // s

Expected<Mutation> Mutation::prepare(MutationSubject subject, const std::vector<std::string>& files, StoryPlan plan,
                                     const Host& host) {
  constexpr double kLeast = 2, kTimes = 10;  // s; of the slowest story
  Mutation out;
  out.subject_ = std::move(subject);
  out.plan_ = std::move(plan);
  StoryPlan first = out.plan_;
  first.setup.coverage = true;
  first.load_once = true;
  if (first.patience_s <= 0) first.patience_s = kFirstPatience;
  const auto begun = std::chrono::steady_clock::now();
  std::vector<PlayedStory>& stories = out.subject_.stories;
  if (Status s = play_stories(stories, first, host); !s) return s.error();
  out.stories_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  if (host.stopped()) return out;
  double slowest = 0;
  for (std::size_t i = 0; i < stories.size(); ++i) {
    const PlayedStory& story = stories[i];
    if (story.result.bad) return *story.result.bad;
    if (!story.passed())
      return negative("the story '" + story.spec.name + "' fails without any change: " + story.complaints().front() +
                          "; fix that first",
                      story.spec.file, story.spec.line);
    slowest = std::max(slowest, story.wall_s / static_cast<double>(std::max<std::size_t>(story.seeds_played, 1)));
    out.firings_.push_back(0);
    out.read_.emplace_back(story.result.files.begin(), story.result.files.end());
    for (const explain::Coverage::Rule& rule : story.result.coverage.rules) {
      out.firings_.back() += rule.fired;
      if (rule.activated > 0)
        out.uses_[std::string(without_module(rule.name))].push_back({i, rule.file, rule.fired, rule.activated});
    }
  }
  if (out.plan_.patience_s <= 0) out.plan_.patience_s = kLeast + kTimes * slowest;
  out.plan_.begins = {};
  out.plan_.ended = {};
  out.plan_.runs.clear();
  if (Status s = out.read_files(files); !s) return s.error();
  return out;
}

Expected<Mutation> Mutation::load(MutationSubject subject, const std::vector<std::string>& files, StoryPlan plan,
                                  const Host& host) {
  Mutation out;
  out.subject_ = std::move(subject);
  std::vector<PlayedStory> agents;
  for (const PlayedStory& story : out.subject_.stories) {
    testing::StorySpec agent = testing::agent_of(story.spec);
    const auto is_same = [&](const PlayedStory& known) { return same_agent(known.spec, agent); };
    if (std::ranges::none_of(agents, is_same)) agents.push_back({std::move(agent)});
  }
  if (plan.patience_s <= 0) plan.patience_s = kFirstPatience;
  if (Status s = play_stories(agents, plan, host); !s) return s.error();
  if (host.stopped()) return out;
  for (const PlayedStory& agent : agents) {
    if (agent.result.bad) return *agent.result.bad;
    out.read_.emplace_back(agent.result.files.begin(), agent.result.files.end());
  }
  if (Status s = out.read_files(files); !s) return s.error();
  return out;
}

Status Mutation::read_files(const std::vector<std::string>& files) {
  std::set<fs::path> read;
  for (const auto& of_story : read_) read.insert(of_story.begin(), of_story.end());
  std::vector<fs::path> named, places(subject_.own);
  for (const PlayedStory& story : subject_.stories) {
    for (const fs::path& file : story.spec.rules) named.push_back(place_on_disk(file));
    for (const auto& [name, folder] : story.spec.packages) named.push_back(place_on_disk(folder));
  }
  const auto in_any = [](const fs::path& file, const std::vector<fs::path>& of) {
    return std::ranges::any_of(of, [&](const fs::path& place) { return lies_in(file, place); });
  };
  for (const fs::path& file : read) {
    if (!is_file(file)) continue;
    auto text = read_file(file);
    if (!text || !has_constructs(*text, file.string())) continue;
    texts_.push_back({name_of_rules(file), *std::move(text), false});
    paths_.push_back(file);
  }
  // Stories may lie beside what they are about instead of around it.
  if (std::ranges::none_of(paths_, [&](const fs::path& file) { return in_any(file, places); })) places = named;
  if (!files.empty()) {
    places.clear();
    for (const std::string& file : files) {
      places.push_back(place_on_disk(file));
      if (std::ranges::none_of(paths_, [&](const fs::path& path) { return lies_in(path, places.back()); }))
        return usage_error("--file: no story reads a rule file " + file);
    }
  }
  for (std::size_t i = 0; i < texts_.size(); ++i) texts_[i].changed = in_any(paths_[i], places);
  mutants_ = mutants_of(texts_);
  if (mutants_.empty()) return input_error("the rules that these stories play have nothing to change");
  return {};
}

std::size_t Mutation::files() const {
  return static_cast<std::size_t>(std::ranges::count(texts_, true, &RuleText::changed));
}

std::string Mutation::place_of(const Mutant& mutant) const {
  return paths_[mutant.file].lexically_proximate(fs::current_path()).string() + ':' + std::to_string(mutant.line);
}

Expected<std::size_t> Mutation::find(const std::string& id) const {
  for (std::size_t i = 0; i < mutants_.size(); ++i)
    if (mutants_[i].id == id) return i;
  return usage_error("there is no mutant '" + id +
                     "'; --list names all, and a change of its lines gives it another name");
}

std::map<std::size_t, std::pair<long, long>> Mutation::uses_of(const Mutant& mutant) const {
  std::map<std::size_t, std::pair<long, long>> out;
  for (const std::string& rule : rules_that_use(texts_, mutant)) {
    const auto known = uses_.find(rule);
    if (known == uses_.end()) continue;
    for (const Use& use : known->second) {
      // Another rule of the name, in another module or environment.
      if (mutant.kind == "defrule" && use.file != paths_[mutant.file].string()) continue;
      out[use.story].first += use.fired;
      out[use.story].second += use.activated;
    }
  }
  return out;
}

std::vector<std::string> Mutation::reached_by(const Mutant& mutant) const {
  std::vector<std::string> out;
  for (const auto& [story, use] : uses_of(mutant))
    if (use.first > 0) out.push_back(title_of_story(subject_.stories[story].spec));
  return out;
}

std::vector<std::size_t> Mutation::stories_for(const Mutant& mutant) const {
  const auto uses = uses_of(mutant);
  struct Candidate {
    int rank;
    long firings;
    std::size_t story;
    auto operator<=>(const Candidate&) const = default;
  };
  std::vector<Candidate> candidates;
  std::optional<Candidate> cheapest;
  for (std::size_t i = 0; i < subject_.stories.size(); ++i) {
    if (!read_[i].contains(paths_[mutant.file])) continue;
    const auto use = uses.find(i);
    const bool fired = use != uses.end() && use->second.first > 0;
    const Candidate candidate{fired ? 0 : use != uses.end() ? 1 : 2, firings_[i], i};
    if (!cheapest || candidate.firings < cheapest->firings) cheapest = candidate;
    const bool same = mutant.acts ? !fired : mutant.change == Change::kSalience && use == uses.end();
    if (!same) candidates.push_back(candidate);
  }
  if (candidates.empty() && cheapest) candidates.push_back(*cheapest);  // it shows whether the rules load
  std::ranges::sort(candidates);
  std::vector<std::size_t> out;
  for (const Candidate& candidate : candidates) out.push_back(candidate.story);
  return out;
}

// --- Playing

Expected<std::vector<PlayedStory>> Mutation::play(const Mutant& mutant, const fs::path& folder, bool all,
                                                  const Host& host) const {
  const fs::path file = folder / (mutant.id + '-' + paths_[mutant.file].filename().string());
  if (Status s = write_file(file, mutated(texts_[mutant.file].text, mutant)); !s) return s.error();
  std::vector<PlayedStory> stories;
  for (const std::size_t i : stories_for(mutant)) stories.push_back({subject_.stories[i].spec});
  StoryPlan plan = plan_;
  plan.setup.instead[paths_[mutant.file]] = file;
  plan.setup.patterns_known = true;
  plan.load_once = true;
  plan.stop_at_failure = !all;
  const Status played = play_stories(stories, plan, host);
  std::error_code ignored;
  fs::remove(file, ignored);
  if (!played) return played.error();
  return stories;
}

Expected<std::vector<PlayedStory>> Mutation::play_one(const Mutant& mutant, const Host& host) const {
  const auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  auto stories = play(mutant, (*scratch)->path(), true, host);
  if (!stories) return stories;
  for (const PlayedStory& story : *stories)
    if (story.result.bad) return *story.result.bad;
  return stories;
}

/// Plays mutants, each in a process that plays its stories in turn.
class MutantPlayer {
 public:
  MutantPlayer(const Mutation& mutation, const MutationDraw& draw, fs::path folder, const Host& host)
      : mutation_(mutation), draw_(draw), folder_(std::move(folder)), host_(host) {
    order_.resize(mutation.mutants().size());
    for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = i;
    RandomStream(draw.seed, "mutants").shuffle(order_);
    result_.wanted = draw.mutants == 0 ? order_.size() : std::min(draw.mutants, order_.size());
    result_.all = draw.mutants == 0;
    remaining_.add(kKind, result_.wanted);
  }

  Expected<MutationResult> play() {
    while (!host_.stopped()) {
      if (Status s = fill(); !s) return s.error();
      if (players_.empty()) break;
      if (Status s = listen(); !s) return s.error();
      show();
    }
    players_.clear();
    // If too few of all changes load, the mutants that were played are all that exist.
    const bool exhausted = next_ == order_.size() && !host_.stopped();
    if (exhausted) result_.wanted = result_.played.size();
    result_.all = exhausted;
    std::ranges::sort(result_.played, {}, &PlayedMutant::mutant);
    return std::move(result_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr const char* kKind = "mutant";

  struct Player {
    std::size_t mutant = 0;
    Descriptor answers;
    Process process;
    Clock::time_point begun = Clock::now();
    std::string said = {};
  };

  static double since(Clock::time_point begun) { return std::chrono::duration<double>(Clock::now() - begun).count(); }

  /// Mutants that may still turn out not to load count as played. So the played mutants are the first ones of the order
  /// that load, whatever the number of processes is.
  bool wants_more() const {
    return next_ < order_.size() && result_.played.size() + players_.size() < result_.wanted &&
           (draw_.time_limit_s <= 0 || since(begun_) < draw_.time_limit_s);
  }

  Status fill() {
    while (players_.size() < static_cast<std::size_t>(std::max(mutation_.plan_.jobs, 1)) && wants_more()) {
      auto pipe = make_pipe();
      if (!pipe) return pipe.error();
      const std::size_t mutant = order_[next_];
      auto process = Process::fork({}, [&] { return play_in_process(mutant, pipe->to); }, pipe->to.number());
      if (!process) return process.error();
      ++next_;
      remaining_.begun(kKind);
      players_.push_back({mutant, std::move(pipe->from), *std::move(process)});
    }
    return {};
  }

  int play_in_process(std::size_t number, const Descriptor& to) const {
    const auto stories = mutation_.play(mutation_.mutants()[number], folder_, false, {});
    if (!stories) return static_cast<int>(stories.error().kind);
    return say_to(to, line_of_answer(judged_mutant(*stories)));
  }

  Status listen() {
    constexpr int kLookAtHost = 100;  // ms
    std::vector<pollfd> ends;
    for (const Player& player : players_) ends.push_back({player.answers.number(), POLLIN, 0});
    (void)poll(ends.data(), ends.size(), kLookAtHost);
    auto end = ends.begin();
    for (auto player = players_.begin(); player != players_.end();) {
      if ((end++)->revents == 0 || hear(*player)) {
        ++player;
        continue;
      }
      if (Status s = take(*player); !s) return s;
      player = players_.erase(player);
    }
    return {};
  }

  /// False once the process has closed its end.
  static bool hear(Player& player) {
    char bytes[1 << 12];
    const ssize_t n = read(player.answers.number(), bytes, sizeof bytes);
    if (n > 0) player.said.append(bytes, static_cast<std::size_t>(n));
    return n > 0 || (n < 0 && errno == EINTR);
  }

  Status take(Player& player) {
    const int code = player.process.wait();
    auto answer = answer_of_line(player.said);
    if (code != 0 || !answer)
      return resource_error("the process that played mutant " + mutation_.mutants()[player.mutant].id +
                            " ended with code " + std::to_string(code));
    remaining_.ended(kKind, since(player.begun));
    if (answer->loads) {
      answer->played.mutant = player.mutant;
      result_.played.push_back(std::move(answer->played));
    } else {
      ++result_.not_loaded;
      if (draw_.mutants != 0) remaining_.add(kKind);
    }
    return {};
  }

  void show() const {
    if (!draw_.progress) return;
    const std::size_t total = std::min(result_.wanted, order_.size() - result_.not_loaded);
    MutationProgress now{result_.played.size(), total, players_.size(), result_.count(Fate::kSurvived), {}};
    double playing_s = 0;
    for (const Player& player : players_) playing_s += since(player.begun);
    now.seconds_left = remaining_.estimate(mutation_.plan_.jobs, playing_s);
    if (now.seconds_left && draw_.time_limit_s > 0)
      now.seconds_left = std::min(*now.seconds_left, std::max(draw_.time_limit_s - since(begun_), 0.0));
    draw_.progress(now);
  }

  const Mutation& mutation_;
  const MutationDraw& draw_;
  const fs::path folder_;
  const Host& host_;
  const Clock::time_point begun_ = Clock::now();
  std::vector<std::size_t> order_;
  std::size_t next_ = 0;  // in `order_`
  std::list<Player> players_;
  RemainingTime remaining_;
  MutationResult result_;
};

Expected<MutationResult> Mutation::play(const MutationDraw& draw, const Host& host) const {
  const auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  return MutantPlayer(*this, draw, (*scratch)->path(), host).play();
}

}  // namespace cxlab::lab
