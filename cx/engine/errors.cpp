// Makes errors with rule, file and line from the messages that CLIPS prints on stderr.

#include <algorithm>
#include <cctype>
#include <functional>

#include "internal/impl.h"

namespace cxlab {

constinit thread_local RuleEngine* g_at_work = nullptr;

namespace {

using namespace clips;

/// "DRIVE1" of "[DRIVE1] This error ...", or empty.
std::string_view code_of(std::string_view line) {
  if (line.size() < 4 || line[0] != '[') return {};
  const std::size_t close = line.find(']');
  if (close == std::string_view::npos || close < 3) return {};
  const std::string_view code = line.substr(1, close - 1);
  if (!std::isupper(static_cast<unsigned char>(code.front())) || !std::isdigit(static_cast<unsigned char>(code.back())))
    return {};
  for (const char c : code) {
    if (!std::isupper(static_cast<unsigned char>(c)) && !std::isdigit(static_cast<unsigned char>(c))) return {};
  }
  return code;
}

bool is_network_message(std::string_view code) { return code == "DRIVE1" || code == "FACTMCH1" || code == "OBJRTMCH1"; }

struct Message {
  std::string code;
  std::string head;  ///< its first sentence
  std::string text;
  int line = 0;  ///< being parsed when it began
  bool acting = false;
  std::vector<std::string> rules;
  std::string read;  ///< see MessageStart
  RuleEngine::Impl::CallPlace call;
};

/// Its first line; a sentence of CLIPS that goes on in the next line is taken whole.
std::string head_of(const std::string& text) {
  const std::size_t end = text.find('\n');
  std::string head = text.substr(0, end);
  while (head.ends_with(' ')) head.pop_back();
  if (end == std::string::npos || head.ends_with('.') || head.starts_with("[CXLAB")) return head;
  const std::string next = text.substr(end + 1, text.find('\n', end + 1) - end - 1);
  return next.empty() ? head : head + ' ' + next;
}

void add_once(std::vector<std::string>& names, std::string name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(std::move(name));
}

/// The rules named by "Of pattern #2 in rule go", each once.
std::vector<std::string> rules_named(const std::string& text) {
  static constexpr std::string_view kBefore = " in rule ";
  std::vector<std::string> names;
  for (std::size_t at = text.find(kBefore); at != std::string::npos; at = text.find(kBefore, at)) {
    at += kBefore.size();
    add_once(names, text.substr(at, text.find_first_of(" \n", at) - at));
  }
  return names;
}

/// The rules that are activated at this join or behind it, with their modules.
void add_rules_below(const joinNode& join, std::vector<std::string>& rules) {
  if (join.ruleToActivate != nullptr)
    add_once(rules, DefruleModule(join.ruleToActivate) + ("::" + std::string(DefruleName(join.ruleToActivate))));
  for (const joinLink* link = join.nextLinks; link != nullptr; link = link->next) add_rules_below(*link->join, rules);
}

/// The texts of a message in single quotes.
std::vector<std::string> quoted_words(const std::string& message) {
  std::vector<std::string> names;
  for (std::size_t at = message.find('\''); at != std::string::npos; at = message.find('\'', at + 1)) {
    const std::size_t end = message.find('\'', at + 1);
    if (end == std::string::npos) break;
    names.push_back(message.substr(at + 1, end - at - 1));
    at = end;
  }
  return names;
}

/// The captured text, cut into messages.
std::vector<Message> take_messages(RuleEngine::Impl& impl) {
  std::vector<Message> messages;
  for (std::size_t i = 0; i < impl.starts.size(); ++i) {
    const auto& start = impl.starts[i];
    const std::size_t end = i + 1 < impl.starts.size() ? impl.starts[i + 1].at : impl.captured.size();
    Message message;
    message.text = impl.captured.substr(start.at, end - start.at);
    message.head = head_of(message.text);
    message.line = start.line;
    message.acting = start.acting;
    message.read = start.read;
    message.rules = start.rules;
    message.call = start.call;
    message.code = code_of(message.head);
    if (!message.code.empty())
      messages.push_back(std::move(message));
    else if (!messages.empty())
      messages.back().text += message.text;
  }
  impl.captured.clear();
  impl.starts.clear();
  return messages;
}

template <class Look>
void in_each_module(Environment* env, const Look& look) {
  Defmodule* const current = GetCurrentModule(env);
  for (Defmodule* module = GetNextDefmodule(env, nullptr); module != nullptr; module = GetNextDefmodule(env, module)) {
    SetCurrentModule(env, module);
    look();
  }
  SetCurrentModule(env, current);
}

/// The names of all deftemplates that were defined.
std::vector<std::string> known_templates(Environment* env) {
  std::vector<std::string> names;
  in_each_module(env, [&] {
    for (Deftemplate* t = GetNextDeftemplate(env, nullptr); t != nullptr; t = GetNextDeftemplate(env, t))
      if (!t->implied) names.emplace_back(t->header.name->contents);
  });
  return names;
}

std::vector<std::string> known_functions(Environment* env) {
  std::vector<std::string> names;
  for (const FunctionDefinition* f = GetFunctionList(env); f != nullptr; f = f->next)
    names.emplace_back(f->callFunctionName->contents);
  in_each_module(env, [&] {
    for (Deffunction* f = GetNextDeffunction(env, nullptr); f != nullptr; f = GetNextDeffunction(env, f))
      names.emplace_back(f->header.name->contents);
    for (Defgeneric* f = GetNextDefgeneric(env, nullptr); f != nullptr; f = GetNextDefgeneric(env, f))
      names.emplace_back(f->header.name->contents);
  });
  return names;
}

/// The slots of all deftemplates of that name.
std::vector<std::string> slots_of_template(Environment* env, const std::string& name) {
  std::vector<std::string> slots;
  in_each_module(env, [&] {
    for (Deftemplate* t = GetNextDeftemplate(env, nullptr); t != nullptr; t = GetNextDeftemplate(env, t))
      for (const templateSlot* slot = t->header.name->contents == name && !t->implied ? t->slotList : nullptr;
           slot != nullptr; slot = slot->next)
        slots.emplace_back(slot->slotName->contents);
  });
  return slots;
}

std::vector<std::string> slots_of_classes(Environment* env) {
  std::vector<std::string> slots;
  in_each_module(env, [&] {
    for (Defclass* c = GetNextDefclass(env, nullptr); c != nullptr; c = GetNextDefclass(env, c))
      for (unsigned i = 0; i < c->instanceSlotCount; ++i)
        slots.emplace_back(c->instanceTemplate[i]->slotName->name->contents);
  });
  return slots;
}

std::vector<std::string> known_modules(Environment* env) {
  std::vector<std::string> names;
  in_each_module(env, [&] { names.emplace_back(DefmoduleName(GetCurrentModule(env))); });
  return names;
}

/// The head of a fact whose first part is a list of that head: of a deftemplate that is not known, whose slot CLIPS
/// takes for a call. Searched in `(assert ...)` and `(deffacts ...)`.
std::string unknown_template(const Term& term, std::string_view part, const std::vector<std::string>& known) {
  if (!term.is_list()) return {};
  for (std::size_t i = 1; i < term.items.size(); ++i) {
    const Term& fact = term.items[i];
    const std::string head(fact.head());
    if ((term.head() == "assert" || term.head() == "deffacts") && fact.items.size() > 1 &&
        fact.items[1].head() == part && std::find(known.begin(), known.end(), head) == known.end())
      return head;
    if (std::string inner = unknown_template(fact, part, known); !inner.empty()) return inner;
  }
  return {};
}

/// The head of the first pattern with slots whose deftemplate is not known; conditions are searched up to "=>".
std::string unknown_pattern(const Term& term, const std::vector<std::string>& known) {
  static constexpr std::string_view kConditions[] = {"and", "or", "not", "exists", "forall", "logical"};
  static constexpr std::string_view kOthers[] = {"test", "declare", "object"};
  for (const Term& item : term.items) {
    if (item.is("=>")) break;
    const std::string head(item.head());
    if (head.empty() || std::ranges::find(kOthers, head) != std::end(kOthers)) continue;
    if (std::ranges::find(kConditions, head) != std::end(kConditions)) {
      if (std::string inner = unknown_pattern(item, known); !inner.empty()) return inner;
      continue;
    }
    const bool slots = item.items.size() > 1 && item.items[1].is_list();
    if (slots && std::find(known.begin(), known.end(), head) == known.end()) return head;
  }
  return {};
}

std::string with_nearest(const std::string& message, const std::string& word, const std::vector<std::string>& known) {
  const std::string near = did_you_mean(word, known);
  return near.empty() ? message : message.substr(0, message.find_last_not_of('.') + 1) + near;
}

/// The message with its remedy. It is "Module 'A' does not export any constructs.", "... any KIND constructs.", or "...
/// the KIND 'name'."
std::string with_export(const RuleEngine::Impl& impl, const std::string& message,
                        const std::vector<std::string>& names) {
  static constexpr std::string_view kBefore = " does not export ";
  const std::string rest = message.substr(std::min(message.find(kBefore) + kBefore.size() + 4, message.size()));
  const std::string kind = rest.substr(0, rest.find(' '));
  if (names.size() == 2) {
    std::vector<std::string> known;
    for (const auto& info : impl.constructs)
      if (info && info->kind == kind && info->module == names[0]) known.push_back(info->name);
    if (std::ranges::count(known, names[1]) == 0)
      return message + " There is no " + kind + " '" + names[1] + "' in it" + did_you_mean(names[1], known);
  }
  const std::string all =
      kind.starts_with("constructs") ? "?ALL" : kind + (names.size() == 2 ? ' ' + names[1] : " ?ALL");
  return message + " It does with (defmodule " + names[0] + " (export " + all + "))";
}

/// The message, with the name that is nearest to one that is not known, whatever form it stands in.
std::string with_near_name(const RuleEngine::Impl& impl, const std::string& message) {
  const std::vector<std::string> names = quoted_words(message);
  if (names.empty()) return message;
  if (message.starts_with("[TMPLTDEF1]") && names.size() == 2)
    return with_nearest(message, names[0], slots_of_template(impl.env, names[1]));
  if (message.starts_with("[OBJRTBLD2]")) {
    const std::vector<std::string> slots = slots_of_classes(impl.env);
    return std::ranges::count(slots, names[0]) > 0 ? message : with_nearest(message, names[0], slots);
  }
  if (message.starts_with("[PRNTUTIL1] Unable to find defmodule"))
    return with_nearest(message, names[0], known_modules(impl.env));
  return message.starts_with("[MODULPSR1]") ? with_export(impl, message, names) : message;
}

/// The message, with what a function that is missing should be: the nearest one, or the slot of a deftemplate that is
/// missing.
std::string with_remedy(Environment* env, const std::string& message, const Term& form) {
  const std::vector<std::string> names = quoted_words(message);
  if (message.starts_with("[PRNTUTIL2]") && form.head() == "defrule") {
    const std::vector<std::string> defined = known_templates(env);
    const std::string pattern = unknown_pattern(form, defined);
    return pattern.empty() ? message
                           : message + " There is no deftemplate '" + pattern + "'" + did_you_mean(pattern, defined);
  }
  if (!message.starts_with("[EXPRNPSR3]") || names.empty()) return message;
  const std::vector<std::string> templates = known_templates(env);
  const std::string fact = unknown_template(form, names.front(), templates);
  if (!fact.empty()) return message + " There is no deftemplate '" + fact + "'" + did_you_mean(fact, templates);
  return with_nearest(message, names.front(), known_functions(env));
}

/// A message about the network explains the one before it: a test of these rules failed, whoever changed the facts.
void add_network_errors(const RuleEngine::Impl& impl, const Message& message, std::vector<RuleError>& found) {
  RuleError failed;
  if (!found.empty() && found.back().side != ErrorSide::kLhs) {
    failed = std::move(found.back());
    found.pop_back();
  } else {
    // The network complains where the rules were stopped in the middle of a test: that is reported as what it is.
    const LimitsInUse* limits = impl.engine.options().limits;
    if (found.empty() && limits != nullptr && limits->exceeded) return;
    failed.message = found.empty() ? message.head : found.back().message;
  }
  failed.detail += message.text;
  failed.side = ErrorSide::kLhs;
  // The network of patterns knows no join: there a name may stand for rules of several modules.
  std::vector<std::string> rules = message.rules.empty() ? rules_named(message.text) : message.rules;
  if (rules.empty()) rules.emplace_back();
  for (const std::string& rule : rules) {
    failed.rule = without_module(rule);
    failed.file.clear();
    failed.line = 0;
    std::vector<const ConstructInfo*> places = impl.named("defrule", rule);
    if (places.empty()) places.push_back(nullptr);
    for (const ConstructInfo* place : places) {
      impl.set_place(failed, place, {});
      found.push_back(failed);
    }
  }
}

/// Notes what CLIPS was busy with, of "[PRCCODE4] Execution halted during the actions of deffunction 'f'."
void add_call(const RuleEngine::Impl& impl, const std::string& head, RuleError& error) {
  static constexpr std::string_view kBefore = "the actions of ";
  const std::size_t at = head.find(kBefore);
  if (at == std::string::npos) return;
  std::string call = head.substr(at + kBefore.size());
  if (call.ends_with('.')) call.pop_back();
  const std::vector<std::string> names = quoted_words(call);
  if (names.empty() || call.starts_with("defrule") ||
      (error.side == ErrorSide::kCallback && names.front() == error.rule))
    return;
  if (call.starts_with("deffunction")) {
    call = "deffunction " + names.front();
    if (const ConstructInfo* info = impl.engine.find_construct("deffunction", names.front());
        info != nullptr && info->line > 0)
      call += " (" + info->file + ':' + std::to_string(info->line) + ')';
  }
  error.calls.push_back(std::move(call));
}

/// " (rule go -> deffunction f (a.clp:3) -> deffunction g (a.clp:1))", or nothing.
std::string chain_of(const RuleError& error) {
  if (error.calls.empty()) return {};
  std::string chain;
  if (error.side != ErrorSide::kLoad && !error.rule.empty())  // else the name of the construct that is read
    chain = (error.side == ErrorSide::kCallback ? "" : "rule ") + error.rule;
  constexpr std::size_t kShown = 5;  // at either end of a long one
  for (std::size_t i = error.calls.size(); i > 0; --i) {
    if (i > kShown && i + kShown <= error.calls.size()) {
      if (i == kShown + 1) chain += " -> " + std::to_string(error.calls.size() - 2 * kShown) + " more";
      continue;
    }
    chain += (chain.empty() ? "" : " -> ") + error.calls[i - 1];
  }
  return " (" + chain + ')';
}

}  // namespace

std::string_view to_string(ErrorSide side) {
  static constexpr std::string_view kWords[] = {"load", "LHS", "RHS", "callback"};
  return kWords[static_cast<std::size_t>(side)];
}

Error RuleError::error() const {
  std::string what;
  if (side != ErrorSide::kLoad && !(side == ErrorSide::kCallback && rule.empty())) {
    what = (side == ErrorSide::kCallback ? "" : "rule ") + rule + (rule.empty() ? "" : ", ") +
           std::string(to_string(side)) + ": ";
  }
  return Error{side == ErrorSide::kLoad ? ErrorKind::kInput : ErrorKind::kRun, what + message, file, line,
               side == ErrorSide::kLoad ? "" : "rule_error"};
}

std::string RuleError::text() const { return error().text(); }

bool RuleEngine::Impl::is_parsing() const {
  return !contexts.empty() && contexts.back().form != nullptr && (!rule_acting || contexts.size() > rule_depth) &&
         !command_line_data(env)->EvaluatingTopLevelCommand;
}

std::string RuleEngine::Impl::text_being_read() const {
  if (!asserted_text.empty()) return "(assert " + std::string(asserted_text) + ')';
  const bool loads = !contexts.empty() && contexts.back().form != nullptr;
  return std::string(loads ? std::string_view() : evaluated_text);
}

void RuleEngine::Impl::capture(const char* text) {
  // CLIPS opens each of its messages with a "[" of its own; what rules print comes in larger pieces.
  if (text[0] == '[' && text[1] == '\0') {
    MessageStart& start = starts.emplace_back();
    start = {captured.size(),   is_parsing() ? static_cast<int>(GetLineCount(env)) : 0,
             rule_acting,       {},
             text_being_read(), call_at_work()};
    if (const joinNode* join = engine_data(env)->GlobalJoin) add_rules_below(*join, start.rules);
  } else if (starts.empty()) {
    return;
  }
  captured += text;
}

std::string RuleEngine::Impl::rule_under_test() const {
  std::vector<std::string> rules;
  if (const joinNode* join = engine_data(env)->GlobalJoin) add_rules_below(*join, rules);
  return rules.empty() ? std::string() : rules.front();
}

void RuleEngine::note_error(const std::string& text) {
  impl_->capture("[");
  impl_->capture(text.c_str() + 1);
  // The test continues, and CLIPS will not say so.
  if (impl_->starts.back().rules.empty()) return;
  impl_->capture("[");
  impl_->capture("DRIVE1] In the join network\n");
}

void RuleEngine::Impl::make_errors() {
  const std::vector<Message> messages = take_messages(*this);
  const Context* context = contexts.empty() ? nullptr : &contexts.back();
  const std::string open_rule = std::string(rule_module) + "::" + std::string(rule_name);
  std::vector<RuleError> found;
  const auto acting_in = [&](const RuleError& error) -> const ConstructInfo* {
    if (error.side == ErrorSide::kRhs) return engine.find_construct("defrule", open_rule);
    if (error.side != ErrorSide::kCallback) return nullptr;
    const ConstructInfo* info = engine.find_construct("deffunction", error.rule);
    return info != nullptr ? info : engine.find_construct("defmethod", error.rule);
  };
  for (const Message& message : messages) {
    if (is_network_message(message.code)) {
      add_network_errors(*this, message, found);
      continue;
    }
    const bool halted = message.code == "PRCCODE4";
    const bool in_rule = rule_open && contexts.size() == rule_depth && (message.acting || halted);
    const bool same_form = !in_rule && context != nullptr && context->form != nullptr && !found.empty() &&
                           found.back().side == ErrorSide::kLoad;
    if ((halted || same_form) && !found.empty()) {
      RuleError& last = found.back();
      last.detail += message.text;
      if (halted) add_call(*this, message.head, last);
      // The function that failed was called by a deffunction, which the rule called.
      const ConstructInfo* info =
          in_rule && halted && last.side == ErrorSide::kRhs ? engine.find_construct("defrule", open_rule) : nullptr;
      if (info != nullptr && (last.line == 0 || last.line == info->line))
        last.line = message.call.where == CallPlace::Where::kHere ? line_of_call(*info, message.call)
                                                                  : line_of_error(*info, ErrorSide::kRhs, message.head);
      continue;
    }
    RuleError error;
    error.message = message.head;
    error.detail = message.text;
    error.side = in_rule ? ErrorSide::kRhs : context != nullptr ? context->side : ErrorSide::kCallback;
    if (in_rule) {
      error.rule = rule_name;
      set_place(error, acting_in(error), message.call);
    } else if (context != nullptr) {
      error.rule = context->name;
      error.file = context->file;
      error.line = context->line;
      if (context->form != nullptr && message.line >= context->line) error.line = message.line;
      if (error.file.empty()) set_place(error, acting_in(error), message.call);
    }
    if (!message.read.empty()) {
      Form form;
      form.text = message.read;
      error.message = with_remedy(env, message.head, tree_of(form));
    } else if (context != nullptr && context->form != nullptr) {
      error.message = with_remedy(env, message.head, tree_of(*context->form));
    }
    found.push_back(std::move(error));
  }
  for (RuleError& error : found) {
    if (const ConstructInfo* info = error.line == 0 ? acting_in(error) : nullptr; info != nullptr)
      error.line = error.calls.empty() ? line_of_error(*info, error.side, error.message) : info->line;
    error.message = with_near_name(*this, error.message) + chain_of(error);
    add_error(std::move(error));
  }
}

void RuleEngine::Impl::set_place(RuleError& error, const ConstructInfo* info, const CallPlace& call) const {
  if (info == nullptr) return;
  error.file = info->file;
  switch (call.where) {
    case CallPlace::Where::kHere: error.line = line_of_call(*info, call); break;
    case CallPlace::Where::kElsewhere: error.line = 0; break;  // a message that follows may name the call
    case CallPlace::Where::kUnknown: error.line = line_of_error(*info, error.side, error.message); break;
  }
}

RuleEngine::Impl::CallPlace RuleEngine::Impl::call_at_work() {
  Expression* root = nullptr;
  if (rule_acting && contexts.size() == rule_depth && engine_data(env)->ExecutingRule != nullptr)
    root = engine_data(env)->ExecutingRule->actions;
  else if (!rule_acting && !contexts.empty() && contexts.back().side == ErrorSide::kCallback)
    if (const Deffunction* function = FindDeffunction(env, std::string(contexts.back().name).c_str()))
      root = function->code;
  CallPlace place;
  const Expression* at = evaluation_data(env)->CurrentExpression;
  // Where calls never end, CLIPS is kept from naming them: the message has the name of the function.
  if (root == nullptr || at == nullptr || (calls > 0 && stack_is_full())) return place;
  // CLIPS keeps the actions of a construct in one array, each call before its arguments.
  const bool grouped =
      root->type == FCALL && root->functionValue->callFunctionName->contents == std::string_view("progn");
  const Expression* const first = grouped ? root->argList : root;
  const auto size = static_cast<std::size_t>(ExpressionSize(grouped ? root->argList : root));
  const std::less<> before;
  const auto in_it = [&](const Expression* e) { return !before(e, first) && before(e, first + size); };
  if (!in_it(at)) at = carried_out;
  place.where = CallPlace::Where::kElsewhere;
  if (first == nullptr || at == nullptr || !in_it(at)) return place;
  const Expression* action = first;
  const Expression* end = first + size;
  for (const Expression* next = first; next != nullptr; next = next->nextArg) {
    ++place.actions;
    if (before(at, next)) {
      if (end == first + size) end = next;
      continue;
    }
    action = next;
    place.action = place.actions - 1;
  }
  const auto is_call = [](const Expression& e) { return e.type == FCALL || e.type == PCALL || e.type == GCALL; };
  while (!is_call(*at) && at != action)
    --at;  // a variable: the call before it, which has it as an argument or is beside it
  if (!is_call(*at)) return place;
  place.where = CallPlace::Where::kHere;
  place.name = (at->type == FCALL ? at->functionValue->callFunctionName : at->constructValue->name)->contents;
  for (const Expression* e = action; e != end; ++e) {
    if (e->type != at->type || e->value != at->value) continue;
    if (e == at) place.call = place.calls;
    ++place.calls;
  }
  return place;
}

int RuleEngine::Impl::line_of_call(const ConstructInfo& info, const CallPlace& call) {
  if (info.line == 0) return 0;
  Form form;
  form.text = info.text;
  form.line = info.line;
  const Term construct = tree_of(form);
  // A deffunction has a name, perhaps a comment, and its parameters before its actions, a rule has "=>".
  std::size_t first = 2;
  if (construct.head() == "defrule")
    while (first < construct.items.size() && !construct.items[first].is("=>")) ++first;
  else if (construct.items.size() > 2 && !construct.items[2].is_list())
    ++first;
  ++first;
  if (construct.items.size() != first + call.actions) return info.line;
  const Term& action = construct.items[first + call.action];
  std::vector<int> lines;
  bool sorted = false;  // an assert has its slots in the order of the deftemplate
  const std::function<std::size_t(const Term&)> visit = [&](const Term& term) {
    std::size_t found = 0;
    if (!term.is_list()) return found;
    if (without_module(term.head()) == call.name) {
      lines.push_back(term.line);
      ++found;
    }
    for (const Term& item : term.items) found += visit(item);
    sorted = sorted || (term.head() == "assert" && found > 1);
    return found;
  };
  visit(action);
  return lines.size() == call.calls && !sorted ? lines[call.call] : action.line;
}

void RuleEngine::Impl::add_error(RuleError error) {
  error.t = engine.now();
  std::string key = error.rule + '\n' + error.file + '\n' + std::to_string(error.line) + '\n' +
                    std::string(to_string(error.side)) + '\n' + error.message;
  if (!known_errors.insert(key).second) {
    for (RuleError& known : engine.errors_) {
      if (known.rule == error.rule && known.file == error.file && known.line == error.line &&
          known.side == error.side && known.message == error.message) {
        ++known.count;
      }
    }
    return;
  }
  if (engine.options_.journal != nullptr) {
    const std::string file = engine.options_.files != nullptr && !error.file.empty()
                                 ? engine.options_.files->journal_name(error.file)
                                 : error.file;
    data.begin()
        .field("rule", error.rule)
        .field("file", file)
        .field("line", error.line)
        .field("side", to_string(error.side))
        .field("message", error.message);
    write(RecordKind::kError);
  }
  engine.errors_.push_back(std::move(error));
}

int RuleEngine::Impl::line_of_error(const ConstructInfo& info, ErrorSide side, const std::string& message) const {
  if (info.line == 0) return 0;
  Form form;
  form.text = info.text;
  form.line = info.line;
  const std::vector<Token> tokens = tokens_of(form);
  std::size_t begin = 0;
  std::size_t end = tokens.size();
  if (side == ErrorSide::kLhs || side == ErrorSide::kRhs) {
    for (std::size_t i = 0; i < tokens.size(); ++i) {
      if (tokens[i].text != "=>" || tokens[i].kind != Token::Kind::kWord) continue;
      (side == ErrorSide::kLhs ? end : begin) = i;
      break;
    }
  }
  for (const std::string& name : quoted_words(message)) {
    int line = 0;
    int places = 0;
    for (std::size_t i = begin + 1; i < end; ++i) {
      if (tokens[i].text != name || tokens[i - 1].kind != Token::Kind::kOpen) continue;
      if (tokens[i].line != line) ++places;
      line = tokens[i].line;
    }
    if (places == 1) return line;
  }
  return info.line;
}

void RuleEngine::Impl::close_rule() {
  if (!rule_open) return;
  flush_errors();
  rule_open = false;
  rule_acting = false;
}

std::vector<RuleError> RuleEngine::take_errors() {
  impl_->flush_errors();
  if (errors_.empty()) return {};
  impl_->known_errors.clear();
  return std::exchange(errors_, {});
}

HostCall::HostCall(RuleEngine::Impl& impl, const RuleEngine::Impl::Context& context, Collect collect)
    : impl_(impl),
      embedded_(evaluation_data(impl.env)->CurrentExpression == nullptr),
      collect_(collect),
      outer_(std::exchange(g_at_work, &impl.engine)) {
  impl.flush_errors();
  depth_ = impl.contexts.size();
  if (embedded_ || context.side == ErrorSide::kLoad) impl.contexts.push_back(context);
  if (embedded_) {
    ResetErrorFlags(impl.env);
    impl.turns = 0;
    impl.begin_act();
    impl.reads_at_end = 0;
  } else {
    GCBlockStart(impl.env, &block_);
  }
}

HostCall::~HostCall() {
  g_at_work = outer_;
  Environment* env = impl_.env;
  if (impl_.rule_open && impl_.rule_depth > depth_) impl_.close_rule();
  impl_.flush_errors();
  impl_.contexts.resize(depth_);
  if (!embedded_) {
    GCBlockEnd(env, &block_);
    return;
  }
  impl_.release_kept();
  if (collect_ == Collect::kLater && ++impl_.uncollected < RuleEngine::Impl::kMostUncollected) return;
  impl_.uncollected = 0;
  CleanCurrentGarbageFrame(env, nullptr);
  CallPeriodicTasks(env);
}

}  // namespace cxlab
