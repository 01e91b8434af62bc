#include "cx/executive/strict_cx.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <set>

#include "cx/engine/form_reader.h"

namespace cxlab::cx {

namespace {

using Visit = std::function<void(const Term&)>;

void each_list(const Term& term, const Visit& visit) {
  if (!term.is_list()) return;
  visit(term);
  for (const Term& item : term.items) each_list(item, visit);
}

/// A construct as a tree, and where what is found in it is.
struct Construct {
  const ConstructInfo& info;
  Term tree;
};

class Reader {
 public:
  Reader(const RuleEngine& engine, RosRelease release, const std::map<std::string, std::string>& own_plugins)
      : engine_(engine), release_(release) {
    for (const FunctionSpec& function : engine.functions()) {
      functions_.insert(function.name);
      if (const auto own = own_plugins.find(function.owner); own != own_plugins.end())
        not_of_cx_[function.name] = "is of plugin '" + own->first + "' (" + own->second + "), which CX does not have";
      if (function.name == "pb-peer-create-crypto" || function.name.ends_with("-client-cancel-goals-before"))
        not_of_cx_.try_emplace(function.name, "fails at each call in CX");
    }
  }

  std::vector<Error> read() {
    for (const ConstructInfo& info : engine_.constructs()) {
      if (info.kind != "defrule" && info.kind != "deffunction" && info.kind != "defmethod" &&
          info.kind != "defmessage-handler" && info.kind != "deffacts")
        continue;
      const Construct construct{info, tree_of(Form{info.text, info.line, true, info.kind, info.name})};
      look_for_missing_functions(construct);
      look_for_own_functions(construct);
      look_for_constant_times(construct);
      look_at_callback(construct);
      collect_names(construct);
    }
    return std::move(found_);
  }

 private:
  void found(const Construct& in, int line, const std::string& what) {
    Error error = input_error("strict-cx: " + what, in.info.file, in.info.file.empty() ? 0 : line);
    const auto same = [&](const Error& e) { return e.message == error.message && e.file == error.file; };
    if (std::none_of(found_.begin(), found_.end(), same)) found_.push_back(std::move(error));
  }

  /// Generic clients and servers that rclcpp of that release does not have, so CX is built without them.
  void look_for_missing_functions(const Construct& construct) {
    struct Missing {
      RosRelease last;  ///< the last release that lacks them
      std::string_view what;
      std::vector<std::string_view> functions;
    };
    static const std::array<Missing, 2> kMissing{{{RosRelease::kJazzy,
                                                   "action client",
                                                   {"ros-msgs-create-action-client", "ros-msgs-create-goal-request",
                                                    "ros-msgs-async-send-goal", "ros-msgs-async-cancel-goal"}},
                                                  {RosRelease::kHumble,
                                                   "service client and server",
                                                   {"ros-msgs-create-client", "ros-msgs-create-request",
                                                    "ros-msgs-async-send-request", "ros-msgs-create-service"}}}};
    each_list(construct.tree, [&](const Term& list) {
      for (const Missing& missing : kMissing)
        if (release_ <= missing.last && std::ranges::find(missing.functions, list.head()) != missing.functions.end())
          found(construct, list.line,
                "release: ROS 2 " + std::string(kRosReleases[static_cast<std::size_t>(release_)]) + " has no generic " +
                    std::string(missing.what) + ", so CX has no '" + std::string(list.head()) +
                    "' there; use the generated bindings of the type");
    });
  }

  void look_for_own_functions(const Construct& construct) {
    each_list(construct.tree, [&](const Term& list) {
      const auto own = not_of_cx_.find(list.head());
      if (own != not_of_cx_.end()) found(construct, list.line, "function: '" + own->first + "' " + own->second);
    });
  }

  static bool is_number(const Term& term) {
    if (term.is_list() || term.text.empty() || term.kind != Token::Kind::kWord) return false;
    const std::size_t first = term.text[0] == '-' || term.text[0] == '+' ? 1 : 0;
    return first < term.text.size() && (std::isdigit(static_cast<unsigned char>(term.text[first])) != 0);
  }

  /// Simulated time begins at 0; the clock of a robot counts the seconds since 1970.
  void look_for_constant_times(const Construct& construct) {
    std::set<std::string> times;  // variables bound to the time
    each_list(construct.tree, [&](const Term& list) {
      const bool pattern = list.head() == "time" && list.items.size() >= 2 && construct.info.kind == "defrule";
      if (pattern && list.items[1].text.starts_with('?') && list.items[1].text.size() > 1)
        times.insert(list.items[1].text);
      if (pattern && is_number(list.items[1]))
        found(construct, list.line,
              "time: " + list.print() +
                  " needs simulated time; time counts from 1970 on a robot. Compare with a time " + "that was noted");
      const bool bound = list.head() == "bind" && list.items.size() == 3 && list.items[2].head() == "now";
      if (bound) times.insert(list.items[1].text);
    });
    static constexpr std::array<std::string_view, 8> kCompares{"<", ">", "<=", ">=", "=", "<>", "eq", "neq"};
    const auto is_time = [&](const Term& term) {
      return term.head() == "now" || (!term.is_list() && times.contains(term.text));
    };
    each_list(construct.tree, [&](const Term& list) {
      if (std::ranges::find(kCompares, list.head()) == kCompares.end()) return;
      const bool of_time = std::any_of(list.items.begin() + 1, list.items.end(), is_time);
      const bool with_constant = std::any_of(list.items.begin() + 1, list.items.end(), is_number);
      if (of_time && with_constant)
        found(construct, list.line,
              "time: " + list.print() +
                  " needs simulated time; time counts from 1970 on a robot. Compare with a time " + "that was noted");
    });
  }

