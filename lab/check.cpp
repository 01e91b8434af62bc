#include "lab/check.h"

#include <algorithm>
#include <cctype>
#include <climits>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>

#include "cx/base/file.h"
#include "cx/check/graph.h"
#include "cx/plugins/builtin.h"
#include "cx/yaml/yaml.h"
#include "lab/confine.h"
#include "lab/env_scenario.h"
#include "lab/reference.h"
#include "lab/session.h"
#include "scenarios/episode.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

using Extensions = std::span<const std::string_view>;
constexpr std::string_view kRuleFiles[] = {".clp", ".bat", ".clips"}, kYaml[] = {".yaml", ".yml"}, kPddl[] = {".pddl"};

bool has_extension(const fs::path& file, Extensions extensions) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::ranges::find(extensions, extension) != extensions.end();
}
bool is_rule_file(const fs::path& file) { return has_extension(file, kRuleFiles); }

std::string real(const fs::path& path) {
  std::error_code ignored;
  const fs::path found = fs::weakly_canonical(path, ignored);
  return found.empty() ? path.string() : found.string();
}

bool is_below(const fs::path& file, const fs::path& folder) {
  const std::string inner = real(file), outer = real(folder);
  return inner.size() > outer.size() && inner.starts_with(outer) &&
         (outer.ends_with('/') || inner[outer.size()] == '/');
}

/// All files with these extensions below a folder, but in hidden folders; not `deep`: in it alone.
std::vector<fs::path> files_below(const fs::path& folder, Extensions extensions, bool deep = true) {
  constexpr std::size_t kMost = 2000;
  std::vector<fs::path> out;
  std::error_code error;
  fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, error), end;
  for (; !error && at != end && out.size() < kMost; at.increment(error)) {
    std::error_code ignored;
    if (at->is_directory(ignored) && (!deep || at->path().filename().string().starts_with('.')))
      at.disable_recursion_pending();
    else if (at->is_regular_file(ignored) && has_extension(at->path(), extensions))
      out.push_back(at->path());
  }
  std::ranges::sort(out);
  return out;
}

check::Outside outside_of_files() {
  check::Outside outside;
  for (const std::string_view fact : cx::builtin_facts()) outside.facts.emplace(fact);
  return outside;
}

void add_words(const std::string& text, check::Words& words) {
  std::string word;
  for (const char c : text + ' ') {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_')
      word += c;
    else if (!word.empty())
      words.insert(std::exchange(word, {}));
  }
}

class Checker {
 public:
  Checker(const CheckOptions& options, const Catalogue& catalogue, const Host& host)
      : options_(options), catalogue_(catalogue), host_(host) {}

  Expected<Checked> check() {
    std::vector<std::string> files;
    for (const std::string& input : options_.inputs) {
      const auto scenario = scenario_of(input);
      if (!scenario) return scenario.error();
      if (!*scenario) {
        files.push_back(input);
        continue;
      }
      if (Status s = open(**scenario); !s) return s.error();
    }
    const auto packages = find_packages(options_.packages);
    if (!packages) return packages.error();
    std::vector<PluginReference> reference;
    if (!files.empty()) {
      auto all = read_reference(*packages);
      if (!all) return all.error();
      reference = *std::move(all);
    }
    raise_wall_around(files, *packages);
    for (const auto& opening : openings_)
      if (Status s = check_agents(*opening); !s) return s.error();
    if (!files.empty())
      if (Status s = check_files(files, *packages, reference); !s) return s.error();
    checked_.findings = check::without_allowed(std::move(checked_.findings), judged_);
    checked_.files = judged_files_.size();
    checked_.rules = rules_.size();
    return std::move(checked_);
  }

 private:
  struct Opening {
    std::unique_ptr<Episode> episode;
    std::vector<fs::path> own;   ///< folders of the packages that are checked
    std::vector<fs::path> read;  ///< files, in order, since this was emptied
    check::Words words;          ///< of the configurations
  };

  /// Files of a stranger are read behind the wall: batch files call functions.
  void raise_wall_around(const std::vector<std::string>& files,
                         const std::map<std::string, std::string>& packages) const {
    Wall all;
    for (const auto& opening : openings_) {
      const Wall wall = opening->episode->wall();
      all.read.insert(all.read.end(), wall.read.begin(), wall.read.end());
      all.write.insert(all.write.end(), wall.write.begin(), wall.write.end());
    }
    for (const std::string& file : files) all.read.push_back(fs::absolute(file).parent_path());
    if (!files.empty())
      for (const auto& [name, folder] : packages) all.read.emplace_back(folder);
    if (!openings_.empty())
      confine(*openings_.front()->episode, host_, all);
    else
      confine(host_, all);
  }

