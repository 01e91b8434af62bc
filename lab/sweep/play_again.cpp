#include "lab/sweep/play_again.h"

#include <list>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/base/process.h"
#include "lab/sweep/suite.h"

namespace cxlab::lab {

namespace fs = std::filesystem;

namespace {

struct PlayingAgain {
  const GameAgain* game;
  Process process;
};

Expected<Process> begin(const GameAgain& again) {
  std::error_code error;
  ProcessOptions process;
  process.argv = words_of_shell(again.game->command);
  if (process.argv.size() < 3 || process.argv[0] != "cxlab" || process.argv[1] != "run")
    return input_error(found_expected("the command '" + again.game->command + "'",
                                      "'cxlab run ...': only an index, runs.sqlite, has the commands of games"),
                       again.game->file);
  process.argv[0] = fs::read_symlink("/proc/self/exe", error).string();
  for (const std::string& word :
       {std::string("--quiet"), std::string("--force"), std::string("--out"), again.folder.string()})
    process.argv.push_back(word);
  process.out = Stream::null();
  return Process::start(process);
}

Status end(PlayingAgain playing, std::vector<std::string>& remarks) {
  const int code = playing.process.wait();
  const auto result = read_file(playing.game->folder / "result.json");
  if (!result)
    return resource_error("the game was not played, exit code " + std::to_string(code), playing.game->folder.string());
  const Json json = parse_json(*result);
  if (json.is_object() && json.value("journal_hash", std::string()) != playing.game->game->row.journal_hash)
    remarks.push_back(title_of(playing.game->game->row.cell) +
                      ": the game goes otherwise now, because its files or cxlab have changed since the sweep");
  return {};
}

}  // namespace

Expected<std::vector<std::string>> play_again(const std::vector<GameAgain>& games, int jobs, const Host& host,
                                              const std::function<Status(const GameAgain&)>& ended) {
  std::vector<std::string> remarks;
  std::list<PlayingAgain> playing;
  auto next = games.begin();
  for (std::size_t done = 0; done < games.size(); ++done) {
    for (; next != games.end() && playing.size() < static_cast<std::size_t>(jobs); ++next) {
      auto process = begin(*next);
      if (!process) return process.error();
      playing.push_back({&*next, *std::move(process)});
    }
    PlayingAgain first = std::move(playing.front());
    playing.pop_front();
    const GameAgain& game = *first.game;
    if (Status s = end(std::move(first), remarks); !s) return s.error();
    if (host.stopped()) break;
    if (ended)
      if (Status s = ended(game); !s) return s.error();
    host.show_games(done + 1, games.size(), playing.size());
  }
  return remarks;
}

}  // namespace cxlab::lab
