#pragma once
// `cxlab view`: pages and questions about runs, for a browser of this machine. This answers; lab/view/http.h carries.
//
//   auto view = Viewer::open(place, catalogue, false, host);
//   auto server = ViewServer::open(**view, port);
//   (*view)->confine(host);
//   std::puts((*server)->address().c_str());
//   (*server)->serve([] { return false; });

#include <filesystem>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "lab/view/players.h"
#include "lab/view/request.h"
#include "lab/view/runs.h"
#include "lab/view/visit.h"

namespace cxlab::lab {

class Viewer {
 public:
  /// `place`: the folder of a run, or a folder of runs. Before this process has a second thread.
  static Expected<std::unique_ptr<Viewer>> open(const std::filesystem::path& place, const Catalogue& catalogue,
                                                bool trust_programs, const Host& host);
  /// Gives up what answers do not need, for good (cx/wall/wall.h): to be called when the port is open, which stays so.
  void confine(const Host& host) const;
  ~Viewer();
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  /// The id of the run, if it is one.
  const std::optional<std::string>& only() const { return runs_.only(); }
  /// May be called from any thread, also while others are answered. Who may ask has been looked at before.
  ViewReply answer(const ViewRequest& request);
  /// Ends the processes that play runs, and what waits for them.
  void leave();

 private:
  Viewer(ViewedRuns runs, Players players, const Catalogue& catalogue, bool trust_programs)
      : runs_(std::move(runs)), players_(std::move(players)), catalogue_(catalogue), trust_programs_(trust_programs) {}
  ViewReply answer_run(const ViewRequest& request, const std::string& id, const std::string& rest);
  ViewReply answer_two(const ViewRequest& request);
  std::shared_ptr<Visit> visit(const std::string& id, const std::filesystem::path& folder);

  ViewedRuns runs_;
  Players players_;
  const Catalogue& catalogue_;
  bool trust_programs_;
  std::mutex mutex_;                                                  // of what follows
  std::list<std::pair<std::string, std::shared_ptr<Visit>>> visits_;  // the one that was asked last comes first
  bool left_ = false;
  std::mutex reading_;  // worlds and journals are read by one thread at a time; and of what follows
  /// Id and data.json of the run whose page was answered last, if it is over: the page asks for them next.
  std::optional<std::pair<std::string, std::string>> page_data_;
};

}  // namespace cxlab::lab
