#pragma once
// HTTP on 127.0.0.1 for `cxlab view`: carries requests to a Viewer, after checking that the client may ask.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "cx/base/expected.h"
#include "lab/view/viewer.h"

namespace cxlab::lab {

class ViewServer {
 public:
  /// Port 0 means any free port. Fails with kResource if the port is in use. The view must outlive the server.
  static Expected<std::unique_ptr<ViewServer>> open(Viewer& view, std::uint16_t port);
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  /// What a person opens, with the token.
  std::string address() const;
  /// Answers until `over` says so, which it asks several times a second.
  void serve(const std::function<bool()>& over);

 private:
  struct State;
  explicit ViewServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cxlab::lab