  /// None: it is a rule file.
  Expected<std::optional<Scenario>> scenario_of(const std::string& input) {
    if (is_folder(input))
      return input_error("is a folder, expected a scenario, a configuration (YAML) or rule files", input);
    if (is_rule_file(input)) return std::optional<Scenario>();
    const auto found = find_scenario(input);
    if (!found) return found.error();
    if (!has_extension(*found, kYaml))
      return input_error("expected a scenario or configuration (.yaml), or rule files (.clp, .bat, .clips)", input);
    auto document = yaml::Document::load(*found);
    if (!document) return document.error();
    yaml::Map root = document->root().as_map();
    if (root.has("agents") || root.has("schema") || root.has("world")) {
      if (!options_.params.empty()) return usage_error("--param: is for configurations; a scenario has its own params");
      auto scenario = Scenario::load(*found, catalogue_, {});
      if (!scenario) return scenario.error();
      own_.clear();
      for (const auto& [name, package] : scenario->packages) own_.push_back(scenario->resolve(package.folder));
      for (const AgentSpec& agent : scenario->agents)
        for (const auto& [name, package] : agent.packages) own_.push_back(scenario->resolve(package.folder));
      return std::optional<Scenario>(*std::move(scenario));
    }
    EnvOptions env;
    env.configs = {found->string()};
    env.packages = options_.packages.named;
    env.params = options_.params;
    auto scenario = env_scenario(env, catalogue_);
    if (!scenario) return scenario.error();
    own_.clear();
    fs::path around;  // the innermost package that has the configuration
    for (const auto& [name, package] : scenario->packages) {
      const fs::path folder = scenario->resolve(package.folder);
      if (is_below(*found, folder) && real(folder).size() > real(around).size()) around = folder;
      if (package.origin.source.starts_with("--package")) own_.push_back(folder);
    }
    if (!around.empty()) own_.push_back(around);
    return std::optional<Scenario>(*std::move(scenario));
  }

  Status open(Scenario scenario) {
    auto opening = std::make_unique<Opening>();
    opening->own = own_;
    auto installed = installed_packages(options_.packages.prefixes);
    if (!installed) return installed.error();
    for (const auto& [name, folder] : *installed) scenario.packages.try_emplace(name, PackageSpec{folder});
    for (const AgentSpec& agent : scenario.agents)
      if (const auto text = read_file(scenario.resolve(agent.config))) add_words(*text, opening->words);
    // Nobody plays: without world, nodes and stimuli.
    scenario.set_world({&kEmptyWorld});
    scenario.servers.clear();
    scenario.stimuli.clear();
    scenario.expect.clear();
    scenario.stop_on_rule_error = false;
    EpisodeOptions options = shared_episode_options(host_);
    options.spec.keep_going = true;
    options.file_read = [read = &opening->read](const fs::path& file) { read->push_back(file); };
    auto episode = Episode::load(std::move(scenario), options);
    if (!episode) return episode.error();
    opening->episode = *std::move(episode);
    openings_.push_back(std::move(opening));
    return {};
  }

  Status check_agents(Opening& opening) {
    for (const auto& manager : opening.episode->agents()) {
      if (Status s = manager->configure(); !s) return s;
      for (const std::string& name : manager->environment_names()) {
        if (host_.stopped()) return {};
        if (Status s = manager->destroy_environment(name); !s) return s;
        opening.read.clear();
        if (Status s = manager->create_environment(name); !s) return s;
        if (Status s = check_environment(opening, *manager, name); !s) return s;
      }
    }
    return {};
  }

