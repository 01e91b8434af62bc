// Calls of functions: those of CLIPS and of all plugins of cxlab, with values of every type. Each byte chooses: first
// whether a rule calls them or the host, then function, arguments and their values, one after the other.

#include <clips_ns/clips.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "cx/base/file.h"
#include "cx/plugins/builtin.h"
#include "tests/fuzz/surroundings.h"

namespace fuzz_functions {
namespace {

namespace fs = std::filesystem;

constexpr const char* kConfiguration = R"(clips_manager:
  ros__parameters:
    environments: ["main"]
    main: {plugins: [executive, ament_index, config, ros_msgs, ros_param, protobuf, tf, string, files]}
    executive: {plugin: "cx::ExecutivePlugin"}
    ament_index: {plugin: "cx::AmentIndexPlugin"}
    config: {plugin: "cx::ConfigPlugin"}
    ros_msgs: {plugin: "cx::RosMsgsPlugin"}
    ros_param: {plugin: "cx::RosParamPlugin"}
    protobuf: {plugin: "cx::ProtobufPlugin", pkg_share_dirs: ["talk"], proto_paths: ["proto"]}
    tf: {plugin: "cx::Tf2PoseTrackerPlugin"}
    string: {plugin: "cx::CXStdMsgsStringPlugin"}
    files: {plugin: "cx::FileLoadPlugin"}
)";

/// What calls may have as arguments beside constants: facts, instances and messages, of which some go.
constexpr const char* kWorld = R"(
(deftemplate order (slot id (type INTEGER)) (slot state (type SYMBOL) (default OPEN)) (multislot parts))
(defclass ROBOT (is-a USER) (role concrete) (pattern-match reactive) (slot speed (default 1)) (multislot load))
(defmessage-handler ROBOT run (?by) (bind ?self:speed ?by))
(defglobal ?*fact* = FALSE ?*gone* = FALSE ?*instance* = FALSE ?*no-instance* = FALSE ?*message* = FALSE ?*no-message* = FALSE ?*beacon* = FALSE)
(deffunction twice (?x) (create$ ?x ?x))
(defgeneric kind)
(defmethod kind ((?x NUMBER)) number)
(defmethod kind ((?x LEXEME) $?rest) lexeme)
(defrule see (order (id ?id) (parts $?a ?b $?)) (not (order (id ?c&:(> ?c ?id)))) (object (is-a ROBOT) (speed ?s)) =>)
(deffacts some (order (id 1) (parts a b c)) (order (id 2)) (time 1 2.5))
(reset)
(make-instance r1 of ROBOT)
(make-instance r2 of ROBOT (load a 1 "x"))
(bind ?*fact* (assert (order (id 3))))
(bind ?*gone* (assert (order (id 4))))
(retract ?*gone*)
(bind ?*instance* (instance-address [r1]))
(bind ?*no-instance* (instance-address [r2]))
(unmake-instance [r2])
(bind ?*message* (ros-msgs-create-message "geometry_msgs/msg/PoseStamped"))
(bind ?*no-message* (ros-msgs-create-message "std_msgs/msg/String"))
(ros-msgs-destroy-message ?*no-message*)
(bind ?*beacon* (pb-create "example.Beacon"))
(pb-set-field ?*beacon* robot "R1")
(pb-peer-create-local "127.0.0.1" 1 1)
(pb-peer-create-local-crypto "127.0.0.1" 1 1 "key" "aes-128-cbc")
)";

