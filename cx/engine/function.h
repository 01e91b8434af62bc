#pragma once
// Functions that rules call and C++ answers.

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include "cx/engine/value.h"

namespace cxlab {

class RuleEngine;

inline constexpr std::uint16_t kAnyNumberOfArguments = 0xFFFF;

/// May a function be called on a left-hand side? An acting one changes facts or queues something for the bus.
enum class FunctionKind : std::uint8_t { kPure, kActing };

/// The declaration of a function for CLIPS. Type codes: `s` string, `y` symbol, `l` integer, `d` float, `b` boolean,
/// `e` external address, `m` multifield, `f` fact address, `i` `n` instances, `v` void, `*` any.
struct FunctionSpec {
  std::string name = {};
  std::string returns = "*";
  std::uint16_t min_args = 0;
  std::uint16_t max_args = kAnyNumberOfArguments;
  /// Default type, then one entry an argument: ";sy;l" = any by default, first lexeme, second integer. Empty = any.
  std::string arg_types = {};
  FunctionKind kind = FunctionKind::kActing;
  std::string owner = {};  ///< the plugin, named when it has been unloaded
  std::string doc = {};    ///< one line
};

/// One running call. Its arguments are evaluated and have the types of the spec. Without a `give`, the call returns
/// nothing (void).
class Call {
 public:
  RuleEngine& engine() const { return engine_; }
  const FunctionSpec& spec() const { return spec_; }

  std::size_t size() const { return args_.size(); }
  const ValueRef& arg(std::size_t i) const { return args_[i]; }
  std::string_view text(std::size_t i) const { return args_[i].text(); }
  std::int64_t integer(std::size_t i) const { return args_[i].as_integer(); }
  double number(std::size_t i) const { return args_[i].as_number(); }
  Handle handle(std::size_t i) const { return args_[i].as_handle(); }

  void give_integer(std::int64_t v);
  void give_number(double v);
  void give_symbol(std::string_view text);
  void give_string(std::string_view text);
  void give_boolean(bool v);
  void give_handle(Handle id);
  void give_integers(std::span<const std::int64_t> values);
  void give_numbers(std::span<const double> values);
  void give_handles(std::span<const Handle> values);
  void give_strings(std::span<const std::string> values);
  void give_list(std::span<const Value> values);
  void give(const Value& value);
  /// Returns the argument itself, for example to hand a multifield through.
  void give_arg(std::size_t i);

  /// Ends the call with an error: the message goes to `stderr` in the manner of CLIPS and the rest of the rule is
  /// skipped, as UDFThrowError does.
  void fail(std::string_view message);
  /// The same error, but silent on `stderr`, and the rule goes on: where the plugins of CX only log.
  void complain(std::string_view message);
  bool failed() const { return failed_; }

  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

 private:
  friend struct CallFrame;
  Call(RuleEngine& engine, const FunctionSpec& spec, void* context, void* result)
      : engine_(engine), spec_(spec), context_(context), result_(result) {}

  RuleEngine& engine_;
  const FunctionSpec& spec_;
  void* context_;
  void* result_;
  std::span<const ValueRef> args_;
  bool failed_ = false;
};

using Function = std::function<void(Call&)>;

}  // namespace cxlab