  Status check_environment(Opening& opening, cx::EnvironmentManager& manager, const std::string& name) {
    const RuleEngine& engine = manager.find(name)->engine();
    const std::vector<ConstructInfo> constructs = engine.constructs();
    std::set<std::string> with_constructs;
    std::map<std::string, check::Words> slots;
    for (const ConstructInfo& info : constructs) {
      with_constructs.insert(info.file);
      if (info.kind != "deftemplate") continue;
      const std::vector<std::string> names = engine.slot_names(info.name);
      slots[info.name].insert(names.begin(), names.end());
    }
    bool own_library = false;
    if (const auto plugins = manager.plugin_names(name))
      own_library = std::ranges::any_of(
          *plugins, [&](const std::string& plugin) { return engine_is_foreign(opening, manager, plugin); });
    if (Status s = manager.destroy_environment(name); !s) return s;  // loads cleanup_batch files

    std::vector<check::Source> sources;
    std::set<std::string> loaded;
    for (const fs::path& file : opening.read) {
      if (!is_rule_file(file) && !with_constructs.contains(file.string())) continue;
      if (!loaded.insert(file.string()).second) continue;
      auto text = read_file(file);
      if (!text) return text.error();
      const bool judged = std::ranges::any_of(opening.own, [&](const fs::path& own) { return is_below(file, own); });
      sources.push_back({shown(file), *std::move(text), judged, true});
    }
    check::Outside outside = outside_of_files();
    outside.open = own_library;
    outside.words = opening.words;
    outside.slots = std::move(slots);
    for (const ConstructInfo& info : constructs) {
      if (loaded.contains(info.file)) continue;
      if (info.kind == "deftemplate") outside.templates.insert(info.name);
      if (info.kind == "deffunction") outside.functions.insert(info.name);
    }
    std::vector<Error> errors = manager.load_errors();
    for (const fs::path& own : opening.own) {
      add_context(files_below(own, kRuleFiles), loaded, sources);
      for (const fs::path& file : files_below(own, kPddl))
        if (const auto text = read_file(file)) add_words(*text, outside.words);
    }
    return examine(std::move(sources), std::move(outside), errors, name);
  }

  /// Its class is of a library of a package: nobody knows what it asserts and reads.
  bool engine_is_foreign(const Opening& opening, const cx::EnvironmentManager& manager,
                         const std::string& plugin) const {
    for (const AgentSpec& agent : opening.episode->scenario().agents) {
      const auto parameters =
          cx::Parameters::load(opening.episode->scenario().resolve(agent.config), manager.node(), agent.name_space);
      if (!parameters) continue;
      std::string type;
      const cx::Parameter* found = parameters->find(plugin + ".plugin");
      if (!found || !parameters->read(plugin + ".plugin", type).ok()) continue;
      const bool built_in = std::ranges::any_of(cx::builtin_plugins(), [&](const cx::PluginType& known) {
        return known.name == type || (known.has && type.starts_with("cx::CX"));
      });
      if (!built_in) return true;
    }
    return false;
  }

  /// Rule files that are not loaded tell how the loaded ones are used. Their own faults are no findings.
  static void add_context(const std::vector<fs::path>& files, const std::set<std::string>& loaded,
                          std::vector<check::Source>& sources) {
    std::set<std::string> known;
    for (const std::string& file : loaded) known.insert(real(file));
    for (const fs::path& file : files) {
      if (!known.insert(real(file)).second) continue;
      auto text = read_file(file);
      if (text && read_forms(*text, file.string()).errors.empty())
        sources.push_back({file.string(), *std::move(text), false, false});
    }
  }

  Status check_files(const std::vector<std::string>& files, const std::map<std::string, std::string>& packages,
                     const std::vector<PluginReference>& reference) {
    std::vector<check::Source> sources;
    std::set<std::string> loaded;
    std::vector<fs::path> context;
    check::Outside outside = outside_of_files();
    for (const std::string& file : files) {
      if (!loaded.insert(file).second) continue;
      auto text = read_file(file);
      if (!text) return text.error();
      sources.push_back({file, *std::move(text), true, true});
      const fs::path folder = fs::absolute(file).parent_path();
      for (fs::path& beside : files_below(folder, kRuleFiles, false)) context.push_back(std::move(beside));
      for (const fs::path& story : files_below(folder, kYaml, false))  // rules that only stories give facts
        if (const auto words = read_file(story); words && story.string().ends_with(".story.yaml"))
          add_words(*words, outside.facts);
    }
    for (const auto& [name, folder] : packages)
      for (fs::path& file : files_below(folder, kRuleFiles)) context.push_back(std::move(file));
    for (const PluginReference& plugin : reference)
      for (const Documented& construct : plugin.constructs)
        (construct.kind == "deftemplate" ? outside.templates : outside.functions).insert(construct.name);
    add_context(context, loaded, sources);
    add_bindings(packages, sources, outside);
    return examine(std::move(sources), std::move(outside), {}, "rule files");
  }

  /// Templates of bindings (std-msgs-string-message) are made from interfaces.
  static void add_bindings(const std::map<std::string, std::string>& packages,
                           const std::vector<check::Source>& sources, check::Outside& outside) {
    check::Words words;
    for (const check::Source& source : sources)
      if (source.judged) add_words(source.text, words);
    for (const std::string& word : words)
      for (const std::string_view end : {"-message", "-response", "-goal-response", "-wrapped-result", "-accepted-goal",
                                         "-client", "-publisher", "-subscription", "-service", "-feedback"})
        if (word.ends_with(end) && !outside.templates.contains(word) && !binding_classes_of(word, packages).empty()) {
          outside.templates.insert(word);
          break;
        }
  }

