#include "scenarios/rcll/rules/event.h"

#include <algorithm>
#include <concepts>
#include <type_traits>

namespace cxlab::rcll {

namespace {

class EventWriter {
 public:
  explicit EventWriter(RecordData& data) : data_(data) {}

  template <class Value>
  void operator()(std::string_view key, const std::optional<Value>& value) {
    if (value) (*this)(key, *value);
  }
  void operator()(std::string_view key, const std::array<double, 3>& value) {
    data_.field(key, std::span<const double>(value));
  }
  void operator()(std::string_view key, const std::string& value) { data_.field(key, std::string_view(value)); }
  template <class Word>
    requires std::is_enum_v<Word>
  void operator()(std::string_view key, Word value) {
    data_.field(key, to_string(value));
  }
  template <class Number>
    requires std::is_arithmetic_v<Number>
  void operator()(std::string_view key, Number value) {
    data_.field(key, value);
  }
  template <class Value>
  void when(bool condition, std::string_view key, const Value& value) {
    if (condition) (*this)(key, value);
  }

 private:
  RecordData& data_;
};

class EventReader {
 public:
  explicit EventReader(const RecordValue& data) : data_(data) {}

  template <class Value>
  void operator()(std::string_view key, Value& value) {
    if (const RecordValue* found = data_.find(key)) take(*found, value);
  }
  template <class Value>
  void when(bool, std::string_view key, Value& value) {
    (*this)(key, value);
  }

 private:
  static void take(const RecordValue& found, std::string& out) {
    if (const auto* text = std::get_if<std::string>(&found.value)) out = *text;
  }
  static void take(const RecordValue& found, bool& out) {
    if (const auto* flag = std::get_if<bool>(&found.value)) out = *flag;
  }
  static void take(const RecordValue& found, double& out) {
    if (const auto* real = std::get_if<double>(&found.value)) out = *real;
    if (const auto* whole = std::get_if<std::int64_t>(&found.value)) out = static_cast<double>(*whole);
  }
  template <std::signed_integral Whole>
  static void take(const RecordValue& found, Whole& out) {
    if (const auto* whole = std::get_if<std::int64_t>(&found.value)) out = static_cast<Whole>(*whole);
  }
  template <class Word>
    requires std::is_enum_v<Word>
  static void take(const RecordValue& found, std::optional<Word>& out) {
    if (const auto* text = std::get_if<std::string>(&found.value)) out = named<Word>(*text);
  }
  template <class Word>
    requires std::is_enum_v<Word>
  static void take(const RecordValue& found, Word& out) {
    std::optional<Word> word;
    take(found, word);
    out = word.value_or(out);
  }
  template <class Value>
  static void take(const RecordValue& found, std::optional<Value>& out) {
    take(found, out.emplace());
  }
  static void take(const RecordValue& found, std::array<double, 3>& out) {
    const auto* list = std::get_if<RecordValue::List>(&found.value);
    for (std::size_t i = 0; list && i < std::min(out.size(), list->size()); ++i) take((*list)[i], out[i]);
  }

  const RecordValue& data_;
};

template <class One>
std::string_view event_word(const One& event) {
  if constexpr (One::kWords.size() > 1)
    return One::kWords[static_cast<std::size_t>(event.kind)];
  else
    return One::kWords.front();
}

/// Sets `out` if the word is one of that event.
template <class One>
bool read_as(std::string_view word, const RecordValue& data, std::optional<Event>& out) {
  const auto found = std::ranges::find(One::kWords, word);
  if (found == One::kWords.end()) return false;
  One event;
  if constexpr (One::kWords.size() > 1) event.kind = static_cast<typename One::Kind>(found - One::kWords.begin());
  EventReader reader(data);
  event.fields(reader);
  out = std::move(event);
  return true;
}

template <class... All>
std::optional<Event> read_any(std::string_view word, const RecordValue& data, const std::variant<All...>*) {
  std::optional<Event> out;
  (void)(read_as<All>(word, data, out) || ...);
  return out;
}

}  // namespace

const RecordData& write(Event event, RecordData& data) {
  std::visit(
      [&data](auto& one) {
        data.begin().field("event", event_word(one));
        EventWriter writer(data);
        one.fields(writer);
      },
      event);
  return data;
}

std::optional<Event> read_event(const RecordValue& data) {
  return read_any(data.text("event"), data, static_cast<const Event*>(nullptr));
}

void RecordedClock::apply(SimTime t, const Event& event) {
  std::visit(Cases{[&](const Prolonged& e) { game.production_end = game.at(e.until); },
                   [&](const PhaseBegan& e) {
                     if (e.phase == Phase::kPostGame) game.production_end = floor.at(t);
                   },
                   [&](const PhaseWasSet&) {
                     if (phase(t) == Phase::kSetup) game.begin_production(floor.at(t));
                   },
                   [&](const PauseChanged& e) {
                     if (e.state == GameState::kPaused)
                       floor.halt(t);
                     else
                       floor.go_on(t);
                   },
                   [](const auto&) {}},
             event);
}

SimTime RecordedClock::when(double production_s) const {
  const SimTime at = floor.when(game.at(production_s));
  return at == kNever ? game.at(production_s) : at;
}

}  // namespace cxlab::rcll
