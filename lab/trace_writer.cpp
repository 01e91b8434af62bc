#include "lab/trace_writer.h"

namespace cxlab::lab {

TraceWriter::TraceWriter(std::string& out) : out_(out) { out_ += "{\"traceEvents\":["; }

void TraceWriter::put(const Json& event) {
  out_ += events_++ == 0 ? "\n" : ",\n";
  out_ += json_text(event);
}

TraceWriter::Thread TraceWriter::thread(const std::string& process, const std::string& thread) {
  const auto name = [&](const char* what, int pid, int tid, const std::string& is) {
    put({{"name", what}, {"ph", "M"}, {"pid", pid}, {"tid", tid}, {"args", {{"name", is}}}});
  };
  const auto [known, is_new] = processes_.try_emplace(process);
  Process& of = known->second;
  if (is_new) {
    of.number = static_cast<int>(processes_.size());
    name("process_name", of.number, 0, process);
  }
  const auto [found, is_new_thread] = of.threads.emplace(thread, static_cast<int>(of.threads.size()) + 1);
  if (is_new_thread) name("thread_name", of.number, found->second, thread);
  return {of.number, found->second};
}

void TraceWriter::span(Thread thread, const std::string& name, const std::string& category, double begin,
                       double duration, Json args) {
  put({{"name", name},
       {"cat", category},
       {"ph", "X"},
       {"pid", thread.process},
       {"tid", thread.thread},
       {"ts", begin},
       {"dur", duration},
       {"args", std::move(args)}});
}

void TraceWriter::mark(Thread thread, const std::string& name, const std::string& category, double t, Json args) {
  put({{"name", name},
       {"cat", category},
       {"ph", "i"},
       {"s", "t"},
       {"pid", thread.process},
       {"tid", thread.thread},
       {"ts", t},
       {"args", std::move(args)}});
}

void TraceWriter::figure(Thread thread, const std::string& name, double t, Json value) {
  put({{"name", name},
       {"ph", "C"},
       {"pid", thread.process},
       {"tid", thread.thread},
       {"ts", t},
       {"args", {{"value", std::move(value)}}}});
}

void TraceWriter::end(const Json& more) {
  out_ += "\n]";
  for (const auto& [key, value] : more.items()) out_ += ",\n" + json_text(key) + ':' + json_text(value);
  out_ += "}\n";
}

}  // namespace cxlab::lab
