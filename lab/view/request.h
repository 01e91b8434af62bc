#pragma once
// Requests and answers over HTTP, independent of the library that carries them.

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace cxlab::lab {

struct ViewRequest {
  std::string method;  ///< "GET" or "POST"
  std::string path;    ///< decoded, from its slash on
  std::map<std::string, std::string> query;
  std::map<std::string, std::string> headers;  ///< by name in small letters; one that comes twice has no value
  std::string body;

  std::string header(const std::string& name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? std::string() : found->second;
  }
  std::string parameter(const std::string& name) const {
    const auto found = query.find(name);
    return found == query.end() ? std::string() : found->second;
  }
};

struct ViewReply {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body = {};
  std::vector<std::pair<std::string, std::string>> headers = {};
};

/// {"error": "sentence"}
ViewReply view_error(int status, const std::string& sentence);

}  // namespace cxlab::lab