  /// CX calls deffunctions of these names with so many arguments; another number is an error at each call there.
  void look_at_callback(const Construct& construct) {
    struct Callback {
      std::string_view ending, arguments;
      std::size_t count;
    };
    static constexpr std::array<Callback, 3> kCallbacks{{{"-service-callback", "?service ?request ?response", 3},
                                                         {"-handle-goal-callback", "?server ?goal ?goal-id", 3},
                                                         {"-cancel-goal-callback", "?server ?goal ?goal-handle", 3}}};
    if (construct.info.kind != "deffunction") return;
    for (const Callback& callback : kCallbacks) {
      if (!construct.info.name.ends_with(callback.ending)) continue;
      const auto list = std::find_if(construct.tree.items.begin(), construct.tree.items.end(),
                                     [](const Term& term) { return term.is_list(); });
      if (list == construct.tree.items.end()) continue;
      std::size_t single = 0;
      bool more = false;
      for (const Term& parameter : list->items) {
        if (parameter.text.starts_with('?')) ++single;
        more = more || parameter.text.starts_with("$?");
      }
      if (single == callback.count || (more && single <= callback.count)) continue;
      found(construct, list->line,
            "callback: '" + construct.info.name + "' takes " + list->print() + ", but is called with (" +
                std::string(callback.arguments) + ")");
    }
  }

  enum class NameOf { kTopic, kServer };  // of services and actions

  /// Names of topics, services and servers: CX compares texts, so "/pose" and "pose" are two.
  void collect_names(const Construct& construct) {
    struct Argument {
      std::string_view ending;
      std::size_t position;
      NameOf of;
    };
    static constexpr std::array<Argument, 15> kArguments{{{"-create-publisher", 1, NameOf::kTopic},
                                                          {"-destroy-publisher", 1, NameOf::kTopic},
                                                          {"-create-subscription", 1, NameOf::kTopic},
                                                          {"-destroy-subscription", 1, NameOf::kTopic},
                                                          {"-publish", 2, NameOf::kTopic},
                                                          {"-client", 1, NameOf::kServer},
                                                          {"-create-service", 1, NameOf::kServer},
                                                          {"-destroy-service", 1, NameOf::kServer},
                                                          {"-create-server", 1, NameOf::kServer},
                                                          {"-destroy-server", 1, NameOf::kServer},
                                                          {"-send-request", 2, NameOf::kServer},
                                                          {"-send-goal", 2, NameOf::kServer},
                                                          {"-cancel-goal", 1, NameOf::kServer},
                                                          {"-cancel-all-goals", 1, NameOf::kServer},
                                                          {"-cancel-goals-before", 1, NameOf::kServer}}};
    each_list(construct.tree, [&](const Term& list) {
      const std::string_view head = list.head();
      if (functions_.contains(std::string(head))) {
        const auto argument =
            std::ranges::find_if(kArguments, [&](const Argument& one) { return head.ends_with(one.ending); });
        if (argument != kArguments.end() && argument->position < list.items.size())
          note_name(construct, list.items[argument->position], argument->of);
        return;
      }
      const bool topic = head == "topic";
      if (topic || head == "service" || head == "server")
        for (const Term& item : list.items)
          if (item.kind == Token::Kind::kString) note_name(construct, item, topic ? NameOf::kTopic : NameOf::kServer);
    });
    constexpr std::string_view kCallback = "-service-callback";
    if (construct.info.kind != "deffunction" || !construct.info.name.ends_with(kCallback)) return;
    const std::string service = construct.info.name.substr(0, construct.info.name.size() - kCallback.size());
    if (!functions_.contains(service + "-create-service"))  // else it is that of a generated binding
      note_name(construct, service, construct.info.line, NameOf::kServer);
  }

  void note_name(const Construct& construct, const Term& item, NameOf of) {
    if (item.kind == Token::Kind::kString) {
      note_name(construct, item.text.substr(1, item.text.size() - 2), item.line, of);
    } else if (!item.is_list() && item.text.find_first_of("?$") != 0) {
      note_name(construct, item.text, item.line, of);
    }
  }

  void note_name(const Construct& construct, const std::string& name, int line, NameOf of) {
    const std::string bare = name.substr(name.starts_with('/') ? 1 : 0);
    const auto [first, is_first] = spellings_.try_emplace({of, bare}, name);
    if (!is_first && first->second != name)
      found(construct, line,
            "spelling: \"" + name + "\" here and \"" + first->second +
                "\" elsewhere: CX compares names as they are written");
  }

  const RuleEngine& engine_;
  RosRelease release_;
  std::set<std::string> functions_;
  std::map<std::string, std::string, std::less<>> not_of_cx_;        // functions, and why
  std::map<std::pair<NameOf, std::string>, std::string> spellings_;  // without a leading slash -> as written first
  std::vector<Error> found_;
};

}  // namespace

std::vector<Error> differences_in_rules(const RuleEngine& engine, RosRelease release,
                                        const std::map<std::string, std::string>& own_plugins) {
  return Reader(engine, release, own_plugins).read();
}

std::vector<Error> facts_lost_by_reset(const RuleEngine& engine) {
  std::vector<Error> found;
  std::set<std::string> templates;
  for (const FactCopy& fact : engine.facts())
    if (templates.insert(fact.template_name).second)
      found.push_back(input_error("strict-cx: reset: the fact " + fact.print() +
                                  " was asserted before the reset at the end of the activation, which takes it away; "
                                  "use deffacts, or a rule"));
  return found;
}

}  // namespace cxlab::cx
