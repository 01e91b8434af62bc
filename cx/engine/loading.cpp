// Files of rules, form by form.

#include <algorithm>
#include <span>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "internal/impl.h"

namespace cxlab {

using namespace clips;

namespace {

/// Functions of CLIPS that a test on a left-hand side must not call; ours say so themselves.
constexpr std::string_view kActingBuiltins[] = {
    "assert", "assert-string", "retract", "modify",        "duplicate",       "reset",           "clear",
    "run",    "load",          "load*",   "batch",         "batch*",          "load-facts",      "bload-facts",
    "bload",  "undefrule",     "build",   "make-instance", "unmake-instance", "modify-instance", "bind"};

bool is_construct(Environment* env, const std::string& head) { return FindConstruct(env, head.c_str()) != nullptr; }

/// Calls in a form: `called(name, line)` for the head of every list that is an expression. On a left-hand side those
/// are the lists inside `(test ...)`, after `=` and `:` of a constraint, and of a salience; elsewhere all lists.
template <class Called>
void for_each_call(const std::vector<Token>& tokens, std::size_t begin, std::size_t end, bool all, Called called) {
  std::vector<bool> expression{all};
  for (std::size_t i = begin; i < end; ++i) {
    if (tokens[i].kind == Token::Kind::kClose) {
      if (expression.size() > 1) expression.pop_back();
      continue;
    }
    if (tokens[i].kind != Token::Kind::kOpen) continue;
    const bool word_before = i > begin && tokens[i - 1].kind == Token::Kind::kWord;
    const std::string_view before = word_before ? tokens[i - 1].text : std::string_view{};
    const bool here = expression.back() || before == "=" || before == ":";
    const bool has_head = i + 1 < end && tokens[i + 1].kind == Token::Kind::kWord;
    const std::string_view head = has_head ? tokens[i + 1].text : std::string_view{};
    if (here && has_head) called(std::string(head), tokens[i + 1].line);
    expression.push_back(here || head == "test" || head == "salience");
  }
}

std::size_t find_arrow(const std::vector<Token>& tokens) {
  std::size_t i = 0;
  while (i < tokens.size() && !(tokens[i].kind == Token::Kind::kWord && tokens[i].text == "=>")) ++i;
  return i;
}

/// An error of the load itself, which CLIPS has not worded.
RuleError load_error(const std::string& file, int line, std::string message) {
  RuleError error;
  error.file = file;
  error.line = line;
  error.message = error.detail = std::move(message);
  return error;
}

}  // namespace

Status LoadReport::status() const {
  if (errors.empty()) return {};
  return errors.front().error();
}

void RuleEngine::Impl::remember(const Form& form, const std::string& file) {
  if (!is_construct(env, form.head)) return;
  const std::string module = GetCurrentModule(env)->header.name->contents;
  forget(form.head, module, form.name);
  std::vector<std::size_t>& known = construct_index[std::pair(form.head, form.name)];
  known.push_back(constructs.size());
  constructs.push_back(ConstructInfo{form.head, module, form.name, file, form.line, form.text});

  const std::vector<Token> tokens = tokens_of(form);
  if (form.head == "defrule") {
    const std::string rule = module + "::" + form.name;
    std::vector<LhsCall>& places = lhs_calls_of[rule];
    places.clear();
    for_each_call(tokens, 1, find_arrow(tokens), false,
                  [&](std::string name, int line) { places.push_back({std::move(name), line}); });
    for (const LhsCall& call : places) rules_calling[call.function].insert(rule);
  } else if (form.head == "deffunction" || form.head == "defmethod") {
    std::set<std::string>& names = calls_of[form.name];
    if (form.head == "deffunction" && known.size() == 1) names.clear();
    for_each_call(tokens, 1, tokens.size(), true, [&](std::string name, int) { names.insert(std::move(name)); });
    for (const std::string& name : names) functions_calling[name].insert(form.name);
    // One that nothing calls yet changes no other.
    if (functions_calling.contains(form.name))
      known_acting.clear();
    else
      known_acting.erase(form.name);
  }
}

namespace {

/// The constructs that a form defines, as in "defrule 'go'". A defglobal defines several. The parameters of a method
/// and the class and kind of a handler are part of the name.
std::vector<std::string> defined_by(const Form& form) {
  if (form.head != "defglobal" && form.head != "defmethod" && form.head != "defmessage-handler")
    return {form.head + " '" + form.name + '\''};
  const Term tree = tree_of(form);
  const auto word = [&](std::size_t i) { return i < tree.items.size() ? tree.items[i].print() : std::string(); };
  std::vector<std::string> names;
  if (form.head == "defglobal") {
    for (const Term& item : tree.items)
      if (!item.is_list() && item.text.starts_with("?*")) names.push_back("defglobal '" + item.text + '\'');
  } else if (form.head == "defmethod") {
    std::string name = "defmethod '" + form.name + '\'';
    for (std::size_t i = 2; i < tree.items.size(); ++i) {
      const Term& item = tree.items[i];
      if (item.kind == Token::Kind::kString) continue;
      name += ' ';
      if (!item.is_list()) {
        name += item.text;  // its number
        continue;
      }
      // The names of parameters do not count.
      for (const Term& parameter : item.items) {
        if (!parameter.is_list()) name += "(?)";
        for (std::size_t k = 1; k < parameter.items.size(); ++k)
          name += (k == 1 ? "(" : " ") + parameter.items[k].print() + (k + 1 == parameter.items.size() ? ")" : "");
      }
      break;
    }
    names.push_back(std::move(name));
  } else {
    const std::string kind =
        tree.items.size() > 3 && !tree.items[3].is_list() && word(3)[0] != '"' ? word(3) : "primary";
    names.push_back("defmessage-handler '" + form.name + ' ' + word(2) + ' ' + kind + '\'');
  }
  return names;
}

/// Declares a function before those that call it: nothing comes after its parameters.
bool is_declaration(const Form& form) {
  if (form.head != "deffunction") return false;
  const Term tree = tree_of(form);
  return std::ranges::count_if(tree.items, &Term::is_list) == 1 && tree.items.back().is_list();
}

}  // namespace

void RuleEngine::Impl::note_definition(const Form& form, const std::string& file, bool may_replace) {
  const std::string module = GetCurrentModule(env)->header.name->contents;
  for (const std::string& name : defined_by(form)) {
    const Definition now{file, form.line, is_declaration(form)};
    const auto [known, fresh] = definitions.try_emplace({module, name}, now);
    if (fresh) continue;
    const Definition before = std::exchange(known->second, now);
    if (!may_replace || before.declaration || (before.file == file && before.line == form.line)) continue;
    notes.push_back(input_error(name + " is defined already in " + before.file + ':' + std::to_string(before.line) +
                                    "; this definition replaces it",
                                file, form.line));
  }
}

std::vector<const ConstructInfo*> RuleEngine::Impl::named(std::string_view kind, std::string_view name) const {
  std::vector<const ConstructInfo*> found;
  const std::string_view bare = without_module(name);
  const auto known = construct_index.find(std::pair(std::string(kind), std::string(bare)));
  if (known == construct_index.end()) return found;
  const std::string_view module = name.substr(0, bare.size() == name.size() ? 0 : name.size() - bare.size() - 2);
  for (const std::size_t place : known->second)
    if (module.empty() || constructs[place]->module == module) found.push_back(&*constructs[place]);
  return found;
}

void RuleEngine::Impl::forget(const std::string& kind, const std::string& module, const std::string& name) {
  const auto known = construct_index.find(std::pair(kind, name));
  if (known == construct_index.end()) return;
  std::erase_if(known->second, [&](std::size_t place) {
    const bool here = constructs[place]->module == module;
    if (here) constructs[place].reset();
    return here;
  });
  if (known->second.empty()) construct_index.erase(known);
}

std::set<std::string> RuleEngine::Impl::rules_reaching(const std::string& function) const {
  std::set<std::string> rules, seen{function};
  std::vector<std::string> open{function};
  while (!open.empty()) {
    const std::string called = std::move(open.back());
    open.pop_back();
    if (const auto found = rules_calling.find(called); found != rules_calling.end())
      rules.insert(found->second.begin(), found->second.end());
    if (const auto found = functions_calling.find(called); found != functions_calling.end())
      for (const std::string& caller : found->second)
        if (seen.insert(caller).second) open.push_back(caller);
  }
  return rules;
}

std::optional<bool> RuleEngine::Impl::acts_itself(const std::string& function) const {
  if (std::find(std::begin(kActingBuiltins), std::end(kActingBuiltins), function) != std::end(kActingBuiltins)) {
    // A local variable may be bound anywhere.
    return function != "bind";
  }
  if (const auto ours = functions.find(function); ours != functions.end() && ours->second->function) {
    return ours->second->spec.kind == FunctionKind::kActing;
  }
  if (!calls_of.contains(function)) return false;
  return std::nullopt;
}

bool RuleEngine::Impl::is_acting(const std::string& function) {
  if (const auto itself = acts_itself(function)) return *itself;
  struct Reached {
    std::string name;
    std::size_t caller;
  };
  std::vector<Reached> reached{{function, 0}};
  std::set<std::string> seen{function};
  for (std::size_t i = 0; i < reached.size(); ++i) {
    bool acts = false;
    if (const auto known = known_acting.find(reached[i].name); known != known_acting.end()) {
      acts = known->second;
    } else {
      for (const std::string& inner : calls_of[reached[i].name]) {
        const auto itself = acts_itself(inner);
        acts = acts || itself.value_or(false);
        if (!itself && seen.insert(inner).second) reached.push_back({inner, i});
      }
    }
    if (!acts) continue;
    for (std::size_t on_the_way = i;; on_the_way = reached[on_the_way].caller) {
      known_acting[reached[on_the_way].name] = true;
      if (on_the_way == 0) return true;
    }
  }
  for (const Reached& harmless : reached) known_acting.emplace(harmless.name, false);
  return false;
}

std::vector<RuleError> RuleEngine::Impl::acting_on_lhs(const std::string& rule) {
  std::vector<RuleError> errors;
  const auto places = lhs_calls_of.find(rule);
  if (places == lhs_calls_of.end()) return errors;
  const ConstructInfo* info = engine.find_construct("defrule", rule);
  const std::string name(without_module(rule));
  for (const LhsCall& place : places->second) {
    if (!is_acting(place.function)) continue;
    // Rules may have removed it themselves. CLIPS looks through all rules for it.
    if (info != nullptr && !engine.has("defrule", rule)) return errors;
    if (!reported_lhs.insert(rule + '\n' + place.function + '\n' + std::to_string(place.line)).second) continue;
    RuleError error = load_error(info == nullptr ? std::string() : info->file, place.line,
                                 "rule '" + name + "' calls '" + place.function + "' on its left-hand side" +
                                     (acts_itself(place.function) ? "" : ", which calls an acting function") +
                                     "; expected a function without effects");
    error.rule = name;
    error.t = engine.now();
    errors.push_back(std::move(error));
  }
  return errors;
}

std::string RuleEngine::acting_call(const ConstructInfo& rule) const {
  const auto places = impl_->lhs_calls_of.find(rule.module + "::" + rule.name);
  if (places == impl_->lhs_calls_of.end()) return {};
  const auto acting =
      std::ranges::find_if(places->second, [&](const auto& place) { return impl_->is_acting(place.function); });
  return acting == places->second.end() ? std::string() : acting->function;
}

bool RuleEngine::Impl::is_there_already(const Form& form) const {
  const bool module = form.head == "defmodule";
  if (keep_same == KeepSame::kNothing || !is_construct(env, form.head)) return false;
  if (keep_same == KeepSame::kTypes && form.head != "deftemplate" && form.head != "defclass" && !module) return false;
  for (const ConstructInfo& known : engine.find_constructs(form.head, form.name)) {
    std::string name = known.name;
    if (name.starts_with("?*") && name.size() > 3) name = name.substr(2, name.size() - 3);  // of a global
    if (known.text != form.text || !engine.has(form.head, module ? name : known.module + "::" + name)) continue;
    if (keep_same == KeepSame::kAll && !module && known.module != GetCurrentModule(env)->header.name->contents &&
        tokens_of(form)[2].text.find("::") == std::string_view::npos)
      continue;
    if (module) SetCurrentModule(env, FindDefmodule(env, known.name.c_str()));  // what follows it belongs there
    return true;
  }
  return false;
}

void RuleEngine::keep_same_constructs(KeepSame keep) {
  impl_->keep_same = keep;
  if (keep != KeepSame::kNothing) {
    SetCurrentModule(environment_, FindDefmodule(environment_, "MAIN"));  // as at the first load
    return;
  }
  // Places of constructs that were replaced are given back: files may be loaded again any number of times.
  std::erase_if(impl_->constructs, [](const auto& info) { return !info; });
  impl_->construct_index.clear();
  for (std::size_t i = 0; i < impl_->constructs.size(); ++i)
    impl_->construct_index[std::pair(impl_->constructs[i]->kind, impl_->constructs[i]->name)].push_back(i);
}

namespace {

/// CLIPS makes a rule of each; the time for that grows with their square.
constexpr double kMostAlternatives = 10'000;

/// The choices among the conditions of a left-hand side, up to the arrow: `or` adds them, all else multiplies.
double alternatives(std::span<const Term> conditions, bool any) {
  double sum = 0, product = 1;
  for (const Term& condition : conditions) {
    if (condition.is("=>")) break;
    double inner = 1;
    const std::string_view head = condition.head();
    if (head == "or" || head == "and" || head == "not" || head == "exists" || head == "forall" || head == "logical")
      inner = alternatives(std::span(condition.items).subspan(1), head == "or");
    sum += inner;
    product *= inner;
  }
  return any ? sum : product;
}

}  // namespace

bool RuleEngine::Impl::load_form(const Form& form, const std::string& file, LoadMode mode) {
  HostCall call(*this, {ErrorSide::kLoad, form.name, file, form.line, &form});
  if (mode == LoadMode::kConstructs && !(form.list && is_construct(env, form.head))) {
    add_error(load_error(file, form.line,
                         "[CSTRCPSR1] Expected the beginning of a construct, found " +
                             (form.list ? "(" + form.head + " ...)" : form.head)));
    return false;
  }
  if (is_there_already(form)) return true;
  if (form.head == "defrule" && form.text.find("(or") != std::string::npos) {
    if (const double rules = alternatives(tree_of(form).items, false); rules > kMostAlternatives) {
      add_error(load_error(file, form.line,
                           "rule '" + form.name + "': its 'or' conditions have " + general_text(rules, 9) +
                               " combinations, each of which would be a rule; expected at most 10000"));
      return false;
    }
  }
  const long old_line = SetLineCount(env, form.line);
  const char* old_router = router_data(env)->LineCountRouter;
  const bool old_evaluating = command_line_data(env)->EvaluatingTopLevelCommand;
  expr* old_command = command_line_data(env)->CurrentCommand;
  command_line_data(env)->EvaluatingTopLevelCommand = false;
  bool fine = true;
  if (form.list && is_construct(env, form.head)) {
    router_data(env)->LineCountRouter = "build";
    fine = Build(env, form.text.c_str()) == BE_NO_ERROR;
    if (fine) remember(form, file);
  } else {
    router_data(env)->LineCountRouter = "command";
    const bool counts = limit == 0;  // a rule that loads cannot `run`
    if (counts) count_firings(engine.options_.max_load_firings);
    fine = RouteCommand(env, form.text.c_str(), false) && !GetEvaluationError(env);
    if (counts) limit = 0;
    if (counts && limit_reached) {
      fine = false;
      add_error(load_error(file, form.line, "(" + form.head + " ...): " + loop_report().text()));
    }
  }
  router_data(env)->LineCountRouter = old_router;
  SetLineCount(env, old_line);
  command_line_data(env)->EvaluatingTopLevelCommand = old_evaluating;
  command_line_data(env)->CurrentCommand = old_command;
  if (!fine && starts.empty() && engine.errors_.empty())
    add_error(load_error(file, form.line, "CLIPS does not accept (" + form.head + " ...)"));
  return fine;
}

LoadReport RuleEngine::load_text(std::string_view text, const std::string& file, LoadMode mode, OnLoadError on_error) {
  LoadReport report;
  impl_->flush_errors();
  // Errors of before this load stay for the next report.
  std::vector<RuleError> earlier = std::exchange(errors_, {});
  const auto collect = [&] {
    impl_->flush_errors();
    for (RuleError& error : errors_) report.errors.push_back(std::move(error));
    errors_.clear();
    impl_->known_errors.clear();
    return on_error == OnLoadError::kStop && !report.errors.empty();
  };

  const OnLoadError outer = std::exchange(impl_->on_load_error, on_error);
  FormReading reading = read_forms(text, file);
  std::size_t next_error = 0;
  const auto add_reading_errors = [&](int before_line) {
    for (; next_error < reading.errors.size() && reading.errors[next_error].line < before_line; ++next_error) {
      const Error& found = reading.errors[next_error];
      impl_->add_error(load_error(file, found.line, found.message));
    }
  };

  bool stopped = false;
  evaluationData& counted = *evaluation_data(environment_);
  if (counted.CurrentExpression != nullptr) counted.Steps += kStepsOfAByte * text.size();  // rules load it
  for (const Form& form : reading.forms) {
    if (counted.Steps > counted.LookAtStep) {  // reading takes steps, too
      impl_->contexts.push_back({ErrorSide::kLoad, {}, file, form.line, nullptr});
      impl_->look_at_limits();
      impl_->contexts.pop_back();
    }
    if (options_.limits != nullptr && options_.limits->exceeded) break;
    add_reading_errors(form.line);
    if ((stopped = collect())) break;
    const bool may_replace = form.head == "defglobal" || form.head == "defmethod" ||
                             form.head == "defmessage-handler" || has(form.head, form.name);
    if (impl_->load_form(form, file, mode) && !impl_->rule_acting && form.list && is_construct(environment_, form.head))
      impl_->note_definition(form, file, may_replace);
    ++report.forms;
    const bool rule = form.head == "defrule";
    std::vector<RuleError> acting;
    if (rule) acting = impl_->acting_on_lhs(GetCurrentModule(environment_)->header.name->contents + ("::" + form.name));
    if (form.head == "deffunction" || form.head == "defmethod") {
      for (const std::string& name : impl_->rules_reaching(form.name)) {
        for (RuleError& error : impl_->acting_on_lhs(name)) acting.push_back(std::move(error));
      }
    }
    for (RuleError& error : acting) {
      if (on_error == OnLoadError::kStop) {
        impl_->add_error(std::move(error));
      } else {
        impl_->notes.push_back(error.error());
      }
    }
    if ((stopped = collect())) break;
    if (impl_->exit_requested) break;
  }
  if (!stopped) {
    add_reading_errors(INT32_MAX);
    collect();
  }
  impl_->on_load_error = outer;
  errors_ = std::move(earlier);
  return report;
}

LoadReport RuleEngine::load_file(const std::string& path, LoadMode mode, OnLoadError on_error) {
  const auto refused = [&](const std::string& what) {
    LoadReport report;
    report.errors.push_back(load_error(path, 0, what));
    return report;
  };
  Expected<std::string> real_path = options_.files == nullptr ? path : options_.files->for_reading(path);
  if (!real_path) return refused(real_path.error().message);
  const auto text = read_file(*real_path);
  if (!text) return refused(text.error().message);
  return load_text(*text, path, mode, on_error);
}

Status RuleEngine::build(std::string_view construct, const std::string& file, int line) {
  FormReading reading = read_forms(construct, file);
  if (!reading.errors.empty()) return Error(reading.errors.front()).with_code(kSyntaxCode);
  if (reading.forms.size() != 1)
    return input_error("expected one construct, found " + std::to_string(reading.forms.size()), file, line)
        .with_code(kSyntaxCode);
  Form& form = reading.forms.front();
  const bool known = form.list && is_construct(environment_, form.head);
  if (line > 0) form.line += line - 1;
  std::vector<RuleError> earlier = std::exchange(errors_, {});
  const bool fine = impl_->load_form(form, file, LoadMode::kConstructs);
  std::vector<RuleError> raised = std::exchange(errors_, std::move(earlier));
  impl_->known_errors.clear();
  if (raised.empty() && fine) return {};
  Error error =
      raised.empty() ? input_error("CLIPS does not accept the construct", file, form.line) : raised.front().error();
  return std::move(error).with_code(known || !form.list ? kSyntaxCode : kUnknownConstructCode);
}

Status RuleEngine::undefine(std::string_view kind, const std::string& name) {
  Construct* construct = FindConstruct(environment_, std::string(kind).c_str());
  if (construct == nullptr) return input_error("'" + std::string(kind) + "' is no kind of construct");
  HostCall call(*impl_, {ErrorSide::kCallback, "undefine", {}, 0, nullptr});
  ConstructHeader* found =
      construct->findFunction == nullptr ? nullptr : construct->findFunction(environment_, name.c_str());
  if (found == nullptr) return input_error("there is no " + std::string(kind) + " '" + name + "'");
  const std::string module = found->whichModule == nullptr ? "" : found->whichModule->theModule->header.name->contents;
  const bool deletable =
      construct->isConstructDeletableFunction == nullptr || construct->isConstructDeletableFunction(found);
  if (!deletable || construct->deleteFunction == nullptr || !construct->deleteFunction(found, environment_)) {
    return run_error(std::string(kind) + " '" + name + "' is in use and stays");
  }
  const std::string bare(without_module(name));
  impl_->forget(std::string(kind), module, bare);
  if (kind == "defrule") impl_->lhs_calls_of.erase(module + "::" + bare);
  return {};
}

bool RuleEngine::has(std::string_view kind, const std::string& name) const {
  if (kind == "defmodule") return FindDefmodule(environment_, name.c_str()) != nullptr;
  Construct* construct = FindConstruct(environment_, std::string(kind).c_str());
  return construct != nullptr && construct->findFunction(environment_, name.c_str()) != nullptr;
}

std::vector<ConstructInfo> RuleEngine::constructs() const {
  std::vector<ConstructInfo> list;
  for (const std::optional<ConstructInfo>& info : impl_->constructs) {
    if (info) list.push_back(*info);
  }
  return list;
}

const ConstructInfo* RuleEngine::find_construct(std::string_view kind, std::string_view name) const {
  const std::vector<const ConstructInfo*> found = impl_->named(kind, name);
  return found.empty() ? nullptr : found.back();
}

std::vector<ConstructInfo> RuleEngine::find_constructs(std::string_view kind, std::string_view name) const {
  std::vector<ConstructInfo> found;
  for (const ConstructInfo* info : impl_->named(kind, name)) found.push_back(*info);
  return found;
}

}  // namespace cxlab
