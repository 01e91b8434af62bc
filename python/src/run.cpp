// Recorded runs: tables that are read without playing any rules. Questions that play rules are asked of `cxlab ask`, a
// process of its own that confines itself (python/cxlab/_asking.py).

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bindings.h"
#include "cx/base/json.h"
#include "cx/journal/journal_reader.h"
#include "lab/export/arrow_tables.h"
#include "lab/export/story_tables.h"
#include "lab/run.h"
#include "lab/scene_answer.h"
#include "lab/world_answer.h"

namespace cxlab::python {

namespace {

using Seconds = std::optional<double>;

std::optional<SimTime> time_of(const Seconds& seconds) {
  return seconds ? std::optional(from_seconds(*seconds)) : std::nullopt;
}

/// The same error, with the names that the options of the program have here.
Error with_arguments(Error error) {
  for (const auto& [option, argument] :
       {std::pair<std::string_view, std::string_view>{"--at", "at"}, {"--from", "start"}, {"--to", "end"}})
    for (auto at = error.message.find(option); at != std::string::npos; at = error.message.find(option))
      error.message.replace(at, option.size(), argument);
  return error;
}

/// A table for `__arrow_c_stream__`, and why reading it failed.
class TableSource {
 public:
  explicit TableSource(lab::ArrowTable table) : table_(std::move(table)) {}
  explicit TableSource(lab::PlainTable table)
      : TableSource(lab::arrow_table(std::make_shared<const lab::PlainTable>(std::move(table)))) {}

  nb::capsule stream() const {
    auto stream = std::make_unique<ArrowArrayStream>();
    lab::make_arrow_stream(*stream, table_.columns, value_or_raise(table_.begin()),
                           [failure = failure_](const Error& error) { *failure = error; });
    return nb::capsule(stream.release(), "arrow_array_stream", [](void* given) noexcept {
      auto* unread = static_cast<ArrowArrayStream*>(given);
      if (unread->release) unread->release(unread);  // who has read it cleared this
      delete unread;
    });
  }
  void check() const {
    if (const auto error = std::exchange(*failure_, std::nullopt)) raise(*error);
  }

 private:
  lab::ArrowTable table_;
  std::shared_ptr<std::optional<Error>> failure_ = std::make_shared<std::optional<Error>>();
};

class RecordedRun {
 public:
  explicit RecordedRun(const std::string& folder)
      : run_(std::make_shared<const lab::Run>(value_or_raise(lab::Run::open(folder)))) {}

  std::string folder() const { return run_->folder.string(); }
  nb::object result() const { return from_json(run_->result); }
  bool finished() const { return run_->finished; }
  double end_s() const { return to_seconds(run_->sim_time); }

  nb::list questions() const {
    nb::list out;
    for (const WorldQuestion& question : value_or_raise(run_->scenario()).world.kind->questions)
      out.append(nb::make_tuple(text(question.name), text(question.what), text(question.argument)));
    return out;
  }

  TableSource records(const std::vector<std::string>& kinds, const std::string& stream, const Seconds& start,
                      const Seconds& end) const {
    RecordFilter filter{.stream = stream};
    for (const std::string& word : kinds) {
      const auto kind = record_kind(word);
      if (!kind) raise(unknown_kind(word));
      filter.kinds.push_back(*kind);
    }
    if (run_->finished && !stream.empty() && !run_->stream_hashes.contains(stream)) {
      std::vector<std::string> known;
      for (const auto& [name, hash] : run_->stream_hashes) known.push_back(name);
      raise(input_error("the run has no stream '" + stream + "'; it has " + some_of_and_nearest(stream, known, 10)));
    }
    const lab::Stretch stretch = stretch_of(start, end);
    filter.from = stretch.from;
    filter.to = stretch.to;
    return TableSource(lab::arrow_records(run_, filter));
  }