constexpr const char* kValues[] = {"0",
                                   "1",
                                   "-1",
                                   "2",
                                   "9223372036854775807",
                                   "-9223372036854775808",
                                   "4294967296",
                                   "1000000",
                                   "0.0",
                                   "-1.5",
                                   "1e308",
                                   "1e-308",
                                   "(/ 0.0 1e-308)",
                                   "(** 10 400)",
                                   "(- (** 10 400) (** 10 400))",
                                   "TRUE",
                                   "FALSE",
                                   "nil",
                                   "x",
                                   "main",
                                   "order",
                                   "id",
                                   "parts",
                                   "state",
                                   "ROBOT",
                                   "USER",
                                   "OBJECT",
                                   "speed",
                                   "load",
                                   "run",
                                   "kind",
                                   "twice",
                                   "see",
                                   "MAIN",
                                   "some",
                                   "all",
                                   "t",
                                   "stdout",
                                   "log",
                                   "*",
                                   "?",
                                   "\"\"",
                                   "\"x\"",
                                   "\"%d %s %5.3f\"",
                                   "\"(+ 1 2)\"",
                                   "\"(order (id 5))\"",
                                   "\"geometry_msgs/msg/PoseStamped\"",
                                   "\"std_msgs/msg/String\"",
                                   "\"pose.position.x\"",
                                   "\"header\"",
                                   "\"data\"",
                                   "\"file.txt\"",
                                   "\"/tmp\"",
                                   "\"r\"",
                                   "\"w\"",
                                   "\"base_link\"",
                                   "\"map\"",
                                   "\"\xc3\xa4\xff\"",
                                   "[r1]",
                                   "[r2]",
                                   "[nobody]",
                                   "?*fact*",
                                   "?*gone*",
                                   "?*instance*",
                                   "?*no-instance*",
                                   "?*beacon*",
                                   "\"example.Position\"",
                                   "position",
                                   "seen",
                                   "?*message*",
                                   "?*no-message*",
                                   "(create$)",
                                   "(create$ a 1 2.5)",
                                   "(create$ 3 1 2)",
                                   "(create$ ?*fact* ?*gone* ?*instance*)",
                                   "(printout nil x)",
                                   "(twice ?*message*)",
                                   "(random)",
                                   "(gensym*)",
                                   "(str-cat \"aaaaaaaaaaaaaaaa\" \"bbbbbbbbbbbbbbbbbbbb\")",
                                   "(assert (order (id 9)))",
                                   "?value",
                                   "$?value"};

class Choices {
 public:
  Choices(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  bool left() const { return at_ < size_; }
  std::size_t below(std::size_t n) {
    std::size_t value = next();
    if (n > 256) value = value * 256 + next();
    return value % n;
  }

 private:
  std::size_t next() { return at_ < size_ ? data_[at_++] : 0; }

  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};

std::vector<std::string> functions_of(const cxlab::RuleEngine& engine) {
  // They end the process or the input on purpose.
  static const std::set<std::string> kLeftOut{"exit", "while", "loop-for-count"};
  std::vector<std::string> names;
  for (const clips::FunctionDefinition* f = clips::GetFunctionList(engine.raw()); f != nullptr; f = f->next)
    if (!kLeftOut.contains(f->callFunctionName->contents)) names.emplace_back(f->callFunctionName->contents);
  std::sort(names.begin(), names.end());
  return names;
}

std::string value_of(Choices& choices, const std::vector<std::string>& functions, int depth);

std::string call_of(Choices& choices, const std::vector<std::string>& functions, int depth) {
  std::string call = '(' + functions[choices.below(functions.size())];
  for (std::size_t i = choices.below(6); i > 0; --i) call += ' ' + value_of(choices, functions, depth);
  return call + ')';
}

std::string value_of(Choices& choices, const std::vector<std::string>& functions, int depth) {
  const std::size_t chosen = choices.below(std::size(kValues) + 3);
  if (chosen < std::size(kValues)) return kValues[chosen];
  return depth > 0 ? call_of(choices, functions, depth - 1) : "(create$ 1)";
}

void play(cxlab::RuleEngine& engine, Choices choices) {
  const bool in_rule = choices.below(2) == 1;
  static const std::vector<std::string> functions = functions_of(engine);
  std::string rule = "(defrule calls => (bind ?value 1)";
  for (int i = 0; i < 24 && choices.left(); ++i) {
    const std::string call = call_of(choices, functions, 2);
    if (in_rule)
      rule += "\n " + call;
    else
      (void)engine.eval(call);
  }
  if (in_rule) (void)engine.load_text(rule + ')', "calls.clp", cxlab::LoadMode::kConstructs);
  for (int i = 0; i < 3; ++i) (void)engine.run(50);
}

}  // namespace

/// CLIPS forgets small blocks on errors of many functions.
FUZZ_TARGET(functions, "detect_leaks=0") {
  using namespace cxlab;
  if (size == 0) return 0;
  cx::ManagerOptions options;
  options.config = fuzz::folder() / "config.yaml";
  static const bool written = write_file(options.config, kConfiguration).ok();
  fuzz::promise(written, "the configuration is written");
  options.plugin_types = cx::builtin_plugins();
  options.packages["example"] = {fs::path(CXLAB_SOURCE_DIR) / "docs/examples/file_load", {}};
  options.packages["talk"] = {fs::path(CXLAB_SOURCE_DIR) / "docs/examples/protobuf", {}};
  fuzz::live(std::move(options), 2, [&](cx::EnvironmentManager& manager) {
    RuleEngine& engine = manager.environment(0).engine();
    const LoadReport world = engine.load_text(kWorld, "world.clp", LoadMode::kBatch);
    fuzz::promise(world.ok(), "the world loads: " + (world.ok() ? std::string() : world.errors.front().text()));
    play(engine, Choices(data, size));
  });
  return 0;
}

}  // namespace fuzz_functions
