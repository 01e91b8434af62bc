#include "lab/view/page.h"

#include <three.h>

#include <algorithm>

#include "cx/base/byte_codec.h"
#include "cx/base/file.h"
#include "cx/journal/chunk.h"
#include "lab/base64.h"
#include "lab/report.h"
#include "lab/run_page.h"

namespace cxlab::lab {

namespace {

constexpr const char* kHtml = "text/html; charset=utf-8";
constexpr const char* kScript = "text/javascript; charset=utf-8";

/// How many bytes of a scene are whole chunks (scenarios/scene_log.h).
std::size_t whole_bytes(std::string_view scene) {
  constexpr std::size_t kMagic = 8;
  if (scene.size() < kMagic) return 0;
  ByteReader in(scene.substr(kMagic));
  std::size_t end = kMagic;
  while (read_chunk(in)) end = kMagic + in.position();
  return end;
}

ViewReply reply_of(Expected<std::string> text, const char* type) {
  if (!text) return view_error(500, text.error().text());
  return {200, type, *std::move(text)};
}

}  // namespace

ViewReply view_run_page(Json head) { return reply_of(served_run_page(std::move(head)), kHtml); }

ViewReply view_page(const std::string& name) { return reply_of(served_page(name), kHtml); }

ViewReply view_script(const std::string& name) {
  if (name != "three.js") return reply_of(served_script(name), kScript);
  ViewReply reply{200, kScript, bytes_of_base64(three_script())};
  reply.headers.emplace_back("Content-Encoding", "gzip");
  return reply;
}

ViewReply view_scene(const std::filesystem::path& run, std::size_t from) {
  constexpr const char* kBytes = "application/octet-stream";
  auto bytes = read_file(run / "scene.bin");
  if (!bytes) return {200, kBytes};  // a world without a scene, or a run that began a moment ago
  const std::size_t end = whole_bytes(*bytes);
  return {200, kBytes, bytes->substr(std::min(from, end), end - std::min(from, end))};
}

ViewReply view_file(const std::filesystem::path& run, const std::string& name) {
  const Json files = readable_files(run);
  if (std::ranges::find(files, Json(name)) == files.end())
    return view_error(404, "the page of the run links to no file '" + name + "'");
  std::error_code ignored;
  if (std::filesystem::canonical(run / name, ignored) != std::filesystem::canonical(run, ignored) / name)
    return view_error(404, "'" + name + "' lies behind a link, which is not followed");
  const auto text = read_file(run / name);
  if (!text) return view_error(404, text.error().text());
  return {200, name.ends_with(".json") ? "application/json" : "text/plain; charset=utf-8", *text};
}

}  // namespace cxlab::lab
