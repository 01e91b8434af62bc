#include "lab/moment_facts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "cx/explain/names.h"
#include "cx/explain/pattern.h"
#include "cx/plugins/ros_msgs/message_store.h"
#include "cx/testing/story_parts.h"

namespace cxlab::lab {

namespace {

constexpr const char *kOpenClient = "(ros-msgs-client (service ",
                     *kOpenActionClient = "(ros-msgs-action-client (server ";

/// An expression that opens what this fact of the generic plugin says is open; empty for other facts.
std::string call_that_opens(const std::string& fact) {
  static const std::pair<const char*, const char*> kOpened[] = {{"(ros-msgs-subscription (topic ", "subscription"},
                                                                {"(ros-msgs-publisher (topic ", "publisher"},
                                                                {kOpenClient, "client"},
                                                                {kOpenActionClient, "action-client"}};
  for (const auto& [begin, kind] : kOpened) {
    if (!fact.starts_with(begin)) continue;
    std::string arguments = fact.substr(std::strlen(begin));
    if (const std::size_t type = arguments.find(") (type "); type != std::string::npos)
      arguments.replace(type, std::strlen(") (type "), " ");
    if (arguments.ends_with("))")) arguments.pop_back();
    return std::string("(ros-msgs-create-") + kind + ' ' + arguments;
  }
  return {};
}

std::string global_of(Handle message) { return testing::global_of_story("message", static_cast<std::size_t>(message)); }

/// CLIPS prints 15 digits: a number that needs more has all of them.
std::string with_all_digits(double number) {
  const std::string text = print_float(number);
  if (!std::isfinite(number) || read_number<double>(text) == number) return text;
  const std::string whole = general_text(number, 17);
  return whole.find_first_of(".e") == std::string::npos ? whole + ".0" : whole;
}

/// The value as a story has to write it.
Value with_all_digits(const Value& value) {
  if (value.is(ValueType::kFloat)) return Value::symbol(with_all_digits(value.as_number()));
  if (!value.is(ValueType::kMultifield)) return value;
  std::vector<Value> items;
  for (const Value& item : value.items()) items.push_back(with_all_digits(item));
  return Value::multifield(std::move(items));
}

FactCopy with_all_digits(FactCopy fact) {
  for (auto& [name, value] : fact.slots) value = with_all_digits(value);
  return fact;
}

/// Calls that make a message by the functions of the generic plugin.
class MessageCalls {
 public:
  /// None if it has numbers that are none, or too many values to write them down.
  static std::vector<std::string> that_make(const bus::MessageView& message, const std::string& global) {
    MessageCalls made;
    made.create(global, message.type());
    made.set_fields(message, global);
    return made.can_be_made_ ? std::move(made.calls_) : std::vector<std::string>();
  }

 private:
  static constexpr std::size_t kMostValues = 10'000;

  void create(const std::string& global, const bus::MessageType& type) {
    calls_.push_back("(defglobal " + global + " = (ros-msgs-create-message \"" + type.name() + "\"))");
  }

  /// Those that a new message has otherwise. `place` is an expression.
  void set_fields(const bus::MessageView& message, const std::string& place) {
    const bus::Message fresh(message.type());
    for (const bus::Field& field : message.type().fields()) {
      const std::string here = place + " \"" + field.name + '"';
      if (field.array != bus::ArrayKind::kSingle && (values_ += message.size(field)) > kMostValues)
        can_be_made_ = false;
      if (!can_be_made_) return;
      if (field.is_message()) {
        set_messages(message, field, here);
      } else if (const std::string values = values_of(message, field); values != values_of(fresh.view(), field)) {
        calls_.push_back("(ros-msgs-set-field " + here + ' ' + values + ')');
      }
    }
  }

  /// The parts of a message are there with it, but for those of an array without a fixed size: copies of a new one.
  void set_messages(const bus::MessageView& message, const bus::Field& field, const std::string& here) {
    const std::size_t size = message.size(field);
    if (field.is_sequence() && size > 0) {
      const std::string part = testing::global_of_story("part", 1);
      create(part, *field.nested);
      std::string parts;
      for (std::size_t i = 0; i < size; ++i) parts += ' ' + part;
      calls_.push_back("(ros-msgs-set-field " + here + " (create$" + parts + "))");
      calls_.push_back("(ros-msgs-destroy-message " + part + ')');
    }
    const std::string got = "(ros-msgs-get-field " + here + ')';
    for (std::size_t i = 0; i < size; ++i)
      set_fields(message.nested(field, i),
                 field.array == bus::ArrayKind::kSingle ? got : "(nth$ " + std::to_string(i + 1) + ' ' + got + ')');
  }

