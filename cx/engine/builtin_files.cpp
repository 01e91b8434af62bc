// Functions of CLIPS that use files: the paths that they may really use, and binary files.

#include <sys/stat.h>
#include <xxhash.h>

#include <filesystem>
#include <random>

#include "cx/base/file.h"
#include "cx/base/remedy.h"
#include "cx/engine/form_reader.h"
#include "internal/builtins.h"

namespace cxlab {

using namespace clips;

namespace {

constexpr const char* kNoFiles = "rules may not use files here: ";

/// Replaces a path that rules name by the one to use; false after an error.
bool take_path(UDFContext* context, UDFValue& arg, UDFValue* result, bool reads) {
  const std::string named = arg.lexemeValue->contents;
  FileAccess* files = engine_of(context).options().files;
  if (files == nullptr) {
    refuse(context, result, kNoFiles + named);
    return false;
  }
  const Expected<std::string> allowed = reads ? files->for_reading(named) : files->for_writing(named);
  if (!allowed) {
    refuse(context, result, allowed.error().message);
    return false;
  }
  arg.lexemeValue = CreateString(context->environment, allowed->c_str());
  return true;
}

std::size_t size_of(const char* path) {
  std::error_code none;
  const std::uintmax_t size = std::filesystem::file_size(path, none);
  return none ? 0 : size;
}

/// The hash of a file's content with a key that rules cannot know, so that they cannot forge it; nothing if the file
/// cannot be read.
std::optional<BinaryHash> hash_of(const char* path) {
  static const std::uint64_t key = [] {
    std::random_device chance;
    return (std::uint64_t{chance()} << 32) | chance();
  }();
  const auto content = read_file(path);
  if (!content) return std::nullopt;
  const XXH128_hash_t hash = XXH3_128bits_withSeed(content->data(), content->size(), key);
  return BinaryHash{hash.high64, hash.low64};
}

}  // namespace

void open_function(Environment* env, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  constexpr int kMostFiles = 250;
  int files = 0;
  for (const fileRouter* file = file_router_data(env)->ListOfFileRouters; file != nullptr; file = file->next) ++files;
  if (files >= kMostFiles)
    return refuse(context, result, std::to_string(files) + " files are open, which is the most; (close) closes them");
  std::string mode = "r";
  if (args.size() > 2 && args[2].header->type == STRING_TYPE) mode = args[2].lexemeValue->contents;
  if (take_path(context, args[0], result, mode == "r" || mode == "rb")) call_original(context, result, args);
}

/// What lies between the end of a file and a place beyond it counts as written, as those who read the file get it.
void seek_function(Environment* env, UDFContext* context, UDFValue* result) {
  builtin_of(context).original(env, context, result);
  for (const fileRouter* file = file_router_data(env)->ListOfFileRouters; file != nullptr; file = file->next) {
    struct stat found{};
    if (std::fflush(file->stream) != 0 || fstat(fileno(file->stream), &found) != 0) continue;
    const long place = std::ftell(file->stream);
    if (place > found.st_size) Charge::written(static_cast<std::size_t>(place - found.st_size));
  }
  impl_of(context).glance_at_limits();
}

void read_file_function(Environment*, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  const std::string named = args[0].lexemeValue->contents;
  if (!take_path(context, args[0], result, true)) return;
  count_parsed(context, size_of(args[0].lexemeValue->contents));
  if (UDFContextFunctionName(context) != std::string_view("fetch")) {
    const auto text = read_file(args[0].lexemeValue->contents);
    if (const std::string excess = text ? excess_of(*text) : std::string(); !excess.empty())
      return refuse(context, result, "'" + named + "': " + excess);
  }
  call_original(context, result, args);
}

/// `toss`, `get-region` and `print-region`, which name a file that `fetch` read by the path under which that was
/// opened.
void region_function(Environment*, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  const std::size_t file = UDFContextFunctionName(context) == std::string_view("print-region") ? 1 : 0;
  if (take_path(context, args[file], result, true)) call_original(context, result, args);
}

void write_file_function(Environment*, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args) || !take_path(context, args[0], result, false)) return;
  call_original(context, result, args);
  impl_of(context).glance_at_limits();
}

/// `remove` and `rename`. What they find outside of the run's folder, where trusted rules act, is for the input log.
void change_file_function(Environment* env, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  for (UDFValue& path : args)
    if (!take_path(context, path, result, false)) return;
  if (!engine_of(context).options().trust_rules) return call_original(context, result, args);
  const Value done = impl_of(context).look_outside(UDFContextFunctionName(context), [&] {
    UDFValue answer;
    call_original(context, &answer, args);
    return Value::symbol(answer.lexemeValue->contents);
  });
  result->lexemeValue = CreateSymbol(env, done.text().c_str());
}

void write_binary_function(Environment*, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args) || !take_path(context, args[0], result, false)) return;
  call_original(context, result, args);
  Charge::written(size_of(args[0].lexemeValue->contents));
  impl_of(context).glance_at_limits();
  if (const auto hash = hash_of(args[0].lexemeValue->contents))
    engine_of(context).options().files->binaries.insert(*hash);
}

void read_binary_function(Environment*, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  const std::string named = args[0].lexemeValue->contents;
  if (!take_path(context, args[0], result, true)) return;
  const EngineOptions& options = engine_of(context).options();
  const auto hash = hash_of(args[0].lexemeValue->contents);
  if (hash && !options.files->binaries.contains(*hash) && !options.trust_rules)
    return refuse(
        context, result,
        "'" + named +
            "' is not as a bsave function of this run wrote it, and CLIPS reads binary files without a check (" +
            kTrustRemedy + ')');
  call_original(context, result, args);
}

namespace {

/// `load`, `load*`, `batch`, `batch*`: form by form, as files loaded by the host. TRUE unless a construct was refused
/// (load) or the file could not be read.
void load_forms(UDFContext* context, UDFValue* result, LoadMode mode) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  const std::string path = args[0].lexemeValue->contents;
  RuleEngine& engine = engine_of(context);
  if (engine.options().files == nullptr) return refuse(context, result, kNoFiles + path);
  const Nesting nesting(context, result);
  if (!nesting) return;
  LoadReport report = engine.load_file(path, mode, impl_of(context).on_load_error);
  const bool readable = report.errors.empty() || report.errors.front().line != 0;
  result->lexemeValue = CreateBoolean(context->environment, mode == LoadMode::kBatch ? readable : report.ok());
  if (!readable) {
    // As in CLIPS an error of the call, after which the rule goes on.
    const std::string& why = report.errors.front().message;
    complain(context, why.find(path) == std::string::npos ? path + ": " + why : why);
    return;
  }
  for (RuleError& error : report.errors) impl_of(context).add_error(std::move(error));
}

}  // namespace

void load_function(Environment*, UDFContext* context, UDFValue* result) {
  load_forms(context, result, LoadMode::kConstructs);
}

void batch_function(Environment*, UDFContext* context, UDFValue* result) {
  load_forms(context, result, LoadMode::kBatch);
}

}  // namespace cxlab
