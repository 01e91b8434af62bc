#pragma once
// Who may ask `cxlab view`: whoever shows its token, from a page of its own or from a program of this machine.

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
  /// What the one who opens `address` gets: the cookie that all that follows shows.
  std::optional<ViewReply> admit(const ViewRequest& request) const;

 private:
  bool is_here(const std::string& host) const;
  bool knows_token(const ViewRequest& request) const;

  std::string token_, cookie_;
  std::uint16_t port_;
};

}  // namespace cxlab::lab
