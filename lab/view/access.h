#pragma once
// Decides who may ask `cxlab view`: its own pages and programs of this machine that show its token.

#include <cstdint>
#include <optional>
#include <string>

#include "lab/view/request.h"

namespace cxlab::lab {

class ViewAccess {
 public:
  ViewAccess(std::string token, std::uint16_t port);

  /// "http://127.0.0.1:PORT/?token=TOKEN"
  std::string address() const;
  /// Nothing if the request may be answered; else how it is refused. The Host must be this server, so that no name of
  /// another page's leads here; what changes something must come from a page of this server, as JSON.
  std::optional<ViewReply> refuse(const ViewRequest& request) const;
  /// The answer to a request for `address`: it sets the cookie that all later requests show.
  std::optional<ViewReply> admit(const ViewRequest& request) const;

 private:
  bool is_here(const std::string& host) const;
  bool knows_token(const ViewRequest& request) const;

  std::string token_, cookie_;
  std::uint16_t port_;
};

}  // namespace cxlab::lab