  /// Relative to where the person stands, if it lies below.
  static std::string shown(const fs::path& file) {
    std::error_code ignored;
    const fs::path here = fs::current_path(ignored);
    return !here.empty() && is_below(file, here) ? fs::path(real(file)).lexically_relative(real(here)).string()
                                                 : file.string();
  }

  /// "[CSTRNCHK1] ... found in CE #2 ... for slot 'state'": the line of that slot in the condition of that number.
  static int line_of(const Error& error, const check::Construct& construct) {
    const auto after = [&](std::string_view mark) {
      const std::size_t at = error.message.find(mark);
      return at == std::string::npos ? std::string() : error.message.substr(at + mark.size());
    };
    const std::string number = after("CE #"), slot = after("slot '");
    int condition = 0;
    const std::size_t end = check::first_action(construct.tree);
    for (std::size_t i = 2; i < end; ++i) {
      const Term& term = construct.tree.items[i];
      if (!term.is_list() || term.head() == "declare" || ++condition != std::atoi(number.c_str())) continue;
      for (const Term& item : term.items)
        if (!item.head().empty() && slot.starts_with(std::string(item.head()) + '\'')) return item.line;
      return term.line;
    }
    return error.line;
  }

  /// Whether what CLIPS refuses to load is a finding, or can be one: a symbol that its slot does not allow.
  static bool is_finding(const Error& error, const check::RuleBase& base, std::vector<check::Finding>& found) {
    if (error.file.empty()) return false;
    const std::string file = shown(error.file);
    int begin = 0, end = INT_MAX;  // of the construct
    for (const check::Construct& construct : base.constructs()) {
      if (construct.place.source->file != file) continue;
      if (construct.place.line <= error.line) begin = std::max(begin, construct.place.line);
      if (construct.place.line > error.line) end = std::min(end, construct.place.line);
    }
    const auto says = [&](std::string_view code) { return error.message.find(code) != std::string::npos; };
    const bool refused = says("[CSTRNCHK1]");
    const std::string_view code = refused ? "unknown-symbol" : says("[TMPLTDEF1]") ? "unknown-slot" : "defined-twice";
    if (std::ranges::any_of(found, [&](const check::Finding& finding) {
          return finding.file == file && finding.line >= begin && finding.line < end && finding.code == code;
        }))
      return true;
    if (!refused) return false;
    for (const check::Construct& construct : base.constructs())
      if (construct.place.source->file == file && construct.place.line == begin)
        found.push_back({file, line_of(error, construct), "unknown-symbol",
                         "a value is one that its template does not allow; correct it, or add it to "
                         "allowed-values (" +
                             error.message + ')'});
    return true;
  }

  Status examine(std::vector<check::Source> sources, check::Outside outside, const std::vector<Error>& errors,
                 const std::string& title) {
    for (const check::Source& source : sources)
      if (source.judged && judged_files_.insert(source.file).second) judged_.push_back(source);
    const auto base = check::RuleBase::read(std::move(sources), std::move(outside));
    if (!base) return base.error();
    for (const check::Construct& construct : base->constructs())
      if (construct.is_rule() && construct.judged()) rules_.insert(construct.place.text());
    std::vector<check::Finding> found = check::examine(*base);
    for (const Error& error : errors) {
      if (is_finding(error, *base, found)) continue;
      const std::string file = shown(error.file);
      if (error.line <= 0 ||
          std::ranges::none_of(judged_, [&](const check::Source& source) { return source.file == file; }))
        return error;
      found.push_back({file, error.line, "not-loaded", "this does not load: " + error.message});
    }
    checked_.findings.insert(checked_.findings.end(), found.begin(), found.end());
    if (options_.graph && checked_.graph.empty())
      checked_.graph = options_.dot ? check::graph_dot(*base, title) : check::graph_svg(*base, title);
    return {};
  }

  const CheckOptions& options_;
  const Catalogue& catalogue_;
  const Host& host_;
  std::vector<fs::path> own_;
  std::vector<std::unique_ptr<Opening>> openings_;
  std::vector<check::Source> judged_;
  std::set<std::string> judged_files_, rules_;
  Checked checked_;
};

}  // namespace

Expected<Checked> check_rules(const CheckOptions& options, const Catalogue& catalogue, const Host& host) {
  return Checker(options, catalogue, host).check();
}

}  // namespace cxlab::lab