  std::string values_of(const bus::MessageView& message, const bus::Field& field) {
    if (field.array == bus::ArrayKind::kSingle) return value_of(message, field, 0);
    std::string out = "(create$";
    for (std::size_t i = 0; i < message.size(field); ++i) out += ' ' + value_of(message, field, i);
    return out + ')';
  }

  std::string value_of(const bus::MessageView& message, const bus::Field& field, std::size_t index) {
    if (field.is_text()) return Value::string(message.text(field, index)).print();
    if (field.type == bus::FieldType::kBool) return Value::boolean(message.integer(field, index) != 0).print();
    if (!field.is_real()) return Value::integer(message.integer(field, index)).print();
    const double number = message.real(field, index);
    if (!std::isfinite(number)) can_be_made_ = false;
    return with_all_digits(number);
  }

  std::vector<std::string> calls_;
  std::size_t values_ = 0;
  bool can_be_made_ = true;
};

/// Calls `visit` for each pointer to a message or goal that the fact has.
template <class Visit>
void for_each_handle(const FactCopy& fact, Visit visit) {
  for (const auto& [name, value] : fact.slots) {
    if (value.is(ValueType::kHandle)) visit(value);
    for (const Value& item : value.items())
      if (item.is(ValueType::kHandle)) visit(item);
  }
}

/// The names of the facts to which this one points: "<Fact-12>".
std::vector<std::string> facts_named_in(const std::string& fact) {
  std::vector<std::string> out;
  for (std::size_t at = 0; (at = fact.find("<Fact-", at)) != std::string::npos; ++at)
    out.push_back(fact.substr(at, fact.find('>', at) + 1 - at));
  return out;
}

std::string name_of(const FactCopy& fact) { return "<Fact-" + std::to_string(fact.index) + '>'; }

/// The values of a slot in an expression that CLIPS does not check before it evaluates it.
std::string unchecked(const Value& value) {
  if (!value.is(ValueType::kMultifield)) return "(nth$ 1 (create$ " + value.print() + "))";
  std::string items;
  for (const Value& item : value.items()) items += ' ' + item.print();
  return "(create$" + items + ')';
}

/// What asserts a fact whose template does not allow its values. Null pointers are left to the default.
std::string expression_of(const FactCopy& fact, const RuleEngine& engine) {
  const std::string begin = '(' + fact.template_name;
  std::string out = begin;
  for (const auto& [name, value] : fact.slots) {
    FactCopy alone = fact;
    alone.slots = {{name, value}};
    const std::string text = alone.print();
    const bool is_null = value.is(ValueType::kHandle) && value.as_handle() == Handle::kNone;
    if (is_null && !has_allowed_values(begin + " (" + name + " nil))", engine)) continue;
    out += has_pointer(text) || has_allowed_values(text, engine)
               ? text.substr(begin.size(), text.size() - begin.size() - 1)
               : " (" + name + ' ' + unchecked(value) + ')';
  }
  return out + ')';
}

}  // namespace

std::string yaml_quoted(const std::string& text) {
  // Line ends and their like would become blanks.
  if (std::ranges::any_of(text, [](char c) { return static_cast<unsigned char>(c) < ' '; }))
    return json_text(Json(text));
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + '\'';
}

bool has_pointer(const std::string& fact) {
  return fact.find("<Pointer-") != std::string::npos || fact.find("<Fact-") != std::string::npos;
}

bool has_allowed_values(const std::string& fact, const RuleEngine& engine) {
  const auto pattern = explain::Pattern::parse_plain(fact, "", 0);
  return pattern && explain::check_values(*pattern, engine, {}).ok();
}

void MomentFacts::begin(const RuleEngine& engine) {
  at_the_start_.clear();
  for (const auto& [global, value] : engine.globals()) at_the_start_[global] = value.print();
  for (const FactCopy& fact : engine.facts()) at_the_start_[fact.print()];
}

void MomentFacts::hear(const JournalRecord& record) {
  if (record.kind == RecordKind::kAssert || record.kind == RecordKind::kModify)
    changed_[record.data.integer("fact")] = record.n;
}

/// In the order of their last changes: among activations that are else equal, it decides. A fact to which another one
/// points stands before it.
std::vector<FactCopy> MomentFacts::in_order(std::vector<FactCopy> facts) const {
  std::ranges::stable_sort(facts, {}, [this](const FactCopy& fact) {
    const auto changed = changed_.find(static_cast<std::int64_t>(fact.number));
    return changed == changed_.end() ? 0 : changed->second;
  });
  std::map<std::string, const FactCopy*> by_name;
  for (const FactCopy& fact : facts) by_name[name_of(fact)] = &fact;
  std::vector<FactCopy> out;
  std::set<const FactCopy*> taken;
  const auto take = [&](const auto& self, const FactCopy& fact) -> void {
    if (!taken.insert(&fact).second) return;
    for (const std::string& name : facts_named_in(fact.print()))
      if (const auto to = by_name.find(name); to != by_name.end()) self(self, *to->second);
    out.push_back(fact);
  };
  for (const FactCopy& fact : facts) take(take, fact);
  return out;
}

void MomentFacts::read(cx::Environment& environment, const MomentExchanges& exchanges) {
  RuleEngine& engine = environment.engine();
  const std::vector<FactCopy> facts = in_order(engine.facts());
  for (const FactCopy& fact : facts) {
    if (fact.print().starts_with("(ros-msgs-")) of_plugin_.push_back(fact.print());
    const Value* server = fact.slot("server");
    if (server && fact.template_name.ends_with("-client")) bound_.push_back(server->text());
  }
  std::vector<std::string> handles;  // of goals that the story sends
  for (const auto& [name, goals] : exchanges.actions())
    for (const Exchange& goal : goals)
      if (!goal.handle.empty() && has_action_client(name)) handles.push_back(goal.handle);
  for (const FactCopy& fact : facts) {
    const FactCopy whole = with_all_digits(fact);
    const std::string text = fact.print(), plain = whole.print();
    if (text == "(initial-fact)") continue;
    const bool is_checked =
        (fact.slots.size() == 1 && fact.slots[0].first == "implied") || has_allowed_values(text, engine);
    const std::string expression =
        with_messages(fact, is_checked ? plain : expression_of(whole, engine), environment.common<cx::MessageStore>());
    if (const std::string why = what_it_lacks(expression, handles); why.empty())
      given_.push_back({text, name_of(fact), expression, expression != plain});
    else
      lost_.push_back("left out, because " + why + ": " + text);
  }
  for (const FactCopy& fact : engine.facts_not_supported_when_settled())
    lost_.push_back("stays when the facts go from which it follows, because its rule computes it: " + fact.print());
  for (const auto& [name, goals] : exchanges.actions())
    if (!has_action_client(name) && exchanges.any_under_way(goals))
      lost_.push_back(name + " has a goal from before, and no client any more: how it ends is not in the story");
  for (const auto& [name, requests] : exchanges.services())
    if (!has_client(name) && exchanges.any_under_way(requests))
      lost_.push_back(name + " has a request from before, sent through a binding: its answer is not in the story");
  for (const auto& [global, value] : engine.globals())
    if (!global.starts_with(testing::kGlobalOfStory)) read_global(global, value, environment);
  note_next_symbol(engine);
  if (const std::size_t waiting = engine.agenda().size(); waiting > 0)
    lost_.push_back(std::to_string(waiting) + " rules were on the agenda without their turn: a story forgets them");
}

/// Changed globals are set, and those that were defined after the start are defined.
void MomentFacts::read_global(const std::string& global, const Value& value, cx::Environment& environment) {
  const auto then = at_the_start_.find(global);
  const bool is_new = then == at_the_start_.end();
  if (!is_new && then->second == value.print()) return;
  const std::string name = "?*" + global + '*';
  const std::string whole = with_all_digits(value).print();
  const std::string text = with_messages({0, 0, {}, {}, {{global, value}}},
                                         value.is(ValueType::kMultifield) ? "(create$ " + whole.substr(1) : whole,
                                         environment.common<cx::MessageStore>());
  if (has_pointer(text))
    lost_.push_back("not set, because a story cannot make the message, goal or fact to which it points: " + name);
  else
    globals_.push_back(is_new ? "(defglobal " + name + " = " + text + ')' : "(bind " + name + ' ' + text + ')');
}

/// `gensym` goes on where it was: `setgen` takes back that it was asked.
void MomentFacts::note_next_symbol(RuleEngine& engine) {
  const auto next = engine.eval("(gensym)");
  if (!next || !next->print().starts_with("gen")) return;
  const std::string set = "(setgen " + next->print().substr(3) + ")";
  if (engine.eval(set) && set != "(setgen 1)") setgen_ = set;
}

/// The text with globals in the place of messages that the story can make.
std::string MomentFacts::with_messages(const FactCopy& fact, std::string text, const cx::MessageStore& store) {
  for_each_handle(fact, [&](const Value& handle) {
    const bus::MessageView message = store.view(handle.as_handle());
    if (!message) return;
    const std::string global = global_of(handle.as_handle()), pointer = handle.print();
    const std::vector<std::string> calls = MessageCalls::that_make(message, global);
    if (calls.empty()) return;
    messages_[handle.as_handle()] = calls;
    for (std::size_t at = 0; (at = text.find(pointer, at)) != std::string::npos; at += global.size())
      text.replace(at, pointer.size(), global);
  });
  return text;
}

/// Why a fact that points to something cannot be given; empty if it can.
std::string MomentFacts::what_it_lacks(const std::string& fact, const std::vector<std::string>& handles) {
  std::string text = fact;
  for (const std::string& handle : handles)
    for (std::size_t at; (at = text.find(handle)) != std::string::npos;) text.erase(at, handle.size());
  if (text.find("<Pointer-") != std::string::npos) return "a story cannot make the message or goal to which it points";
  std::vector<Given*> named;
  for (const std::string& name : facts_named_in(text)) {
    const auto found = std::ranges::find(given_, name, &Given::name);
    if (found == given_.end()) return "the fact to which it points is not given before it";
    named.push_back(&*found);
  }
  for (Given* one : named) one->is_named = true;
  return {};
}

std::string MomentFacts::given() const {
  std::string out;
  for (const auto& [text, name, expression, is_named] : given_) {
    const std::string fact = yaml_quoted(expression);
    out += "    - " + (is_named ? "{fact: " + fact + ", as: " + yaml_quoted(name) + '}' : fact) + '\n';
  }
  return out;
}

/// They open what rules had opened after the start, and set what had changed by then.
std::string MomentFacts::calls() const {
  std::string out;
  for (const Given& fact : given_)
    if (const std::string call = call_that_opens(fact.text); !call.empty() && !at_the_start_.contains(fact.text))
      out += "    - " + yaml_quoted(call) + '\n';
  for (const auto& [message, made] : messages_)
    for (const std::string& call : made) out += "    - " + yaml_quoted(call) + '\n';
  if (!setgen_.empty()) out += "    - " + yaml_quoted(setgen_) + '\n';
  for (const std::string& call : globals_) out += "    - " + yaml_quoted(call) + '\n';
  return out;
}

std::vector<std::string> MomentFacts::texts() const {
  std::vector<std::string> out;
  for (const Given& fact : given_) out.push_back(fact.text);
  return out;
}

bool MomentFacts::has_open(const std::string& begin, const std::string& name) const {
  return std::ranges::any_of(of_plugin_, [&](const std::string& fact) {
    return fact.starts_with(begin + '"' + name + '"') || fact.starts_with(begin + '"' + name.substr(1) + '"');
  });
}

bool MomentFacts::has_action_client(const std::string& name) const {
  return has_open(kOpenActionClient, name) || std::ranges::find(bound_, name) != bound_.end();
}
bool MomentFacts::has_client(const std::string& service) const { return has_open(kOpenClient, service); }

std::string MomentFacts::as_written(const std::string& name) const {
  const std::string relative = '"' + name.substr(1) + '"';
  const auto has = [&](const std::string& fact) { return fact.find(relative) != std::string::npos; };
  return std::ranges::any_of(of_plugin_, has) ? name.substr(1) : name;
}

}  // namespace cxlab::lab
