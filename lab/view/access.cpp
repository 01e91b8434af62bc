#include "lab/view/access.h"

#include <string_view>

#include "cx/base/json.h"
#include "lab/control/token.h"

namespace cxlab::lab {

namespace {

constexpr const char* kRemedy = "open the address that cxlab view printed when it began";

/// The value of a cookie in "a=1; b=2".
std::string cookie_in(std::string_view cookies, const std::string& name) {
  while (!cookies.empty()) {
    const std::size_t end = std::min(cookies.find(';'), cookies.size());
    std::string_view one = cookies.substr(0, end);
    cookies.remove_prefix(std::min(end + 1, cookies.size()));
    while (one.starts_with(' ')) one.remove_prefix(1);
    if (one.starts_with(name + '=')) return std::string(one.substr(name.size() + 1));
  }
  return {};
}

}  // namespace

ViewReply view_error(int status, const std::string& sentence) {
  return {status, "application/json", json_text(Json{{"error", sentence}})};
}

ViewAccess::ViewAccess(std::string token, std::uint16_t port)
    : token_(std::move(token)), cookie_("cxlab_view_" + std::to_string(port)), port_(port) {}

std::string ViewAccess::address() const { return "http://127.0.0.1:" + std::to_string(port_) + "/?token=" + token_; }

bool ViewAccess::is_here(const std::string& host) const {
  const std::string port = ':' + std::to_string(port_);
  return host == "127.0.0.1" + port || host == "localhost" + port;
}

bool ViewAccess::knows_token(const ViewRequest& request) const {
  const std::string authorization = request.header("authorization");
  constexpr std::string_view kBearer = "Bearer ";
  if (authorization.starts_with(kBearer)) return same_text(authorization.substr(kBearer.size()), token_);
  return same_text(cookie_in(request.header("cookie"), cookie_), token_);
}

std::optional<ViewReply> ViewAccess::refuse(const ViewRequest& request) const {
  if (!is_here(request.header("host")))
    return view_error(403, "the request is for another host than 127.0.0.1:" + std::to_string(port_) + "; " + kRemedy);
  if (request.method == "POST") {
    const std::string origin = request.header("origin");
    constexpr std::string_view kHttp = "http://";
    if (request.headers.contains("origin") && !(origin.starts_with(kHttp) && is_here(origin.substr(kHttp.size()))))
      return view_error(403, "the request comes from another page, '" + origin + "'; " + kRemedy);
    const std::string type = request.header("content-type");
    if (type.substr(0, type.find(';')) != "application/json")
      return view_error(400, found_expected("Content-Type '" + type + "'", "application/json"));
  }
  if (!knows_token(request)) return view_error(403, std::string("the token is missing or wrong; ") + kRemedy);
  return std::nullopt;
}

std::optional<ViewReply> ViewAccess::admit(const ViewRequest& request) const {
  if (request.method != "GET" || request.path != "/" || !is_here(request.header("host")) ||
      !same_text(request.parameter("token"), token_))
    return std::nullopt;
  ViewReply reply{303, "text/html; charset=utf-8", {}, {}};
  reply.headers.emplace_back("Set-Cookie", cookie_ + '=' + token_ + "; Path=/; HttpOnly; SameSite=Strict");
  // A browser that follows a link of another page sends no strict cookie along a redirection.
  if (request.header("sec-fetch-site") == "cross-site") {
    reply.status = 200;
    reply.body = "<!doctype html><meta http-equiv=\"refresh\" content=\"0; url=/\"><title>cxlab view</title>";
  } else {
    reply.headers.emplace_back("Location", "/");
  }
  return reply;
}

}  // namespace cxlab::lab