  nb::tuple story(const Seconds& start, const Seconds& end) const {
    lab::StoryTables tables(stretch_of(start, end));
    Status passed;
    {
      const nb::gil_scoped_release unlocked;
      lab::PassListener* const listeners[]{&tables};
      passed = lab::pass_over(*run_, stretch_of(start, end), listeners, {});
    }
    python::check(passed);
    return nb::make_tuple(TableSource(tables.skills()), TableSource(tables.points()));
  }

  nb::dict ask(const std::string& question, const std::string& about, const Seconds& at, const Seconds& from,
               const Seconds& to) const {
    auto asked = [&] {
      const nb::gil_scoped_release unlocked;
      return lab::ask_world(*run_, {question, about, time_of(at), time_of(from), time_of(to)});
    }();
    if (!asked) raise(with_arguments(asked.error()));
    const lab::WorldAnswered& answered = *asked;
    nb::dict out;
    out["at_s"] = to_seconds(answered.to);
    out["from_s"] = to_seconds(answered.from);
    out["cut_off"] = !answered.cut_off.empty();
    nb::dict tables;
    for (const Table& table : answered.answer.tables)
      tables[text(table.key)] = nb::cast(TableSource(lab::plain_table(table)));
    out["tables"] = tables;
    nb::list notes;
    for (const std::string& note : answered.answer.notes) notes.append(text(note));
    out["notes"] = notes;
    return out;
  }

  nb::object scene(const Seconds& at, const std::string& what) const {
    auto seen = run_->scene(time_of(at));
    if (!seen) raise(lab::about_option(seen.error(), "at"));
    return from_json(json_text(value_or_raise(lab::scene_json(*std::move(seen), what))));
  }

 private:
  static Error unknown_kind(const std::string& word) {
    std::vector<std::string> known;
    for (int i = 0; i <= static_cast<int>(RecordKind::kError); ++i)
      known.emplace_back(to_string(static_cast<RecordKind>(i)));
    return usage_error("kind: " + found_text(word, "one of " + some_of_and_nearest(word, known)));
  }

  lab::Stretch stretch_of(const Seconds& start, const Seconds& end) const {
    lab::Stretch out;
    for (const auto& [time, name] : {std::pair{start, "start"}, std::pair{end, "end"}})
      if (time)
        if (Status s = run_->reaches(from_seconds(*time)); !s) raise(lab::about_option(s.error(), name));
    if (start && end && *start > *end) raise(usage_error("start is after end"));
    out.from = time_of(start).value_or(out.from);
    out.to = time_of(end).value_or(out.to);
    return out;
  }

  std::shared_ptr<const lab::Run> run_;
};

}  // namespace

void bind_run(nb::module_& module) {
  nb::class_<TableSource>(module, "TableSource", "A table that is read as an Arrow stream, any number of times.")
      .def(
          "__arrow_c_stream__", [](const TableSource& source, const nb::object&) { return source.stream(); },
          nb::arg("requested_schema") = nb::none())
      .def("check", &TableSource::check, "Raises why the last reading failed, if it did.");
  nb::class_<RecordedRun>(module, "RecordedRun", "The folder of a run, opened.")
      .def(nb::init<const std::string&>(), nb::arg("folder"))
      .def_prop_ro("folder", &RecordedRun::folder)
      .def_prop_ro("result", &RecordedRun::result)
      .def_prop_ro("finished", &RecordedRun::finished)
      .def_prop_ro("end_s", &RecordedRun::end_s)
      .def("questions", &RecordedRun::questions)
      .def("records", &RecordedRun::records, nb::arg("kinds"), nb::arg("stream"), nb::arg("start").none(),
           nb::arg("end").none())
      .def("story", &RecordedRun::story, nb::arg("start").none(), nb::arg("end").none())
      .def("ask", &RecordedRun::ask, nb::arg("question"), nb::arg("about"), nb::arg("at").none(),
           nb::arg("start").none(), nb::arg("end").none())
      .def("scene", &RecordedRun::scene, nb::arg("at").none(), nb::arg("what"));
}

}  // namespace cxlab::python
